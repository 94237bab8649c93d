"""Sensors: what measuring does to a record, channel by channel, and the noise strings.

A noise string is a level, or quantities per channel, or both, followed by options, joined by commas::

    none | low | medium | high | gross    standard deviations from the table `NOISE`
    yaw_rate=0.05deg_s,heading=0.1deg     standard deviation of single channels (over the level's)
    medium,outliers=5%                    options apply to every sensor
    medium,heading.delay=0.5s             or, with a channel before the dot, to one

    low,only=heading+surge                channels on board, beside rudder and propeller; the others are taken out
    low,without=surge+sway                channels that nothing measures

Channels are the record's columns without their unit: rudder, heading, yaw_rate, surge, sway, north, east,
propeller, roll, roll_rate, wind_speed, wind_direction, and rudder_command (an order, not a measurement: it
takes no part in levels and general options). Channels that a record lacks are left out silently, so that
one string serves every vessel.

==========  =========================  ==========================================================================
option      value                      effect
==========  =========================  ==========================================================================
colour      ``30s``                    the noise is a Gauss-Markov process of this correlation time
bias        ``0.5deg`` or ``2sd``      added constant
scale       ``2%``                     recorded = (1 + scale) true + bias
delay       ``0.5s``                   recorded(t) = true(t - delay), interpolated; the first value before that
outliers    ``5%[/SIZE]``              share of samples with an error of SIZE to 2 SIZE, sign at random (10sd)
bursts      ``10%[/SAMPLES[/SIZE]]``   the same in runs of SAMPLES (20) samples of one sign
quantum     ``0.1deg``                 rounded to multiples
dropout     ``2%``                     share of single samples lost (nan)
gaps        ``5%[/SAMPLES]``           share of samples lost in runs of SAMPLES (20)
period      ``1s``                     values only at this sampling period, nan in between
==========  =========================  ==========================================================================

Effects apply in the order delay, scale and bias, noise, outliers, bursts, quantum, dropout, gaps, period.
Sizes in ``sd`` need a channel with noise; the order of the items does not matter. One table serves full-scale
ships and models: it describes the instruments (gyro compass, fibre-optic or MEMS gyro, Doppler log, satellite
positions), which do not shrink with the ship; for a tank model measured by cameras give the channels, e.g.
``low,north=0.005m,east=0.005m``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ..models.data_file import load
from ..models.errors import BadInput
from ..models.number_texts import whole_of
from .columns import CANONICAL, QUANTITIES, UNITS
from .grammar import DEGREE, SHARE, TIME, positive, quantity, share
from .randomness import gauss_markov, key_of, stream
from .record import Record, RecordMeta, beside

_SD = load(Path(__file__).with_name("noise.yaml"))
#: short channel name -> (column of the record, units that its quantities may have)
CHANNELS: dict[str, tuple[str, Mapping[str, float]]] = {
    name: (column, UNITS[CANONICAL[column]])
    for name, spellings in QUANTITIES.items()
    for column in (next(iter(spellings)),)
    if name in _SD or name == "rudder_command"
}
ORDERS = ("rudder_command",)
INPUTS = ("rudder_command", "rudder", "propeller")
"""Channels that `only` always keeps: what a model is driven by."""
SELECTIONS = ("only", "without")

#: standard deviation per level and channel, in the units of the record's columns
NOISE: dict[str, dict[str, float]] = {"none": {}} | {
    level: {channel: (DEGREE if sd["unit"] == "deg" else 1.0) * sd[level] for channel, sd in _SD.items()}
    for level in ("low", "medium", "high", "gross")
}

OUTLIER_SDS = 10.0
RUN_SAMPLES = 20


@dataclass(frozen=True)
class ChannelSensor:
    """One channel's sensor, in the units of its column; the defaults measure exactly.

    Parameters
    ----------
    sd, correlation_s : noise: standard deviation and correlation time (0: white).
    bias, scale : recorded = (1 + scale) true + bias.
    delay_s : recorded(t) = true(t - delay_s).
    outliers, outlier_size : share of samples with an error of size to 2 size.
    bursts, burst_samples, burst_size : the same in runs of one sign.
    quantum : rounding step.
    dropout : share of single samples lost.
    gaps, gap_samples : share of samples lost in runs.
    period_s : sampling period of the channel (0: every sample).
    """

    sd: float = 0.0
    correlation_s: float = 0.0
    bias: float = 0.0
    scale: float = 0.0
    delay_s: float = 0.0
    outliers: float = 0.0
    outlier_size: float = 0.0
    bursts: float = 0.0
    burst_samples: int = RUN_SAMPLES
    burst_size: float = 0.0
    quantum: float = 0.0
    dropout: float = 0.0
    gaps: float = 0.0
    gap_samples: int = RUN_SAMPLES
    period_s: float = 0.0


@dataclass(frozen=True)
class SensorSet:
    """Sensors of a record: column name -> `ChannelSensor`; columns without one are left as they are.

    `missing` are columns without a sensor on board: they are taken out of the record.
    """

    channels: Mapping[str, ChannelSensor] = field(default_factory=dict)
    text: str = "none"
    missing: frozenset[str] = frozenset()

    def on_board(self, record: Record) -> Record:
        """The record without the channels that nothing measures."""
        return beside(record, channels={c: v for c, v in record.channels.items() if c not in self.missing})

    def sd(self, column: str) -> float:
        """Standard deviation of a column's noise (0 if it has none)."""
        return self.channels.get(column, ChannelSensor()).sd


def apply(record: Record, sensors: SensorSet, rng: np.random.Generator, meta: RecordMeta | None = None) -> Record:
    """The record as ``sensors`` would have measured it, with other metadata where they are given.

    Every channel and every effect draws from a stream of its own, seeded by one draw from ``rng`` and its
    name: neither the presence of other channels nor other effects change what it draws.
    """
    key = key_of(rng)
    measured = {
        column: measure(record.time_s, record.column(column), sensor, lambda effect, c=column: stream(key, c, effect))
        for column, sensor in sensors.channels.items()
        if record.has(column)
    }
    return sensors.on_board(beside(record, channels={**record.channels, **measured}, meta=meta or record.meta))


def measure(
    time_s: np.ndarray, true: np.ndarray, sensor: ChannelSensor, streams: Callable[[str], np.random.Generator]
) -> np.ndarray:
    """One channel (N,) as its sensor records it; ``streams(effect)`` gives each effect its generator."""
    s, n = sensor, time_s.size
    value = (1.0 + s.scale) * delayed(time_s, true, s.delay_s) + s.bias
    if s.sd > 0.0:
        value = value + gauss_markov(time_s, s.sd, s.correlation_s, streams("noise"))
    if s.outliers > 0.0:
        value = value + outliers(n, s.outliers, s.outlier_size, streams("outliers"))
    if s.bursts > 0.0:
        value = value + bursts(n, s.bursts, s.burst_samples, s.burst_size, streams("bursts"))
    if s.quantum > 0.0:
        value = s.quantum * np.round(value / s.quantum)
    lost = streams("dropout").random(n) < s.dropout if s.dropout > 0.0 else np.zeros(n, dtype=bool)
    if s.gaps > 0.0:
        lost |= runs(n, s.gaps, s.gap_samples, streams("gaps")) >= 0
    if s.period_s > 0.0:
        lost |= ~sampled(time_s, s.period_s)
    return np.where(lost, np.nan, value)


def delayed(time_s: np.ndarray, value: np.ndarray, delay_s: float) -> np.ndarray:
    """``value(t - delay_s)`` by linear interpolation (N,); the first value before the record begins."""
    return np.interp(time_s - delay_s, time_s, value) if delay_s != 0.0 else value


def outliers(n: int, fraction: float, size: float, rng: np.random.Generator) -> np.ndarray:
    """Errors (n,): zero but for a share ``fraction``, where size to 2 size with random sign."""
    hit = rng.random(n) < fraction
    return hit * _errors(n, size, rng) * rng.choice([-1.0, 1.0], n)


def bursts(n: int, fraction: float, samples: int, size: float, rng: np.random.Generator) -> np.ndarray:
    """Errors (n,) in runs of ``samples`` that cover a share ``fraction``; one sign in each run."""
    number = runs(n, fraction, samples, rng)
    signs = rng.choice([-1.0, 1.0], max(n, 1))
    return np.where(number >= 0, _errors(n, size, rng) * signs[number], 0.0)


def _errors(n: int, size: float, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform(size, 2.0 * size, n)


def runs(n: int, fraction: float, samples: int, rng: np.random.Generator) -> np.ndarray:
    """Number of the run that each of n samples lies in, -1 outside, (n,) int.

    Non-overlapping runs of ``samples`` at random places (all placements equally likely); as many as cover
    ``fraction n`` samples, the remainder rounded at random so that the expected share is exact (as far as
    whole runs fit).
    """
    length = max(1, min(samples, n))
    count = int(fraction * n / length + rng.random())
    count = min(count, n // length)
    number = np.full(n, -1)
    free = n - count * length
    starts = np.sort(rng.choice(free + count, count, replace=False)) + np.arange(count) * (length - 1)
    for i, start in enumerate(starts.tolist()):
        number[start : start + length] = i
    return number


def sampled(time_s: np.ndarray, period_s: float) -> np.ndarray:
    """True at the first sample of every ``period_s`` from the record's start, (N,) bool."""
    tick = np.floor((time_s - time_s[0]) / period_s + 1e-9)
    return np.diff(tick, prepend=-1.0) > 0.0


# ---- noise strings


def parse_noise(text: str) -> SensorSet:
    """Read a noise string (see the module's head); BadInput with one line if it is malformed."""
    try:
        items = [item.strip() for item in text.split(",")]
        missing = set[str]()
        for name, equals, value in (item.partition("=") for item in items):
            if not equals or name not in SELECTIONS:
                continue
            named = value.split("+")
            unknown = [channel for channel in named if channel not in CHANNELS]
            if unknown:
                raise ValueError(f"unknown channel {unknown[0]!r} (one of {', '.join(CHANNELS)})")
            kept = [*named, *INPUTS]
            missing |= set(named) if name == "without" else {channel for channel in CHANNELS if channel not in kept}
        measured = [item for item in items if item.partition("=")[0] not in SELECTIONS] or ["none"]
        level, rest = (measured[0], measured[1:]) if "=" not in measured[0] else ("none", measured)
        if level not in NOISE:
            raise ValueError(f"unknown level {level!r}")
        sensors = {name: ChannelSensor(sd=NOISE[level].get(name, 0.0)) for name in CHANNELS}
        # standard deviations come before the options that count in them
        for item in sorted(rest, key=lambda item: item.partition("=")[0] not in CHANNELS):
            sensors = _item(sensors, item)
        known = {CHANNELS[name][0]: sensor for name, sensor in sensors.items() if sensor != ChannelSensor()}
        return SensorSet(known, ",".join(items), frozenset(CHANNELS[channel][0] for channel in missing))
    except ValueError as error:
        form = f"expected {'|'.join(NOISE)}, CHANNEL=SDunit, OPTION=VALUE, e.g. medium,heading=0.1deg,outliers=5%"
        raise BadInput(f"noise {text!r}: {error}", hint=form) from None


def _item(sensors: dict[str, ChannelSensor], item: str) -> dict[str, ChannelSensor]:
    name, equals, value = item.partition("=")
    if not equals:
        raise ValueError(f"{item!r} has no '='")
    if name in CHANNELS:
        return sensors | {name: replace(sensors[name], sd=_not_negative(value, _signed(value, name, 0.0)))}
    channel, dot, option = name.rpartition(".")
    if dot and channel not in CHANNELS:
        raise ValueError(f"unknown channel {channel!r} (one of {', '.join(CHANNELS)})")
    if option not in OPTIONS:
        raise ValueError(f"unknown channel or option {option!r} (options: {', '.join(OPTIONS)})")
    targets = [channel] if dot else [name for name in sensors if name not in ORDERS]
    if not dot and option in ("outliers", "bursts", "bias", "colour"):  # which count in standard deviations
        targets = [name for name in targets if sensors[name].sd > 0.0]
        if not targets:
            raise ValueError(f"{option}={value} needs channels with noise")
    return sensors | {t: replace(sensors[t], **_option(option, value, t, sensors[t].sd)) for t in targets}


def _signed(text: str, channel: str, sd: float) -> float:
    """A size in the channel's own unit or in ``sd``."""
    if text.endswith("sd") and sd == 0.0:
        raise ValueError(f"{text!r} counts in sd, but {channel} has no noise")
    return quantity(text, {**CHANNELS[channel][1], "sd": sd})


def _not_negative(text: str, value: float) -> float:
    if value < 0.0:
        raise ValueError(f"{text!r} must not be negative")
    return value


def _samples(text: str, channel: str, sd: float) -> int:
    count = whole_of(text)
    if count < 1:
        raise ValueError(f"{text!r} is not a number of samples")
    return count


_ERROR = (lambda text, channel, sd: _not_negative(text, _signed(text, channel, sd)), f"{OUTLIER_SDS:g}sd")
_RUN, _SHARE, _TIME = (
    (_samples, f"{RUN_SAMPLES}"), (lambda text, *_: share(text), ""), (lambda text, *_: positive(text, TIME), ""),
)  # fmt: skip
OPTIONS: dict[str, dict[str, tuple[Callable[[str, str, float], float], str]]] = {
    "colour": {"correlation_s": _TIME},
    "bias": {"bias": (_signed, "")},
    "scale": {"scale": (lambda text, channel, sd: quantity(text, SHARE), "")},
    "delay": {"delay_s": (lambda text, channel, sd: _not_negative(text, quantity(text, TIME)), "")},
    "outliers": {"outliers": _SHARE, "outlier_size": _ERROR},
    "bursts": {"bursts": _SHARE, "burst_samples": _RUN, "burst_size": _ERROR},
    "quantum": {"quantum": (lambda text, channel, sd: positive(text, CHANNELS[channel][1]), "")},
    "dropout": {"dropout": _SHARE},
    "gaps": {"gaps": _SHARE, "gap_samples": _RUN},
    "period": {"period_s": _TIME},
}
"""Option -> number of a `ChannelSensor` -> the reader of its text, with channel and sd, and the text where none stands;
the texts of several numbers stand between slashes."""


def _option(option: str, text: str, channel: str, sd: float) -> dict[str, float]:
    """The numbers of a `ChannelSensor` that an option sets."""
    numbers, texts = OPTIONS[option], text.split("/")
    if len(texts) > len(numbers):
        raise ValueError(f"{text!r} has too many '/'")
    given = [*texts, *[""] * len(numbers)]
    return {
        name: read(own or usual, channel, sd)
        for own, (name, (read, usual)) in zip(given, numbers.items(), strict=False)
    }
