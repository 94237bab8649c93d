"""A model written once, symbolically: M(p) a = F(x, u, p), from which everything else is generated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import TYPE_CHECKING, Any


class Later:
    """A module by its name, imported as soon as an attribute of it is asked for: SymPy takes a second, and a warm start
    does without it.

    package : where a relative name starts from.
    """

    def __init__(self, name: str, package: str | None = None) -> None:
        self._name, self._package = name, package

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(self._name, self._package), attribute)


if TYPE_CHECKING:
    import sympy as sp
else:
    sp = Later("sympy")


def symbols(names: str) -> list[sp.Symbol]:
    """Real symbols from a space-separated list, always as a list."""
    return [sp.Symbol(name, real=True) for name in names.split()]


@dataclass(frozen=True)
class Definition:
    """One model family in symbols.

    The first ``len(forces)`` states have the accelerations ``a`` with ``mass * a = forces``; the other
    states have the derivatives ``kinematics``.  Helper symbols (speed, rudder inflow, normal force, ...)
    are kept in order and never expanded, so that derivatives follow the chain rule through them.

    Parameters
    ----------
    name : identifier, for example ``abkowitz``.
    states, inputs : symbols; inputs are ``delta`` and, where the model has a propeller, ``n``.
    coefficients : symbols of the parameters to identify; the forces minus mass terms are linear in them.
    constants : symbols of known numbers (length, masses, ...), kept in the same vector behind the coefficients.
    mass : matrix (k, k) of constants and coefficients.
    forces : k expressions.
    kinematics : expressions for the remaining states.
    helpers : ordered helper symbol -> expression.
    public : published parameter name -> expression in the coefficients, where the two differ
        (K, T1, T2, ... of a response model); None where coefficients are published themselves.
    inverse : coefficient name -> expression in the published parameters (symbols named as in ``public``).
    units : unit of each published parameter.
    rate_gain : coefficient that multiplies the input's derivative (symbol ``delta_rate``) in the forces of a
        second-order response model; the simulated state is then ``w = q - rate_gain * delta``.
    held : coefficients that enter in a non-linear way; regression holds them at zero (their column is zero).
    linear : whether the model is linear in states and inputs.
    force_scale : for 3-DOF models, what turns X [N], Y [N], N [N m] into the units of ``forces``: expressions in
        constants and ``rho`` (water density, kg/m3); the environment variant uses it.
    source : where the equations come from.
    """

    name: str
    title: str
    states: Sequence[sp.Symbol]
    inputs: Sequence[sp.Symbol]
    coefficients: Sequence[sp.Symbol]
    constants: Sequence[sp.Symbol]
    mass: sp.Matrix
    forces: Sequence[sp.Expr]
    kinematics: Sequence[sp.Expr]
    units: Mapping[str, str]
    source: str
    helpers: Mapping[sp.Symbol, sp.Expr] = field(default_factory=dict)
    public: Mapping[str, sp.Expr] | None = None
    inverse: Mapping[str, sp.Expr] | None = None
    rate_gain: sp.Symbol | None = None
    held: Sequence[sp.Symbol] = ()
    linear: bool = False
    force_scale: Sequence[sp.Expr] | None = None

    @property
    def parameters(self) -> list[sp.Symbol]:
        """Coefficients, then constants: the layout of the kernel's parameter vector."""
        return [*self.coefficients, *self.constants]

    def simulated(self) -> Definition:
        """The definition without input derivatives, as it is integrated.

        A second-order response model q_dot = f(q, r, delta) + c delta_rate becomes, with w = q - c delta,
        w_dot = f(w + c delta, r, delta) and r_dot = w + c delta: equal for every input, steps included.
        """
        if self.rate_gain is None:
            return self
        (q,), delta = self.states[:1], self.inputs[0]
        rate = next(symbol for symbol in self.inputs if symbol.name == "delta_rate")
        w = sp.Symbol("w", real=True)
        swap = {q: w + sp.diff(self.forces[0], rate) * delta, rate: sp.S.Zero}  # an extension may scale c
        return replace(
            self,
            states=[w, *self.states[1:]],
            inputs=[symbol for symbol in self.inputs if symbol != rate],
            forces=[force.xreplace(swap) for force in self.forces],
            kinematics=[expression.xreplace(swap) for expression in self.kinematics],
            helpers={name: expression.xreplace(swap) for name, expression in self.helpers.items()},
            rate_gain=None,
        )


def functions() -> dict[str, Any]:
    """Functions that texts of equations may name; Float is a double, whatever the number of its digits."""
    from . import primitives

    named = {name: getattr(primitives, name) for name in ("absv", "sgn", "step", "atan2v")}
    return named | {"Float": lambda digits: sp.Float(float(digits))}


def written(
    *,
    states: str,
    inputs: str,
    coefficients: str,
    forces: Sequence[str],
    kinematics: Sequence[str],
    constants: str = "",
    mass: Sequence[Sequence[str]] | None = None,
    helpers: Mapping[str, str] | None = None,
    public: Mapping[str, str] | None = None,
    inverse: Mapping[str, str] | None = None,
    rate_gain: str | None = None,
    held: str = "",
    force_scale: Sequence[str] | None = None,
    letters: Mapping[str, str] | None = None,
    units: str | Mapping[str, str],
    **facts: Any,
) -> Definition:
    """A definition whose equations are texts, such as `(a + a1*absv(speed))*r`: names and expressions as `Definition`
    has them.

    mass : None: the unit matrix.  letters : of the polynomials {X}, {Y} and {N} in the forces, see `polynomial`.
    units : one text: that of every coefficient.  facts : what is no expression (name, title, source, linear).
    """
    own = coefficients.split()
    sums = {} if letters is None else {axis: polynomial(axis, own, letters) for axis in "XYN"}
    names = f"{states} {inputs} {coefficients} {constants} {' '.join([*(helpers or ()), *(public or ())])} rho"
    known: dict[str, Any] = {symbol.name: symbol for symbol in symbols(names)}
    words = known | functions()

    def read(texts: Iterable[str]) -> list[sp.Expr]:
        parsed: Any = sp.sympify  # its overloads do not tell of `locals`
        return [parsed(text, locals=words) for text in texts]

    def by_name(texts: Mapping[str, str] | None) -> dict[str, sp.Expr] | None:
        return None if texts is None else dict(zip(texts, read(texts.values()), strict=True))

    return Definition(
        states=symbols(states),
        inputs=symbols(inputs),
        coefficients=symbols(coefficients),
        constants=symbols(constants),
        mass=sp.eye(len(forces)) if mass is None else sp.Matrix([read(row) for row in mass]),
        forces=read(text.format_map(sums) for text in forces),
        kinematics=read(kinematics),
        helpers={known[name]: value for name, value in (by_name(helpers) or {}).items()},
        public=by_name(public),
        inverse=by_name(inverse),
        rate_gain=None if rate_gain is None else known[rate_gain],
        held=symbols(held),
        force_scale=None if force_scale is None else read(force_scale),
        units=dict.fromkeys(own, units) if isinstance(units, str) else units,
        **facts,
    )


def polynomial(axis: str, coefficients: Iterable[str], letters: Mapping[str, str]) -> str:
    """Sum of coefficient times monomial over the coefficients that begin with `axis`: the others of a coefficient's
    letters stand for factors, `X_vvr` and `Xvvr` for v v r, `Yv_absr` for v|r|."""
    products = []
    for name in coefficients:
        plain, _, absolute = name[1:].lstrip("_").partition("_abs")
        if name[0] == axis:
            factors = [letters[letter] for letter in plain] + [f"absv({letters[letter]})" for letter in absolute]
            products.append("*".join([name, *factors]))
    return " + ".join(products)
