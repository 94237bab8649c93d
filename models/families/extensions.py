"""Extensions of any definition: terms with parameters of their own that are zero where the effect is absent.

A family id may carry extensions: ``abkowitz+rudder_offset+yaw_damping_quadratic``.  Their parameters are further
coefficients.

Added hydrodynamic terms are in the prime system F' = F / (rho A U^2 / 2), N' = N / (rho A L U^2 / 2) with
v' = v/U and r' = r L/U at the instantaneous speed U through the water; A = L d where the family knows the draught d,
else L^2.

`extensions.yaml` holds their parameters and equations; this file applies them to a definition.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from ..data_file import load
from ..definition import Definition, Later, functions, symbols
from ..regimes import CLOCK, EXTENSION, VARIABLES

if TYPE_CHECKING:
    import sympy as sp

    from .. import primitives
    from . import environment

    Apply = Callable[[Definition, Sequence[sp.Symbol]], Definition]
else:  # the table's names and units are asked for without its equations
    sp, primitives, environment = Later("sympy"), Later("..primitives", __package__), Later(".environment", __package__)


@dataclass(frozen=True)
class Extension:
    """Parameters of an extension with their units, and how it changes a definition."""

    units: Mapping[str, str]
    apply: Apply
    three_dof: bool | None = None
    """Whether it needs a 3-DOF model (True), a response model (False) or takes either (None)."""
    held: tuple[str, ...] = ()
    """Parameters that enter in a non-linear way, together with a coefficient or on their own."""
    helper: str | None = None
    """Intermediate quantity of the family that it changes: families without it cannot carry the extension."""


def _by_row(row: Mapping[str, Any]) -> Apply:
    """What a row of `extensions.yaml` says of a definition's equations."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        own = [name for part in ("inputs", "constants", "helpers", "states") for name in row.get(part, ())]
        words = _words(definition, [*symbols(" ".join(own)), *parameters])
        swap = {sp.Symbol(name, real=True): _read(text, words) for name, text in row.get("instead", {}).items()}
        inputs = [s for s in definition.inputs if s not in swap or s in swap[s].free_symbols]
        changed = _substitute(definition, swap) if swap else definition
        helpers = {words[name]: _read(text, words) for name, text in row.get("helpers", {}).items()}
        helpers = {**changed.helpers, **helpers}
        for name, text in row.get("quantity", {}).items():
            helpers |= {s: _read(text, words | {name: sp.sympify(h)}) for s, h in helpers.items() if s.name == name}
        changed = replace(
            changed,
            inputs=[*inputs, *(words[name] for name in row.get("inputs", ()) if words[name] not in inputs)],
            helpers=helpers,
        )
        if "added" in row:
            changed = _added(changed, parameters, row["added"])
        for letter, text in row.get("force", {}).items():
            changed = _pushed(changed, AXES[letter][0], _read(text, words))
        if "mass" in row:
            added = sp.Matrix([[_read(text, words) for text in line] for line in row["mass"]])
            changed = replace(changed, mass=changed.mass + sp.diag(*(changed.force_scale or ())) * added)
        states = row.get("states", {})
        return replace(
            changed,
            states=[*changed.states, *(words[name] for name in states)],
            kinematics=[*changed.kinematics, *(_read(text, words) for text in states.values())],
        )

    return apply


def _words(definition: Definition, further: Sequence[sp.Symbol]) -> dict[str, Any]:
    """What names in a text stand for: symbols of the definition and further ones, functions, L, t and pi."""
    known = [*definition.constants, *definition.helpers, *definition.states, *definition.inputs, *further]
    otherwise = {"L": sp.Symbol("wind_L", real=True), "speed": sp.S.Zero}
    named = otherwise | {symbol.name: symbol for symbol in known}
    return named | functions() | {"t": sp.Symbol(CLOCK, real=True), "pi": sp.pi.evalf()}


def _read(text: str | int, words: Mapping[str, Any]) -> sp.Expr:
    parsed: Any = sp.sympify  # its overloads do not tell of `locals`
    return cast("sp.Expr", parsed(str(text), locals=words))


def _substitute(definition: Definition, swap: Mapping[sp.Symbol, sp.Expr]) -> Definition:
    return replace(
        definition,
        helpers={name: _swap(expression, swap) for name, expression in definition.helpers.items()},
        forces=[_swap(force, swap) for force in definition.forces],
        kinematics=[_swap(expression, swap) for expression in definition.kinematics],
    )


def _swap(expression: sp.Expr, swap: Mapping) -> sp.Expr:
    return cast("sp.Expr", sp.sympify(expression).xreplace(dict(swap)))


def _state(definition: Definition, name: str) -> sp.Symbol:
    return next(s for s in definition.states if s.name == name)


def _pushed(definition: Definition, row: int, force: sp.Expr) -> Definition:
    """The definition with a force, N, or moment, N m, on an axis; with a yaw acceleration of a response model."""
    scale = definition.force_scale or [sp.S.One]
    return _with_force(definition, row, scale[row] * force)


def _with_force(definition: Definition, row: int, force: sp.Expr) -> Definition:
    """The definition with a force in the units of its equations, and with the clock among its states where the force
    goes with the time."""
    forces = list(definition.forces)
    forces[row] += force
    return _timed(replace(definition, forces=forces), force)


def _timed(definition: Definition, of_time: sp.Expr) -> Definition:
    """The definition with the time from the start of a record among its states where an expression needs it."""
    clock = sp.Symbol(CLOCK, real=True)
    if clock in definition.states or clock not in of_time.free_symbols:
        return definition
    return replace(definition, states=[*definition.states, clock], kinematics=[*definition.kinematics, sp.S.One])


def _motion(definition: Definition, tag: str):
    """Helpers for what forces follow, these by their short names (v', r' and the rudder angle; r in rad/s of a response
    model), and what turns X', Y', N' into the units of the forces."""
    delta, scale = definition.inputs[0], definition.force_scale
    if scale is None:
        return {}, {"r": _state(definition, "r"), "d": delta}, [sp.S.One]
    u, v, r = definition.states[:3]
    known = {symbol.name: symbol for symbol in definition.constants}
    length, rho = known.get("L", sp.Symbol("wind_L", real=True)), sp.Symbol("rho", real=True)
    area = length * known.get("d", length)
    speed, vp, rp = symbols(f"{tag}_U {tag}_vp {tag}_rp")
    helpers = {speed: sp.sqrt(u**2 + v**2 + sp.Float(1e-12)), vp: v / speed, rp: r * length / speed}
    pressure = rho / 2 * area * speed**2
    unit = [sp.simplify(part * pressure * arm) for part, arm in zip(scale, (1, 1, length), strict=True)]
    return helpers, {"v": vp, "r": rp, "d": delta}, unit


def _added(definition: Definition, parameters: Sequence[sp.Symbol], terms: Mapping[str, Sequence[Any]]) -> Definition:
    """Parameter -> the axis that it acts on and what it multiplies: a text of the motion in the prime system."""
    helpers, motion, unit = _motion(definition, parameters[0].name)
    changed = replace(definition, helpers={**definition.helpers, **helpers})
    for parameter in parameters:
        letter, text = terms[parameter.name]
        row = AXES[letter][0] % len(unit)
        changed = _with_force(changed, row, unit[row] * parameter * _read(text, functions() | motion))
    return changed


def _absorbed(inputs: str) -> Apply:
    """Some inputs of the environment variant as constant parameters, the others absent."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        whole = environment.with_environment(definition, wind=inputs.startswith("wind"))
        kept = dict(zip(symbols(inputs), parameters, strict=True))
        swap = {s: kept.get(s, sp.S.Zero) for s in symbols(environment.INPUTS)}
        tag = {s: sp.Symbol(s.name.replace("env_", f"{inputs[:4]}_"), real=True) for s in whole.helpers}
        changed = _substitute(replace(whole, inputs=definition.inputs), swap)
        changed = _substitute(changed, tag)
        changed = replace(changed, helpers={tag.get(name, name): value for name, value in changed.helpers.items()})
        return _pruned(changed, {symbol.name for symbol in definition.constants})

    return apply


def _pruned(definition: Definition, own: set[str]) -> Definition:
    """The definition without helpers and added constants that nothing needs."""
    needed = set().union(*(sp.sympify(e).free_symbols for e in [*definition.forces, *definition.kinematics]))
    helpers = {}
    for name, expression in reversed(list(definition.helpers.items())):
        if name in needed:
            helpers[name] = expression
            needed |= sp.sympify(expression).free_symbols
    constants = [s for s in definition.constants if s.name in own or s in needed]
    return replace(definition, helpers=dict(reversed(list(helpers.items()))), constants=constants)


def _speed_loss(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    """Speed U = U0 (1 - loss) as a state, T_u loss_dot = k r^2 - loss; every term keeps its prime value.

    With kappa = U/U0 the yaw equation r_dot = f(r, delta) becomes kappa^2 f(r/kappa, delta), that of second order
    kappa^3 f(q/kappa^2, r/kappa, delta, delta_rate/kappa); the rudder's terms go with kappa^(m - 2) on top (m = 2 in
    open water, less behind a propeller at constant speed).
    """
    gain, time, power = parameters
    r = _state(definition, "r")
    loss, ratio = symbols("speed_loss_state speed_ratio")
    order = 1 if definition.states[0] == r else 2
    rudder = ratio ** (power - 2)
    swap: dict[sp.Symbol, sp.Expr] = {r: r / ratio, definition.inputs[0]: definition.inputs[0] * rudder}
    if order == 2:
        swap[definition.states[0]] = definition.states[0] / ratio**2
    swap |= {s: s * rudder / ratio for s in definition.inputs if s.name == "delta_rate"}
    force = ratio ** (order + 1) * _swap(definition.forces[0], swap)
    return replace(
        definition,
        states=[*definition.states, loss],
        helpers={ratio: 1 - loss, **definition.helpers},
        forces=[force, *definition.forces[1:]],
        kinematics=[*definition.kinematics, (gain * r**2 - loss) / time],
        linear=False,
    )


ANY_ORDER = "rad/s^k"
"""Unit of a response model's yaw acceleration: k is the order of the highest derivative."""
RESPONSE = "R"
AXES = {"X": (0, "N"), "Y": (1, "N"), "N": (2, "N m"), RESPONSE: (0, ANY_ORDER)}
"""Letter of a force -> its row in the equations of motion, and its unit; R: yaw acceleration of a response model."""
PER = {"v": " s/m", "r": " s/rad", "d": "/rad"}
"""Motion -> what stands behind the unit of a force in that of a force over the motion."""
PLACES = {"north": "x", "east": "y"}
"""Place -> its state."""


@cache
def _file() -> Mapping[str, Mapping[str, Any]]:
    return load(Path(__file__).with_suffix(".yaml"))


@cache
def extensions() -> Mapping[str, Extension]:
    """Extension id -> what it adds, as `extensions.yaml` says.  The ids are those of the causes of diagnosis."""
    dof, found = {"3dof": True, "response": False}, {}
    for name, row in _file()["extensions"].items():
        apply = _absorbed(row["absorbed"]) if "absorbed" in row else _by_row(row)
        needed = next(iter(row.get("quantity", ())), None)
        found[name] = Extension(
            row["parameters"], apply, dof.get(row.get("of", "")), tuple(row.get("held", ())), needed
        )
    found["speed_loss"] = replace(found["speed_loss"], apply=_speed_loss)
    return found


def _by_text(name: str, axis: str, kind: str, of: str) -> Extension:
    """The force of a row of `extensions.yaml`."""
    row = _file()["forces"][kind]
    unit = AXES[axis][1] + (PER[of] if kind in ("growth", "past") else "")
    units = {f"{name}_{part}": own if own in ("s", "m") else unit + own for part, own in row["units"].items()}
    names = {f"{{{part}}}": f"{name}_{part}" for part in map(str, row["units"])}
    names["{of}"] = {"d": "delta"}.get(of, PLACES.get(of, of))

    def written(text: str) -> str:
        return re.sub(r"{\w+}", lambda found: names[found[0]], text)

    made: dict[str, Any] = {"force": {axis: written(row["force"])}}
    if "state" in row:
        made["states"] = {f"{name}_late_state": written(row["state"])}
    held = [one for one, own in units.items() if own in ("s", "m")]
    return Extension(units, _by_row(made), axis != RESPONSE, tuple(held))


TERM = re.compile("[XYN](_(v|r|d|absv|absr|absd))+|R(_(r|d|absr|absd))+")
"""Identifier of an added force or moment that is a product: N_r_absv is N' r' |v'|, d the rudder angle (rad); R_r_absd
is a yaw acceleration r |d| of a response model, r in rad/s."""

FORCE = re.compile(
    "(?!R_(speed|curve_(north|east|v)|beyond|past_v|growth_v))(?P<axis>[XYNR])_"
    "(heading_(?P<count>[1-4])|(?P<speed>speed)|past_(?P<past>[vrd])|curve_(?P<curve>north|east|[vrd])"
    "|beyond_(?P<beyond>north|east)|growth_(?P<growth>[vrd])|(?P<time>time|from|span|period))"
)
"""Identifier of an added force by the heading (so many times a turn), the speed, the past of sway, yaw rate or rudder,
a curve of the place, v', r' or the rudder angle, the place beyond which it acts, or the time from the start of a record
(alone, or as a share of a motion that grows); R is the yaw acceleration of a response model."""


def waves_of(variable: str) -> int:
    """Cosines over the range of a place, or of v', r' or the rudder angle, that a curve is made of."""
    return 3 if variable in PLACES else 5


RUDDER_FORCE, OFFSET = "rudder_force", "rudder_offset"
"""What may differ in a regime beside single numbers: all that the rudder adds to the forces, its neutral angle."""


def is_made_up(name: str) -> bool:
    """Whether an extension's identifier says all of it: a product, a force, or a number that differs in a regime."""
    return any(pattern.fullmatch(name) for pattern in (TERM, FORCE, EXTENSION))


def extension_of(name: str) -> Extension:
    """The extension of an identifier: one of `extensions`, a product term or a force of a 3-DOF model, or a number in a
    regime.

    Raises
    ------
    KeyError : if there is none.
    """
    local = EXTENSION.fullmatch(name)
    if local is not None:
        names, unit = regime_parameters(name), VARIABLES[local["variable"]]
        units = dict(zip(names, ("rad" if local["number"] == OFFSET else "1", unit, unit), strict=True))
        return Extension(units, _in_regime(**local.groupdict()), held=names)
    force = FORCE.fullmatch(name)
    if force is not None:
        kinds = [*FORCE.groupindex][1:]
        kind, value = next((one, force[one]) for one in kinds if force[one] is not None)
        if kind == "curve":
            return _by_curve(name, force["axis"], value)
        return _by_text(name, force["axis"], value if kind == "time" else kind, value)
    if TERM.fullmatch(name) is None:
        return extensions()[name]
    axis, *factors = name.split("_")
    product = "*".join(f"absv({factor[3:]})" if factor.startswith("abs") else factor for factor in factors)
    parameter, response = f"term_{name}", axis == RESPONSE
    row = {"added": {parameter: [axis, product]}}
    return Extension({parameter: "SI" if response else "1"}, _by_row(row), not response)


def regime_parameters(name: str) -> tuple[str, str, str]:
    """Parameters of the extension of a number in a regime: size, threshold and width."""
    return f"{name}_size", f"{name}_threshold", f"{name}_width"


def _in_regime(number: str, variable: str, side: str) -> Apply:
    """A number times (1 + size) inside a regime; the neutral rudder angle is shifted by the size.

    Eq. 11 of docs/mathematics/pieces.md.
    """

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        size, threshold, width = parameters
        share, z = symbols(f"{size.name}_inside {size.name}_z")
        value = _variable(definition, variable)
        own = {z: (-1 if side in ("below", "port") else 1) * (value - threshold) / width}
        own[share] = (1 + z / sp.sqrt(1 + z**2)) / 2
        delta = definition.inputs[0]
        if number == RUDDER_FORCE:
            still = {delta: sp.S.Zero, **{s: sp.S.Zero for s in definition.inputs if s.name == "delta_rate"}}
            forces = [f + size * share * (f - _swap(f, still)) for f in definition.forces]
            changed = replace(definition, forces=forces)
        elif number == OFFSET:
            changed = _substitute(definition, {delta: delta + size * share})
        else:
            symbol = next(s for s in definition.parameters if s.name == number)
            changed = _substitute(definition, {symbol: symbol * (1 + size * share)})
        return _timed(replace(changed, helpers={**own, **changed.helpers}), value)

    return apply


def _variable(definition: Definition, variable: str) -> sp.Expr:
    """The variable of a regime."""
    known = {s.name: s for s in definition.states}
    if variable == "time":
        return sp.Symbol(CLOCK, real=True)
    if variable == "speed":
        return sp.sqrt(known["u"] ** 2 + known["v"] ** 2 + sp.Float(1e-12))
    if variable == "side":
        return known["r"]
    if variable == "drift":
        value = primitives.atan2v(known["v"], known["u"])
    else:
        value = definition.inputs[0] if variable == "rudder" else known["r"]
    return cast("sp.Expr", primitives.absv(value))


def _by_curve(name: str, axis: str, curve: str) -> Extension:
    """The sum of a_k cos(k pi s), k = 1, 2, ..., of s = (x - first)/span, 0 to 1 and constant beyond; x is the place,
    or in the prime system v', r' or the rudder angle."""

    row, unit_of_force = AXES[axis]

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        *sizes, first, span = parameters
        helpers, motion, unit = _motion(definition, first.name)
        share = sp.Symbol(f"{first.name}_share", real=True)
        force = sum((a * sp.cos(k * sp.pi.evalf() * share) for k, a in enumerate(sizes, 1)), sp.S.Zero)
        if curve in PLACES:
            helpers, at, changed = {}, _state(definition, PLACES[curve]), _pushed(definition, row, force)
        else:
            at, changed = motion[curve], _with_force(definition, row, unit[row] * force)
        along = (at - first) / span
        inside = (primitives.absv(along) - primitives.absv(along - 1) + 1) / 2
        return replace(changed, helpers={**helpers, share: inside, **changed.helpers})

    unit = "m" if curve in PLACES else "rad" if curve == "d" else "1"
    of_force = unit_of_force if curve in PLACES or axis == RESPONSE else "1"
    held = (f"{name}_first", f"{name}_span")
    units = {f"{name}_{k}": of_force for k in range(1, waves_of(curve) + 1)} | dict.fromkeys(held, unit)
    return Extension(units, apply, three_dof=axis != RESPONSE, held=held)


def extended(definition: Definition, name: str) -> Definition:
    """The definition with one extension, its parameters appended to the coefficients.

    Raises
    ------
    ValueError : if the family cannot carry it.
    """
    extension = extension_of(name)
    parameters = symbols(" ".join(extension.units))
    if not carries(definition, name):
        raise ValueError(f"{definition.name} cannot carry the extension {name}")
    changed = extension.apply(definition, parameters)
    constants = [*changed.constants, *_unknown(changed, parameters)]
    own = dict(extension.units)
    return replace(
        changed,
        name=f"{definition.name}+{name}",
        title=f"{definition.title}, {name.replace('_', ' ')}",
        coefficients=[*definition.coefficients, *parameters],
        constants=constants,
        units={**definition.units, **own},
        public=None if definition.public is None else {**definition.public, **{p.name: p for p in parameters}},
        inverse=None if definition.inverse is None else {**definition.inverse, **{p.name: p for p in parameters}},
        held=[*definition.held, *(p for p in parameters if p.name in extension.held)],
        linear=False,
    )


def _unknown(definition: Definition, parameters: Sequence[sp.Symbol]) -> list[sp.Symbol]:
    """Further constants that an extension has added, by name."""
    expressions = [*definition.forces, *definition.kinematics, *definition.helpers.values(), *definition.mass]
    used = set().union(*(sp.sympify(e).free_symbols for e in expressions))
    known = {*definition.states, *definition.inputs, *definition.parameters, *definition.helpers, *parameters}
    return sorted((s for s in used - known if isinstance(s, sp.Symbol)), key=lambda s: s.name)


def carries(definition: Definition, name: str) -> bool:
    """Whether a family can carry an extension that it does not have yet."""
    parts = (definition.parameters, definition.states, definition.helpers)
    named = ([s.name for s in part] for part in parts)
    return fits(name, *named, three_dof=definition.force_scale is not None)


def fits(name: str, numbers: Sequence[str], states: Sequence[str], helpers: Sequence[str], three_dof: bool) -> bool:
    """The same by the names of a definition's coefficients and constants, states and intermediate quantities."""
    local = EXTENSION.fullmatch(name)
    if local is not None:
        lacking = {"drift": {"u", "v"}, "speed": {"u", "v"}}.get(local["variable"], {"r"}) - {*states}
        known = local["number"] in {*numbers, RUDDER_FORCE, OFFSET}
        return known and not lacking and regime_parameters(name)[0] not in numbers
    extension = extension_of(name)
    fitting = extension.three_dof is None or extension.three_dof == three_dof
    fitting &= extension.helper is None or extension.helper in helpers
    first_order = states[0] == "r" and "lead_state" not in states
    return fitting and not set(numbers) & set(extension.units) and (name != "second_order_lead" or first_order)
