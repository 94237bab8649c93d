"""A speed log that is not linear: two sizes that positions show in the place of a scale error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from .chains import Option
from .selection import compare

if TYPE_CHECKING:
    from ..base import SensorError
    from .selection import Compared


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
