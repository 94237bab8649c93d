"""Defects of records as loggers, converters and users make them, each a function of (record, random generator).

A defect returns the record with the defect in it.  `DEFECTS` says for each which causes a diagnosis may name: none
where the records are those of the model or hold nothing that a cause could be read from.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace

import numpy as np

from helmbench.datasets.record import Record

MEASURED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
SPEEDS = ("surge_m_s", "sway_m_s")
PLACES = ("north_m", "east_m")

Spoil = Callable[[Record, np.random.Generator], Record]


@dataclass(frozen=True)
class Defect:
    """spoil : puts the defect into a record.  allowed : causes that may be named beside what the clean records give.
    nonsense : nothing may be named, whatever the records were."""

    spoil: Spoil
    allowed: Collection[str] = ()
    nonsense: bool = False


def channels(record):
    """The measured channels that a record has."""
    return [name for name in MEASURED if record.has(name)]


def rows(record, kept):
    """The record with the rows of a mask or of indices."""
    return replace(record, time_s=record.time_s[kept], channels={k: v[kept] for k, v in record.channels.items()})


def changed(record, names, change):
    """The record with `change` applied to the named channels that it has."""
    return record.with_channels(**{name: change(record.column(name)) for name in names if record.has(name)})


def inside(record, rng, seconds):
    """Mask of a stretch of the given length, somewhere within the record."""
    time = record.time_s - record.time_s[0]
    start = rng.uniform(0.05, 0.95) * max(time[-1] - seconds, 0.0)
    return (time > start) & (time < start + min(seconds, 0.8 * time[-1]))


def rows_missing(seconds):
    return lambda record, rng: rows(record, ~inside(record, rng, seconds))


def values_missing(seconds, names=None):
    def spoil(record, rng):
        out = inside(record, rng, seconds)
        chosen = names or [rng.choice(channels(record))]
        return changed(record, chosen, lambda x: np.where(out, np.nan, x))

    return spoil


def known_rarely(names, every=100):
    return lambda record, rng: changed(record, names, lambda x: np.where(np.arange(x.size) % every, np.nan, x))


def jump(names, low, high):
    def spoil(record, rng):
        after = np.arange(record.n) >= rng.integers(record.n // 5, 4 * record.n // 5)
        step = rng.choice([-1.0, 1.0]) * rng.uniform(low, high)
        return changed(record, names, lambda x: x + step * after)

    return spoil


def time_jump(record, rng):
    after = np.arange(record.n) >= rng.integers(record.n // 5, 4 * record.n // 5)
    return replace(record, time_s=record.time_s + after * rng.uniform(1.0, 1000.0))


def joined(record, rng):
    """Two stretches of the run joined as if nothing were missing."""
    cut = int(record.n * rng.uniform(0.2, 0.45))
    kept = np.concatenate([np.arange(cut), np.arange(2 * cut, record.n)])
    return replace(rows(record, kept), time_s=record.time_s[: kept.size])


def frozen(names=None):
    def spoil(record, rng):
        out = inside(record, rng, rng.uniform(0.1, 0.6) * (record.time_s[-1] - record.time_s[0]))
        first = int(np.argmax(out))
        return changed(record, names or [rng.choice(channels(record))], lambda x: np.where(out, x[first], x))

    return spoil


def repeated(every):
    """Each value given several times in turn, as a logger does that is faster than its sensor."""
    return lambda record, _: changed(record, channels(record), lambda x: x[np.arange(x.size) // every * every])


def shortened(samples):
    return lambda record, rng: record.slice(0, int(rng.integers(samples[0], samples[1] + 1)))


def only_one(record, rng):
    kept = rng.choice(channels(record))
    return record.with_channels(**{name: None for name in channels(record) if name != kept})


def without(*names):
    return lambda record, _: record.with_channels(**dict.fromkeys(names))


def constant(*names):
    return lambda record, rng: changed(record, names, lambda x: np.full_like(x, rng.choice([0.0, x[0], 1.0])))


def times(names, factor):
    return lambda record, _: changed(record, names, lambda x: factor * x)


def exchanged(first, second):
    def spoil(record, _):
        if not record.has(first, second):
            return record
        return record.with_channels(**{first: record.column(second), second: record.column(first)})

    return spoil


def one_huge(names, value):
    def spoil(record, rng):
        at = rng.integers(1, record.n)
        return changed(record, names, lambda x: np.where(np.arange(x.size) == at, value, x))

    return spoil


def derived(record, _):
    """Velocities and yaw rate differentiated from positions and heading."""
    if not record.has("heading_rad", *PLACES):
        return record
    psi, time = record.heading_unwrapped(), record.time_s
    north, east = (np.gradient(record.column(name), time) for name in PLACES)
    return record.with_channels(
        surge_m_s=north * np.cos(psi) + east * np.sin(psi),
        sway_m_s=-north * np.sin(psi) + east * np.cos(psi),
        yaw_rate_rad_s=np.gradient(psi, time),
    )


def positions_integrated(record, _):
    """Positions integrated from the velocities, so that neither checks the other."""
    if not record.has("heading_rad", *SPEEDS):
        return record
    psi, dt = record.heading_unwrapped(), np.diff(record.time_s, prepend=record.time_s[0])
    u, v = (record.column(name) for name in SPEEDS)
    return record.with_channels(
        north_m=np.cumsum(dt * (u * np.cos(psi) - v * np.sin(psi))),
        east_m=np.cumsum(dt * (u * np.sin(psi) + v * np.cos(psi))),
    )


def clock(factor):
    return lambda record, _: replace(record, time_s=factor * record.time_s)


def unequal(record, rng):
    return rows(record, np.sort(rng.choice(record.n, record.n // 2, replace=False)))


def two_rates(record, _):
    """A fast logger that changes to a slow one half-way."""
    half = record.n // 2
    return rows(record, np.concatenate([np.arange(half), np.arange(half, record.n, 10)]))


def noise(names):
    """Random numbers in the place of samples."""

    def spoil(record, rng):
        return changed(record, names, lambda x: np.nanstd(x) * rng.standard_normal(x.size))

    return spoil


def shuffled(record, rng):
    order = rng.permutation(record.n)
    return changed(record, channels(record), lambda x: x[order])


def backwards(record, _):
    return changed(record, [*channels(record), "rudder_rad", "rudder_command_rad"], lambda x: x[::-1])


def of_another_run(record, rng):
    """Rudder of the same run at another time: it says nothing of the motion."""
    shift = int(rng.uniform(0.3, 0.7) * record.n)
    return changed(record, RUDDERS, lambda x: np.roll(x, shift))


RUDDERS = ("rudder_rad", "rudder_command_rad")
DEGREES = 180.0 / np.pi
DEFECTS = {
    **{f"rows missing {s} s": Defect(rows_missing(s)) for s in (1, 3, 10, 30, 60, 100)},
    **{f"all channels missing {s} s": Defect(values_missing(s, MEASURED)) for s in (3, 10, 30, 100)},
    **{f"one channel missing {s} s": Defect(values_missing(s)) for s in (3, 30, 100)},
    "rudder missing 20 s": Defect(values_missing(20, RUDDERS)),
    "yaw rate at every 100th sample": Defect(known_rarely(("yaw_rate_rad_s",))),
    "heading at every 100th sample": Defect(known_rarely(("heading_rad",))),
    "all channels at every 30th sample": Defect(known_rarely(MEASURED, 30)),
    "position jump": Defect(jump(PLACES, 5.0, 5000.0)),
    "heading jump": Defect(jump(("heading_rad",), 0.3, 3.0)),
    "time jump": Defect(time_jump),
    "two stretches joined": Defect(joined),
    "one channel frozen": Defect(frozen()),
    "all channels frozen": Defect(frozen(MEASURED)),
    # Half a period late: a model of the yaw motion alone may also take that for slower numbers.
    "values twice": Defect(repeated(2), ("heading_delay", "velocity_delay", "rudder_delay", "base_coefficients")),
    "values ten times": Defect(
        repeated(10), ("heading_delay", "velocity_delay", "rudder_delay", "clock_jitter", "base_coefficients")
    ),
    "10 to 20 samples": Defect(shortened((10, 20))),
    "20 to 100 samples": Defect(shortened((20, 100))),
    "one channel only": Defect(only_one),
    "no rudder": Defect(without(*RUDDERS)),
    "no heading": Defect(without("heading_rad")),
    "no yaw rate, no heading": Defect(without("heading_rad", "yaw_rate_rad_s")),
    "constant yaw rate": Defect(constant("yaw_rate_rad_s"), nonsense=True),
    "constant motion": Defect(constant(*MEASURED), nonsense=True),
    "constant rudder": Defect(constant(*RUDDERS), nonsense=True),
    "rudder in degrees": Defect(times(RUDDERS, DEGREES), nonsense=True),
    "yaw rate in degrees": Defect(times(("yaw_rate_rad_s",), DEGREES), nonsense=True),
    "heading in degrees": Defect(times(("heading_rad",), DEGREES), nonsense=True),
    "all angles in degrees": Defect(times((*RUDDERS, "heading_rad", "yaw_rate_rad_s"), DEGREES), nonsense=True),
    "speeds in knots": Defect(times(SPEEDS, 1.0 / 0.514444), ("speed_scale",)),
    "speeds in km/h": Defect(times(SPEEDS, 3.6), ("speed_scale",)),
    "surge and sway exchanged": Defect(exchanged(*SPEEDS), ("channel_swap", "earth_frame_velocity")),
    "north and east exchanged": Defect(exchanged(*PLACES), ("channel_swap",)),
    "heading and yaw rate exchanged": Defect(exchanged("heading_rad", "yaw_rate_rad_s"), ("channel_swap",)),
    "rudder and heading exchanged": Defect(exchanged("rudder_rad", "heading_rad"), ("channel_swap",)),
    "rudder of 5000 rad": Defect(times(RUDDERS, 5000.0), nonsense=True),
    "speed of 1e6 m/s": Defect(times(SPEEDS, 1e6), nonsense=True),
    "one sample of 1e9": Defect(one_huge(MEASURED, 1e9), ("outliers", "impossible_samples")),
    "one sample of 1e300": Defect(one_huge(MEASURED, 1e300), ("outliers", "impossible_samples")),
    "everything 1e-30": Defect(times(MEASURED, 1e-30), nonsense=True),
    "everything 1e30": Defect(times((*MEASURED, *RUDDERS), 1e30), nonsense=True),
    "channels from positions": Defect(derived, ("velocity_delay", "heading_delay")),
    "positions from channels": Defect(positions_integrated),
    "time in milliseconds": Defect(clock(1000.0), nonsense=True),
    "steps of a millisecond": Defect(clock(1e-3), nonsense=True),
    "steps of a nanosecond": Defect(clock(1e-9), nonsense=True),
    "unequal steps": Defect(unequal),
    "fast, then slow": Defect(two_rates),
    "noise": Defect(noise(MEASURED), nonsense=True),
    "random rudder": Defect(noise(RUDDERS), nonsense=True),
    "shuffled": Defect(shuffled, nonsense=True),
    "backwards": Defect(backwards, nonsense=True),
    "rudder of another time": Defect(of_another_run, nonsense=True),
}
