"""A dictionary of generic forces and sensor shifts, for what no named cause explains.

Each feature is a time series made from the filter's own states and the record's inputs, added to one force or one
channel.  Zero-mean gusts with one correlation time depend on none of them, so a feature that raises the likelihood is
the mark of an unmodelled effect.  Their names are what a user reads of it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import lagged
from ...estimation.filters.innovations.settings import Parameter
from ...estimation.filters.innovations.vector import SENSORS, SYMBOLS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations


LAGS_S = (5.0, 12.0, 30.0, 75.0)
LINES = (0.08, 0.6)
"""Angular frequencies of periodic moments that are tried, rad/s for a 160 m ship."""
MOST_LINES = 400
"""Frequencies that are tried; all of them in records of 40 minutes for a 160 m ship."""
WINDOWS = 24
"""Windows a record is cut into for effects that act for a while."""
LEVER = "share of the yaw rate in"
YAW_RATE_IN_HEADING = f"{LEVER} the recorded heading"
"""What a heading that is late or early by a constant time shows: recorded(t) - true(t) = -tau r."""

SHAPES = (
    "scale that grows with",
    "unequal scale to both sides of",
    LEVER,
    "jump of",
    "curved drift of",
)
"""What may be wrong with one channel."""


@dataclass(frozen=True)
class Feature:
    """A unit-size series (one array (T,) a record) added to axis `axis` (a force, or channel axis - nf)."""

    name: str
    axis: int
    series: tuple[np.ndarray, ...]
    family: str

    @property
    def key(self) -> str:
        """Name and axis."""
        return f"{self.name}:{self.axis}"

    def parameter(self) -> Parameter:
        """The feature's size as a parameter of the filter."""
        return Parameter(self.key, "", series=(self.axis, self.series), scale=1e-6)


def features(est: Estimator, now: Innovations) -> list[Feature]:
    """The dictionary at a setting: every basis series on every force, and slow shifts of every channel."""
    basis: dict[str, tuple[str, list[np.ndarray]]] = {}
    for i, d in enumerate(est.segments):
        for name, (family, values) in _basis(est, now.states[est.samples_of(i)], d.time, d.rudder).items():
            basis.setdefault(name, (family, []))[1].append(values)
    nf, out = est.n_forces, []
    for name, (family, arrays) in basis.items():
        series = _standard(arrays)
        if series is None:
            continue
        out += [Feature(name, axis, series, family) for axis in range(nf)]
    ramp = _standard([d.time / d.time[-1] - 0.5 for d in est.segments])
    for c in np.flatnonzero(est.channels).tolist():
        if ramp is not None:
            out.append(Feature(f"drift of the recorded {word(c)}", nf + c, ramp, "sensor"))
        for kind, arrays in _channel_shapes(est, now, c).items():
            series = _standard(arrays)
            if series is not None:
                out.append(Feature(f"{kind} the recorded {word(c)}", nf + c, series, "sensor"))
    return out


def word(channel: int) -> str:
    """A channel's name as a word: `yaw rate`."""
    return SENSORS[channel].replace("_", " ")


def _standard(arrays: Sequence[np.ndarray]) -> tuple[np.ndarray, ...] | None:
    size = np.sqrt(np.mean(np.concatenate(arrays) ** 2))
    if not np.isfinite(size) or size < 1e-12:
        return None
    return tuple(np.ascontiguousarray(a / size) for a in arrays)


Basis = dict[str, tuple[str, np.ndarray]]


def _basis(est: Estimator, states: np.ndarray, time: np.ndarray, rudder: np.ndarray) -> Basis:
    """Series of one segment by name: family and values (T,)."""
    signals = _signals(est, states, rudder)
    psi = states[:, est.kernels.STATES.index("psi")]
    basis = _nonlinear(signals) | _memory(est, signals, time) | _of_time(signals, time) | _of_heading(signals, psi)
    return basis | (_of_place(est, signals, states) if est.model.is_3dof else {})


def _signals(est: Estimator, states: np.ndarray, rudder: np.ndarray) -> dict[str, np.ndarray]:
    """Yaw rate, rudder, and for 3-DOF models sway and the change of speed, of unit size."""
    names = list(est.kernels.STATES)
    raw = {"yaw rate": states[:, names.index("r")], "rudder": np.clip(rudder, -10.0, 10.0)}
    if est.model.is_3dof:
        speed = states[:, names.index("u")] / est.model.speed_m_s
        raw |= {"sway": states[:, names.index("v")], "change of speed": speed - 1.0}
    return {name: x / max(np.std(x), 1e-9) for name, x in raw.items()}


def _nonlinear(signals: Mapping[str, np.ndarray]) -> Basis:
    """Powers, sizes and products."""
    out: Basis = {}
    keys = list(signals)
    for i, a in enumerate(keys):
        x = signals[a]
        out[a] = ("linear", x)
        out[f"|{a}|"] = ("even", np.abs(x))
        out[f"{a}^2"] = ("even", x**2)
        out[f"{a} |{a}|"] = ("odd", x * np.abs(x))
        out[f"{a}^3"] = ("odd", x**3)
        beyond = np.maximum(np.abs(x) - np.quantile(np.abs(x), 0.75), 0.0)
        out[f"{a} beyond its upper quartile"] = ("odd", np.sign(x) * beyond)
        out[f"{a} limited to 0.3 of its sd"] = ("odd", np.clip(x, -0.3, 0.3))
        out[f"positive {a}"] = ("even", np.maximum(x, 0.0))
        for b in keys[i + 1 :]:
            y = signals[b]
            out[f"{a} * {b}"] = ("product", x * y)
            out[f"{a} |{b}|"] = ("product", x * np.abs(y))
            out[f"{b} |{a}|"] = ("product", y * np.abs(x))
            out[f"{a}^2 * {b}"] = ("product", x**2 * y)
            out[f"{a} * {b}^2"] = ("product", x * y**2)
    return out


def _memory(est: Estimator, signals: Mapping[str, np.ndarray], time: np.ndarray) -> Basis:
    """What comes late, and rates of change."""
    out: Basis = {}
    step_s = float(np.median(np.diff(time)))
    for a, x in signals.items():
        for lag in LAGS_S:
            out[f"{a} with a lag of {lag:g} s (of a 160 m ship)"] = ("memory", lagged(x, lag * est.clock, step_s))
        out[f"side of the {a} with a lag"] = ("memory", np.sign(lagged(x, 12.0 * est.clock, step_s)))
        rate = np.gradient(lagged(x, 2.0 * est.clock, step_s), time)
        rate /= max(np.std(rate), 1e-12)
        out[f"rate of change of the {a}"] = ("rate", rate)
        out[f"|rate of change of the {a}|"] = ("rate", np.abs(rate))
    return out


def _of_time(signals: Mapping[str, np.ndarray], time: np.ndarray) -> Basis:
    """Slow changes over the record."""
    part = time / time[-1] - 0.5
    out: Basis = {"time": ("drift", part), "time^2": ("drift", part**2 - 1.0 / 12.0)}
    return out | {f"time * {a}": ("drift", part * x) for a, x in signals.items()}


def _of_heading(signals: Mapping[str, np.ndarray], psi: np.ndarray) -> Basis:
    """What depends on the course."""
    out: Basis = {}
    for m, angle in enumerate(("heading", "2 heading", "3 heading"), start=1):
        out[f"cos({angle})"] = ("heading", np.cos(m * psi))
        out[f"sin({angle})"] = ("heading", np.sin(m * psi))
    for wave, label in ((np.cos(psi), "cos"), (np.sin(psi), "sin")):
        for a in ("yaw rate", "rudder"):
            out[f"{a} * {label}(heading)"] = ("heading", signals[a] * wave)
    return out


def _of_place(est: Estimator, signals: Mapping[str, np.ndarray], states: np.ndarray) -> Basis:
    """What depends on the position."""
    out: Basis = {}
    for state, name in (("x", "north"), ("y", "east")):
        place = states[:, est.kernels.STATES.index(state)]
        reach = place - place.mean()
        reach = reach / max(np.std(reach), 1e-9)
        out[name] = ("place", reach)
        out[f"{name}^2"] = ("place", reach**2)
        for a in ("yaw rate", "rudder"):
            out[f"{a} * {name}"] = ("place", signals[a] * reach)
    return out


def _channel_shapes(est: Estimator, now: Innovations, c: int) -> dict[str, list[np.ndarray]]:
    """Ways in which one channel alone can be wrong: growing with its value, its side, the yaw rate, or time."""
    names = list(est.kernels.STATES)
    r = now.states[:, names.index("r")]
    x = now.states[:, est.places[c]]
    curve, side, lever, jump, drift = SHAPES
    shapes = {name: [] for name in SHAPES}
    for i, d in enumerate(est.segments):
        rows = est.samples_of(i)
        own = x[rows] - x[rows].mean()
        shapes[curve].append(own**3)
        shapes[side].append(np.abs(own))
        shapes[lever].append(r[rows])
        shapes[jump].append(np.sign(d.time - 0.5 * d.time[-1]))
        part = d.time / d.time[-1] - 0.5
        shapes[drift].append(part**2 - 1.0 / 12.0)
    if SYMBOLS[c] == "r":
        del shapes[lever]
    return shapes


def pulses(est: Estimator) -> list[list[tuple[np.ndarray, ...]]]:
    """Unit series over each window of each record, and last of all records at the same time: [record][window]."""
    out, everywhere = [], []
    for i, d in enumerate(est.segments):
        edges = np.linspace(0.0, d.time[-1] + 1e-9, WINDOWS + 1)
        still = [np.zeros(other.time.size) for other in est.segments]
        inside = [(d.time >= start) & (d.time < end) for start, end in pairwise(edges)]
        out.append([(*still[:i], own.astype(float), *still[i + 1 :]) for own in inside])
    longest = max(d.time[-1] for d in est.segments) + 1e-9
    for start, end in pairwise(np.linspace(0.0, longest, WINDOWS + 1)):
        everywhere.append(tuple(((d.time >= start) & (d.time < end)).astype(float) for d in est.segments))
    return [*out, everywhere]


def lines(est: Estimator, now: Innovations) -> tuple[list[tuple[Feature, Feature]], int]:
    """Yaw moments at a fixed frequency, cosine and sine over the record's time, at frequencies half a bin apart, and
    how many there are; of more than MOST_LINES those are made where the innovations have most power."""
    longest = max(d.time[-1] for d in est.segments)
    axis = est.n_forces - 1 if est.model.is_3dof else 0
    every = np.arange(LINES[0] / est.clock, LINES[1] / est.clock, np.pi / longest)
    chosen = every
    if every.size > MOST_LINES:
        chosen = np.sort(every[np.argsort(_power(est, now, every))[-MOST_LINES:]])
    out = []
    for omega in chosen:
        waves = [tuple(wave(omega * d.time) for d in est.segments) for wave in (np.cos, np.sin)]
        pair = zip(("cos", "sin"), waves, strict=True)
        cosine, sine = (Feature(f"{name}({omega:.3g} rad/s * time)", axis, arrays, "line") for name, arrays in pair)
        out.append((cosine, sine))
    return out, every.size


def _power(est: Estimator, now: Innovations, frequencies: np.ndarray) -> np.ndarray:
    """Power of the innovations of all channels at frequencies (F,), rad/s, over the records' common time."""
    step = min(float(np.median(np.diff(d.time))) for d in est.segments)
    places = np.concatenate([np.rint(d.time / step).astype(int) for d in est.segments])
    length = 2 * (places.max() + 1)
    sums = [np.bincount(places, weights=of_channel, minlength=length) for of_channel in now.e.T]
    power = np.sum([np.abs(np.fft.rfft(one)) ** 2 for one in sums], axis=0)
    return power[np.rint(frequencies * length * step / (2.0 * np.pi)).astype(int).clip(max=power.size - 1)]
