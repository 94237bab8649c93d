"""A logger's clock that runs fast or slow: one number that two comparisons show as scale errors of the same size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..sensors import LoggerClock, SpeedScaleError, YawRateScaleError
from .chains import Option
from .selection import compare

if TYPE_CHECKING:
    from ...datasets.record import Record
    from .chains import Chain
    from .selection import Compared


def as_clock(done: Compared, of_positions: Sequence[Chain], records: Sequence[Record]) -> Compared:
    """Heading against yaw rate with the scale error of the rate told as one of the clock, where this makes a scale
    error of the speed needless; else the same.

    of_positions : the comparisons of positions with velocities.  records : those that these can use.
    """
    if not any(_is_scale(s.option, YawRateScaleError.id) and s.material for s in done.sizes):
        return done
    clock = LoggerClock()
    option = Option(clock, clock.scaled)
    sizes = tuple(
        s._replace(option=option, rivals=()) if _is_scale(s.option, YawRateScaleError.id) else s for s in done.sizes
    )
    other = replace(done, sizes=sizes)
    needless = _speed_is_scaled(done, of_positions, records) and not _speed_is_scaled(other, of_positions, records)
    return other if needless else done


def _speed_is_scaled(done: Compared, of_positions: Sequence[Chain], records: Sequence[Record]) -> bool:
    """Whether positions show a scale error of the speed in records that are corrected for a comparison."""
    current = [done.without(record) for record in records]
    shown = (s for chain in of_positions for s in compare(chain, chain.taken(current)).sizes)
    return any(_is_scale(s.option, SpeedScaleError.id) and s.material for s in shown)


def _is_scale(option: Option, cause: str) -> bool:
    return option.cause.id == cause
