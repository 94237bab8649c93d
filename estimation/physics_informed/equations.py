"""The right-hand side of a model's equations as a function of jax, made of the family's symbols."""

from __future__ import annotations

# jax and SymPy's lambdify are typed loosely:
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false
from collections.abc import Callable
from functools import lru_cache
from typing import Any, cast

from ..black_box.recurrent import require_jax


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

    from ...models.kernels import definition_of

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
    """Two compiled functions of states (T, n), inputs (T, nu) and theta (p + c,): the rates (T, n), and these with
    their derivatives by the states (T, n, n) and by theta (T, n, p + c).  Compiled anew for every T.

    Raises
    ------
    CannotFit : jax is not installed or too old.
    """
    jax, rates = require_jax(), rates_of(family)

    def both(state: Any, inputs: Any, theta: Any) -> Any:
        return rates(state, inputs, theta), *jax.jacfwd(rates, (0, 2))(state, inputs, theta)

    return jax.jit(jax.vmap(rates, (0, 0, None))), jax.jit(jax.vmap(both, (0, 0, None)))
