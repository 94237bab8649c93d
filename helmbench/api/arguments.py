"""Arguments of the wrong type are told by their names."""

from __future__ import annotations

import math
from numbers import Integral, Real

from ..models.argument_types import shown
from ..models.errors import BadInput


def check_numbers(**given: object) -> None:
    """BadInput, naming the argument, where one is neither None nor a finite number."""
    for name, value in given.items():
        if value is not None and not _is_finite(value):
            raise BadInput(f"{name} is {shown(value)}", hint="give a finite number")


def check_seed(seed: object) -> None:
    """BadInput where a seed is no whole number of at least 0."""
    if isinstance(seed, bool) or not isinstance(seed, Integral) or seed < 0:
        raise BadInput(f"seed is {shown(seed)}", hint="give a whole number of at least 0")


def _is_finite(value: object) -> bool:
    try:
        return not isinstance(value, bool) and isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number of hundreds of digits
        return False
