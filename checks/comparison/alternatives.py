"""Errors that explain a comparison in the place of scale errors: a logger's clock, a speed log that is not linear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..sensors import LoggerClock, SpeedScaleError, YawRateScaleError
from .chains import Option
from .selection import compare

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ..base import SensorError
    from .chains import Chain
    from .selection import Compared


def as_clock(done: Compared, of_positions: Sequence[tuple[Chain, Sequence[Record]]]) -> Compared:
    """Heading against yaw rate with the scale error of the rate told as one of the clock, where this makes a scale
    error of the speed needless; else the same.

    of_positions : the comparisons of positions with velocities, and the records that each can use.
    """
    of_rate = [s.option.cause.id == YawRateScaleError.id for s in done.sizes]
    if not any(s.material and is_scale for s, is_scale in zip(done.sizes, of_rate, strict=True)):
        return done
    option = Option(LoggerClock(), LoggerClock.scaled)
    sizes = (
        s._replace(option=option, rivals=()) if is_scale else s for s, is_scale in zip(done.sizes, of_rate, strict=True)
    )
    other = replace(done, sizes=tuple(sizes))
    needless = _speed_is_scaled(done, of_positions) and not _speed_is_scaled(other, of_positions)
    return other if needless else done


def _speed_is_scaled(done: Compared, of_positions: Sequence[tuple[Chain, Sequence[Record]]]) -> bool:
    """Whether positions show a scale error of the speed in records that are corrected for a comparison."""
    comparisons = (compare(chain, [done.without(record) for record in records]) for chain, records in of_positions)
    return any(s.option.cause.id == SpeedScaleError.id and s.material for one in comparisons for s in one.sizes)


# ---- A speed log that is not linear: two sizes that positions show in the place of a scale error.


def as_curve(done: Compared, errors: Sequence[SensorError]) -> Compared:
    """Positions against velocities with errors whose sizes act together among the options, where the last of these
    matters and all together explain clearly more than any other error; else the same.

    Of more sizes they explain as much as a scale error in any record: only the tie without it makes them an error.
    """
    if not done.records or not errors:
        return done
    options = tuple(Option(cause, cause.together) for cause in errors)
    other = compare(done.chain._replace(options=(*done.chain.options, *options)), done.records)
    clear = any(s.option in options and s.material and not s.rivals for s in other.sizes)
    return other if clear else replace(done, tested=other.tested)
