"""Manoeuvres: a short text such as ``zigzag:20/20`` becomes the closed loop that steers a model.

In the text angles count positive to starboard; `Manoeuvre.control` turns them into the vessel's own
rudder sign (``model.positive_rudder``). ``KINDS`` holds one entry per kind: its form and a description, from
`manoeuvres.yaml`, how its text is read and how its control is built. Every text may end in ``@euler``: the run is
then advanced by one explicit Euler step per sample, which makes a record of the model's own difference equation.

Manoeuvres with an execute (zigzag, turn, pullout) steer a straight course first, for the vessel suite's
``execute_s`` or else the smaller of 10 s and 5 % of the duration; the others start at time zero.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from ..models.data_file import load
from ..models.errors import BadInput
from ..models.model import Model, RudderGear
from ..models.simulate import ClosedLoop
from ..models.suggestions import suggestion
from .grammar import ANGLE, DEGREE, TIME, plain, positive
from .record import Record

PERIOD = {"s": 1.0, "rad_s": 1.0}


SIDES = {":port": -1, ":starboard": 1}
"""End of a text -> first side, +1 starboard, -1 port; starboard where none is named."""
RUDDER_MAX = 90.0 * DEGREE
Reader: TypeAlias = Callable[[str], tuple[tuple[float, ...], str]]
"""Reads what stands behind the colon: its numbers in SI units and radians, and the canonical text."""


def _degrees(text: str, default: str | None = "deg") -> tuple[float, str]:
    """An angle in rad, and its text in degrees: without the unit where it need not stand there."""
    value = positive(text, ANGLE, default)
    if value > RUDDER_MAX:
        raise ValueError(f"{text!r} is above 90 deg")
    return value, f"{plain(value / DEGREE)}{'' if default else 'deg'}"


def _seconds(text: str) -> tuple[float, str]:
    value = positive(text, TIME)
    return value, f"{plain(value)}s"


def _frequency(text: str) -> tuple[float, str]:
    """A frequency in rad/s of a period, or of one with the unit rad_s."""
    number, unit = positive(text, PERIOD), "rad_s" if text.endswith("rad_s") else "s"
    return number if unit == "rad_s" else 2.0 * math.pi / number, f"{plain(number)}{unit}"


def _numbers(*parts: Callable[[str], tuple[float, str]], least: int) -> Reader:
    """A reader of numbers between slashes, each by its part; those behind the first `least` may be left out."""

    def read(rest: str) -> tuple[tuple[float, ...], str]:
        cells = rest.split("/") if rest else []
        if not least <= len(cells) <= len(parts):
            raise ValueError(f"{rest!r} is not of this form" if parts else f"nothing may follow, found {rest!r}")
        found = [part(cell) for part, cell in zip(parts, cells, strict=False)]
        return tuple(value for value, _ in found), "/".join(text for _, text in found)

    return read


_stated_degrees = partial(_degrees, default=None)
_clocked, _tone = _numbers(_stated_degrees, _seconds, least=2), _numbers(_stated_degrees, _frequency, least=2)


def _read_spiral(rest: str) -> tuple[tuple[float, ...], str]:
    """`RUDDER[/STEP]` in degrees; STEP is a fifth of RUDDER by default and divides it."""
    (top, *step), text = _numbers(_degrees, _degrees, least=1)(rest)
    by = step[0] if step else top / 5.0
    if abs(top / by - round(top / by)) > 1e-9:
        raise ValueError(f"the step does not divide the angle in {rest!r}")
    return (top, by), text


def _read_tones(rest: str) -> tuple[tuple[float, ...], str]:
    """Amplitude, rad, and frequency, rad/s, of each sine; the sines are joined by +."""
    tones = [_tone(text) for text in rest.split("+")]
    return tuple(number for own, _ in tones for number in own), "+".join(text for _, text in tones)


EULER = "@euler"

# Feedback taps of maximum-length shift registers, by order (Alfke, Xilinx XAPP 052, 1996).
TAPS = {
    3: (3, 2), 4: (4, 3), 5: (5, 3), 6: (6, 5), 7: (7, 6), 8: (8, 6, 5, 4), 9: (9, 5), 10: (10, 7),
    11: (11, 9), 12: (12, 6, 4, 1), 13: (13, 4, 3, 1), 14: (14, 5, 3, 1), 15: (15, 14), 16: (16, 15, 13, 4),
    17: (17, 14), 18: (18, 11), 19: (19, 6, 2, 1), 20: (20, 17),
}  # fmt: skip
SHORTEST_REGISTER = 7
MOST_TICKS = 100
"""Clock intervals within a sample."""


class RudderSeries(NamedTuple):
    """A free rudder series: times (N,) in s or None (one value per sample), values (N,) in rad.

    ``positive_rudder`` is the sign of the values (None: the vessel's), ``actual`` says that they are rudder
    angles, which the rudder takes sample by sample (but for the first: it starts midships) without the steering
    gear's lag and limits.
    """

    time_s: np.ndarray | None
    rudder_rad: np.ndarray
    positive_rudder: str | None = None
    actual: bool = False


class Setting(NamedTuple):
    """What a control is built for: model, sampling step, number of steps, random generator."""

    model: Model
    dt: float
    n: int
    rng: np.random.Generator

    @property
    def time_s(self) -> np.ndarray:
        """Sample times (n + 1,)."""
        return self.dt * np.arange(self.n + 1)

    @property
    def execute_s(self) -> float:
        """Time of the first execute, a whole number of samples."""
        wanted = self.model.suite.get("execute_s", min(10.0, 0.05 * self.n * self.dt))
        return self.dt * round(float(wanted) / self.dt)


@dataclass(frozen=True)
class Manoeuvre:
    """One manoeuvre, read by `parse_manoeuvre` or made by `from_series`.

    ``values`` are the numbers of the text in SI units, ``side`` is +1 (starboard first) or -1 (port first).
    """

    kind: str
    text: str
    values: tuple[float, ...] = ()
    side: int = 1
    euler: bool = False
    series: RudderSeries | None = field(default=None, compare=False, repr=False)

    @property
    def integrator(self) -> str:
        """Name of the integrator for `simulate` and `closed_loop`."""
        return "euler" if self.euler else "rk4"

    @property
    def random(self) -> bool:
        """Whether the rudder is drawn at random."""
        return KINDS[self.kind].random

    def control(self, model: Model, dt: float, duration_s: float, rng: np.random.Generator) -> ClosedLoop:
        """The closed loop that performs this manoeuvre with ``model``, sampled at ``dt`` s for ``duration_s`` s.

        Raises BadInput if the vessel lacks what the manoeuvre needs or the record is too short for it.
        """
        n = steps(dt, duration_s)
        return KINDS[self.kind].build(self, Setting(model, dt, n, rng))


@dataclass(frozen=True)
class ManoeuvreKind:
    """One kind of manoeuvre: how it is written, what it does, how it is read and built.

    ``read`` turns the text after the colon into (values in SI, canonical text); ``sided`` allows ``:port``;
    ``random`` says that the control draws from the generator.
    """

    read: Reader
    build: Callable[[Manoeuvre, Setting], ClosedLoop]
    form: str
    description: str
    sided: bool = True
    random: bool = False


def steps(dt: float, duration_s: float) -> int:
    """Number of sampling steps in ``duration_s``; BadInput unless both are positive and give at least one."""
    if not (math.isfinite(dt) and math.isfinite(duration_s) and dt > 0.0 and duration_s > 0.0):
        raise BadInput(f"sampling step {dt:g} s and duration {duration_s:g} s must be positive")
    n = round(duration_s / dt)
    if n < 1:
        raise BadInput(f"duration {duration_s:g} s is shorter than the sampling step {dt:g} s")
    return n


def parse_manoeuvre(text: str) -> Manoeuvre:
    """Read a manoeuvre text such as ``zigzag:20/20:port`` or ``sine:20deg/120s+10deg/40s@euler``.

    Raises BadInput with one line that shows the expected form.
    """
    body, euler = (text[: -len(EULER)], True) if text.endswith(EULER) else (text, False)
    name, _, rest = body.partition(":")
    kind = KINDS.get(name)
    if kind is None:
        raise BadInput(f"unknown manoeuvre {text!r}", hint=suggestion(text.partition(":")[0], KINDS))
    try:
        first, side = next(((s, n) for s, n in SIDES.items() if kind.sided and rest.endswith(s)), ("", 1))
        values, canonical = kind.read(rest.removesuffix(first))
    except ValueError as error:
        raise BadInput(f"manoeuvre {text!r}: {error}", hint=f"expected {kind.form}") from None
    parts = [name, *([canonical] if canonical else []), *(["port"] if side < 0 else [])]
    return Manoeuvre(name, ":".join(parts) + (EULER if euler else ""), values, side, euler)


def from_series(source: Record | Sequence[float] | np.ndarray, name: str | None = None) -> Manoeuvre:
    """A manoeuvre that repeats a rudder series.

    ``source`` is a Record (its rudder command, else its rudder angle, which the steering gear then leaves
    alone; interpolated linearly, time counted from its first sample, gaps bridged) or an array (N,) in rad in
    the vessel's sign, one value per sample. The last value is held if the run lasts longer. Raises BadInput for
    an array with gaps and for an empty series.
    """
    if isinstance(source, Record):
        actual = not source.has("rudder_command_rad")
        rudder = source.rudder() if actual else source.column("rudder_command_rad")
        seen = np.isfinite(rudder)
        series = RudderSeries(source.time_s[seen], rudder[seen], source.meta.positive_rudder, actual)
        label = name or source.name
    else:
        series, label = RudderSeries(None, np.asarray(source, dtype=float).ravel()), name or "array"
    if series.rudder_rad.size == 0 or not np.all(np.isfinite(series.rudder_rad)):
        raise BadInput("the rudder series is empty or holds gaps", file=label)
    return Manoeuvre("series", f"series:{label}", series=series)


# ---- building the control


def _steer(s: Setting, rudder_to_starboard: np.ndarray) -> ClosedLoop:
    """Rudder series (n + 1,), to starboard positive, through the vessel's steering gear."""
    return ClosedLoop("series", s.model.starboard * rudder_to_starboard, s.model.rudder)


def _zigzag(m: Manoeuvre, s: Setting) -> ClosedLoop:
    rudder, heading = m.values
    return ClosedLoop(
        "zigzag",
        np.zeros(s.n + 1),
        s.model.rudder,
        execute_s=s.execute_s,
        rudder_rad=s.model.starboard * rudder,
        heading_rad=heading,
        first=m.side,
    )


def _pullout(m: Manoeuvre, s: Setting) -> ClosedLoop:
    angle, *held = m.values
    until = s.execute_s + (held[0] if held else 0.5 * (s.n * s.dt - s.execute_s))
    return _steer(s, np.where(_after(s, s.execute_s) & ~_after(s, until), m.side * angle, 0.0))


def _spiral(m: Manoeuvre, s: Setting) -> ClosedLoop:
    top, step = m.values
    down = np.linspace(top, -top, 2 * round(top / step) + 1)
    levels = m.side * np.concatenate([down, down[-2::-1]])
    if s.n + 1 < levels.size:
        raise BadInput(f"{s.n} samples are too few for the {levels.size} rudder angles of {m.text}")
    return _steer(s, levels[np.arange(s.n + 1) * levels.size // (s.n + 1)])


def _tones(m: Manoeuvre, time_s: np.ndarray) -> np.ndarray:
    """Sum of sines of zero phase (N,), to starboard positive."""
    tones = zip(m.values[0::2], m.values[1::2], strict=True)
    return m.side * sum((a * np.sin(w * time_s) for a, w in tones), np.zeros_like(time_s))


def _prbs(m: Manoeuvre, s: Setting) -> ClosedLoop:
    size, clock = m.values
    tick = _ticks(s, clock)
    count = int(tick[-1]) + 1
    order = min(max(SHORTEST_REGISTER, count.bit_length()), max(TAPS))  # the least whose period covers all bits
    bits = shift_register(order, count, s.rng)
    return _steer(s, size * (2.0 * bits[tick] - 1.0))


def _random_steps(m: Manoeuvre, s: Setting) -> ClosedLoop:
    size, clock = m.values
    tick = _ticks(s, clock)
    return _steer(s, s.rng.uniform(-size, size, int(tick[-1]) + 1)[tick])


def _heading(m: Manoeuvre, s: Setting) -> ClosedLoop:
    if s.model.controller is None:
        hint = "vessels with a controller block have one"
        raise BadInput(f"{s.model.id} has no heading controller, which {m.text!r} needs", hint=hint)
    gains = s.model.controller
    return ClosedLoop("heading", _tones(m, s.time_s), s.model.rudder, kp=gains.kp, kd=gains.kd)


def _series(m: Manoeuvre, s: Setting) -> ClosedLoop:
    assert m.series is not None
    time_s, rudder, sign, actual = m.series
    if time_s is None:
        held = np.full(max(s.n + 1 - rudder.size, 0), rudder[-1])
        reference = np.concatenate([rudder, held])[: s.n + 1]
    else:
        reference = np.interp(s.time_s + time_s[0], time_s, rudder)
    if sign not in (None, s.model.positive_rudder):
        reference = -reference
    if not actual:
        return ClosedLoop("series", reference, s.model.rudder)
    ahead = np.append(reference[1:], reference[-1])
    return ClosedLoop("series", ahead, RudderGear())


def _after(s: Setting, time_s: float) -> np.ndarray:
    return s.time_s >= time_s - 1e-9 * s.dt


def _ticks(s: Setting, clock_s: float) -> np.ndarray:
    """Number of the clock interval each sample lies in (n + 1,); BadInput for a clock far shorter than a sample."""
    if clock_s < s.dt / MOST_TICKS:
        raise BadInput(f"the clock of {clock_s:g} s is too short for samples every {s.dt:g} s")
    return np.floor(s.time_s / clock_s + 1e-9).astype(np.intp)


def shift_register(order: int, bits: int, rng: np.random.Generator) -> np.ndarray:
    """``bits`` values 0 or 1 of a maximum-length sequence from a random non-zero register, (bits,) int.

    The sequence repeats after ``2**order - 1``. (Golomb, Shift Register Sequences, 1967.)
    """
    state = int(rng.integers(1, 2**order))
    out = np.empty(bits, dtype=np.int64)
    for i in range(bits):
        out[i] = state & 1
        feedback = 0
        for tap in TAPS[order]:
            feedback ^= state >> (order - tap)
        state = (state >> 1) | ((feedback & 1) << (order - 1))
    return out


CONTROLS: dict[str, tuple[Reader, Callable[[Manoeuvre, Setting], ClosedLoop]]] = {
    "zigzag": (_numbers(_degrees, _degrees, least=2), _zigzag),
    "turn": (
        _numbers(_degrees, least=1),
        lambda m, s: _steer(s, np.where(_after(s, s.execute_s), m.side * m.values[0], 0.0)),
    ),
    "pullout": (_numbers(_degrees, _seconds, least=1), _pullout),
    "spiral": (_read_spiral, _spiral),
    "sine": (_read_tones, lambda m, s: _steer(s, _tones(m, s.time_s))),
    "prbs": (_clocked, _prbs),
    "steps": (_clocked, _random_steps),
    "straight": (_numbers(least=0), lambda _, s: _steer(s, np.zeros(s.n + 1))),
    "heading": (_read_tones, _heading),
    "series": (_numbers(least=1), _series),
}
"""Kind -> how its text is read, and its control built."""
KINDS: dict[str, ManoeuvreKind] = {
    name: ManoeuvreKind(*CONTROLS[name], **facts) for name, facts in load(Path(__file__).with_suffix(".yaml")).items()
}
