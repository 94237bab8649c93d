"""The right-hand side of a model's equations as a function of jax, made of the family's symbols."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, cast

import numpy as np

from ....models.model import Model
from ..black_box.free_runs import require_jax

POINTS = 201
"""States that one call of a compiled function takes: jax compiles once for a family."""


@dataclass(frozen=True)
class PinnEquations:
    """A model's equations with positions left out: `kept` (n,) are the places of the other states among all.

    Raises
    ------
    CannotFit : jax is not installed or too old, at the first call.
    """

    model: Model
    kept: tuple[int, ...]

    @classmethod
    def of(cls, model: Model) -> PinnEquations:
        """The equations of a model, whose coefficients are not used."""
        return cls(model, tuple(i for i, name in enumerate(model.states) if name not in ("x", "y")))

    @property
    def names(self) -> list[str]:
        """Symbols of the states."""
        return [self.model.states[k] for k in self.kept]

    def rates(self, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray) -> np.ndarray:
        """Rates (T, n) at states (T, n), inputs (T, nu) and coefficients (p,)."""
        function = compiled_of(self.model.family)[0]
        blocks = [np.asarray(function(*point))[:count] for count, point in self._points(states, inputs, theta)]
        return np.concatenate(blocks)[:, self.kept]

    def derivatives(
        self, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same, with their derivatives by the states (T, n, n) and by the coefficients (T, n, p)."""
        function, kept, found = compiled_of(self.model.family)[1], list(self.kept), []
        for count, point in self._points(states, inputs, theta):
            rates, by_state, by_theta = (np.asarray(part)[:count, kept] for part in function(*point))
            found.append((rates, by_state[:, :, kept], by_theta))
        rates, by_state, by_theta = (np.concatenate(parts) for parts in zip(*found, strict=True))
        return rates, by_state, by_theta

    def _points(self, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray):
        """Arguments of the compiled functions, the last states repeated, and how many of them are meant."""
        for start in range(0, len(states), POINTS):
            rows = np.minimum(np.arange(start, start + POINTS), len(states) - 1)
            whole = np.zeros((POINTS, len(self.model.states)))
            whole[:, self.kept] = states[rows]
            yield min(POINTS, len(states) - start), (whole, inputs[rows], theta, self.model.constants)


@lru_cache(maxsize=64)
def rates_of(family: str) -> Callable[[Any, Any, Any], Any]:
    """The function (state (n,), inputs (nu,), theta (p + c,)) -> rates (n,) of a family, in the order of its kernels.

    A second-order response model is taken without the derivative of its input, with the state w, as its kernels are.
    The equations are those of `definition_of`, where the forces and the mass matrix are written; the mass matrix holds
    no state, so that it is solved for once for all samples.

    Raises
    ------
    CannotFit : jax is not installed or too old.
    """
    jax = require_jax()
    import sympy as sp

    from ....models.kernels import definition_of

    jnp, definition = jax.numpy, definition_of(family).simulated()
    inner: dict[sp.Basic, sp.Basic] = {}
    for symbol, expression in definition.helpers.items():
        inner[symbol] = sp.sympify(expression).xreplace(inner)
    forces, kinematics = (
        [cast("sp.Expr", sp.sympify(e).xreplace(inner)) for e in part]
        for part in (definition.forces, definition.kinematics)
    )
    names = {"step": lambda x: jnp.where(x > 0.0, 1.0, 0.0), "absv": jnp.abs, "sgn": jnp.sign, "atan2v": jnp.arctan2}
    arguments = [list(definition.states), list(definition.inputs), definition.parameters]
    plain = sp.lambdify(arguments, [forces, kinematics], [names, "jax"], cse=True)
    mass = sp.lambdify([definition.parameters], definition.mass.tolist(), [names, "jax"])

    def rates(state: Any, inputs: Any, theta: Any) -> Any:
        force, rest = plain(state, inputs, theta)
        inverse = jnp.linalg.inv(jnp.array(mass(theta), float))
        moved = inverse @ jnp.array(force, float)
        return jnp.concatenate([moved, jnp.array(rest, float)])

    return rates


@lru_cache(maxsize=64)
def compiled_of(family: str) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Two compiled functions of states (T, n), inputs (T, nu), coefficients (p,) and constants (c,): the rates (T, n),
    and these with their derivatives by the states (T, n, n) and by the coefficients (T, n, p).  Compiled for each T.

    Raises
    ------
    CannotFit : jax is not installed or too old.
    """
    jax, of_theta = require_jax(), rates_of(family)

    def rates(state: Any, inputs: Any, coefficients: Any, constants: Any) -> Any:
        return of_theta(state, inputs, jax.numpy.concatenate([coefficients, constants]))

    def both(*point: Any) -> Any:
        return rates(*point), *jax.jacfwd(rates, (0, 2))(*point)

    along = (0, 0, None, None)
    return jax.jit(jax.vmap(rates, along)), jax.jit(jax.vmap(both, along))
