"""Quantities that a record may measure beside the states: functions made of a family's intermediate quantities."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

Output = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(states (..., n), inputs (..., nu), theta (..., m)) -> values (...)."""


@lru_cache(maxsize=64)
def thrust_of(family: str) -> Output | None:
    """Propeller thrust [N] of an MMG family, per 0.5 rho S L times this product; None for a family without one."""
    from .kernels import definition_of, load

    if "thrust" not in load(family).HELPERS:
        return None
    import sympy as sp

    definition = definition_of(family)
    found = [symbol for symbol in definition.helpers if symbol.name == "thrust"]
    if not found or definition.force_scale is None:
        return None
    expression = sp.sympify(definition.helpers[found[0]])
    for symbol, inner in reversed(list(definition.helpers.items())):
        expression = expression.xreplace({symbol: sp.sympify(inner)})
    states, inputs, theta = definition.states, definition.inputs, [*definition.coefficients, *definition.constants]
    names = {"step": lambda x: np.where(x > 0.0, 1.0, 0.0), "absv": np.abs, "sgn": np.sign, "atan2v": np.arctan2}
    plain = sp.lambdify([states, inputs, theta], expression / definition.force_scale[0], [names, "numpy"], cse=True)

    def thrust(x: np.ndarray, u: np.ndarray, c: np.ndarray) -> np.ndarray:
        return plain(*(np.moveaxis(part, -1, 0) for part in (x, u, c))) * np.ones(x.shape[:-1])

    return thrust
