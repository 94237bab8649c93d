"""Random values of parameters, and neighbours on the line between two points, on each parameter's own scale.

    v_j = x_j + phi (x_j - y_j),   phi uniform in (-1, 1), y another source, j one parameter

(Karaboga & Basturk 2007, reflected at the bounds), for continuous, integer, logarithmic and categorical parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from optuna.distributions import BaseDistribution, CategoricalDistribution, FloatDistribution, IntDistribution


def levels(distribution: BaseDistribution) -> int | None:
    """Number of values of a stepped distribution; None for continuous and logarithmic ones."""
    step = getattr(distribution, "step", None)
    if step is None or getattr(distribution, "log", False):
        return None
    assert isinstance(distribution, IntDistribution | FloatDistribution)
    return round((distribution.high - distribution.low) / step) + 1


def _scale(distribution: IntDistribution | FloatDistribution) -> tuple[float, float]:
    """Ends of the continuous scale; for integers, half a step beyond the lowest and highest value."""
    room = 0.5 if isinstance(distribution, IntDistribution) else 0.0
    low, high = float(distribution.low) - room, float(distribution.high) + room
    return (np.log(low), np.log(high)) if distribution.log else (low, high)


def encode(distribution: IntDistribution | FloatDistribution, value: float) -> float:
    """Place of a numerical value in [0, 1], on the distribution's own scale."""
    count = levels(distribution)
    if count is not None:
        return (round((value - distribution.low) / (distribution.step or 1)) + 0.5) / count
    low, high = _scale(distribution)
    return ((np.log(value) if distribution.log else value) - low) / (high - low)


def decode(distribution: IntDistribution | FloatDistribution, place: float) -> int | float:
    """Value at a place in [0, 1]; the inverse of `encode`."""
    count = levels(distribution)
    if count is not None:
        index = min(int(place * count), count - 1)
        value = distribution.low + index * (distribution.step or 1)
    else:
        low, high = _scale(distribution)
        value = low + place * (high - low)
        value = np.exp(value) if distribution.log else value
    if isinstance(distribution, IntDistribution):
        return int(min(max(round(value), distribution.low), distribution.high))
    return float(min(max(value, distribution.low), distribution.high))


def random_value(distribution: BaseDistribution, rng: np.random.Generator) -> Any:
    """A random value, uniform on the distribution's own scale."""
    if isinstance(distribution, CategoricalDistribution):
        return distribution.choices[rng.integers(len(distribution.choices))]
    assert isinstance(distribution, IntDistribution | FloatDistribution)
    return decode(distribution, rng.random())


def neighbour_value(distribution: BaseDistribution, own: Any, other: Any, rng: np.random.Generator) -> Any:
    """A neighbour of the value `own`, towards `other` or away from it; not `own` itself where another value exists."""
    if isinstance(distribution, CategoricalDistribution):
        rest = [choice for choice in distribution.choices if choice != own]
        return other if rng.random() < 0.5 and other in rest else rest[rng.integers(len(rest))]
    assert isinstance(distribution, IntDistribution | FloatDistribution)
    at = encode(distribution, own)
    step = rng.uniform(-1.0, 1.0) * (at - encode(distribution, other))
    place = abs(at + step)
    value = decode(distribution, min(place, 2.0 - place))  # reflected at the bounds
    return value if value != own else _next(distribution, own, step)


def _next(distribution: IntDistribution | FloatDistribution, own: Any, direction: float) -> Any:
    """The next value of a discrete distribution in a direction, at its end the one before; else `own`."""
    if isinstance(distribution, FloatDistribution) and distribution.step is None:
        return own
    step = (distribution.step or 1) * (1 if direction >= 0.0 else -1)
    return own + step if distribution.low <= own + step <= distribution.high else own - step


def neighbour(
    space: Mapping[str, BaseDistribution], own: Mapping[str, Any], other: Mapping[str, Any], rng: np.random.Generator
) -> dict[str, Any]:
    """Parameters that differ from `own` in one of them, which is moved along the line to `other`.

    A category may change even where both agree: otherwise a category that all sources share could never change.
    """
    valid = {name for name in space if _holds(space[name], own, name)}
    params = {name: own[name] if name in valid else random_value(space[name], rng) for name in space}
    shared = [name for name in sorted(valid) if _holds(space[name], other, name)]
    differing = [name for name in shared if own[name] != other[name]]
    if differing:
        movable = [name for name in shared if name in differing or _n_choices(space[name]) > 1]
        name = movable[rng.integers(len(movable))]
        params[name] = neighbour_value(space[name], own[name], other[name], rng)
    elif valid == set(space):
        name = sorted(valid)[rng.integers(len(valid))]
        params[name] = random_value(space[name], rng)
    return params


def _n_choices(distribution: BaseDistribution) -> int:
    """Number of a categorical distribution's choices; 0 for numbers."""
    return len(distribution.choices) if isinstance(distribution, CategoricalDistribution) else 0


def _holds(distribution: BaseDistribution, params: Mapping[str, Any], name: str) -> bool:
    """Whether `params` has a value that the distribution allows (an earlier session may have had another range)."""
    if name not in params:
        return False
    try:
        return distribution._contains(distribution.to_internal_repr(params[name]))
    except (ValueError, TypeError):
        return False
