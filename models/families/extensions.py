"""Extensions of any definition: terms with parameters of their own that are zero where the effect is absent.

A family id may carry extensions: ``abkowitz+rudder_offset+yaw_damping_quadratic``.  Their parameters are further
coefficients.

Added hydrodynamic terms are in the prime system F' = F / (rho A U^2 / 2), N' = N / (rho A L U^2 / 2) with
v' = v/U and r' = r L/U at the instantaneous speed U through the water; A = L d where the family knows the draught d,
else L^2.

One file, although a long one: the table of extensions is read together with the formulas that it refers to.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from ..definition import Definition, Later, symbols
from ..regimes import CLOCK, EXTENSION, VARIABLES

if TYPE_CHECKING:
    import sympy as sp

    from .. import primitives
    from . import environment

    Apply = Callable[[Definition, Sequence[sp.Symbol]], Definition]
    Term = Callable[[Mapping[str, sp.Expr]], sp.Expr]
else:  # the table's names and units are asked for without its equations
    sp, primitives, environment = Later("sympy"), Later("..primitives", __package__), Later(".environment", __package__)

YAW, SWAY = 2, 1


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


def _rudder(change: Callable[[sp.Symbol, sp.Symbol], sp.Expr]) -> Apply:
    """The hull feels `change(rudder, parameter)` instead of the recorded rudder angle."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        delta = definition.inputs[0]
        return _substitute(definition, {delta: change(delta, parameters[0])})

    return apply


def _substitute(definition: Definition, swap: Mapping[sp.Symbol, sp.Expr]) -> Definition:
    return replace(
        definition,
        helpers={name: _swap(expression, swap) for name, expression in definition.helpers.items()},
        forces=[_swap(force, swap) for force in definition.forces],
        kinematics=[_swap(expression, swap) for expression in definition.kinematics],
    )


def _swap(expression: sp.Expr, swap: Mapping) -> sp.Expr:
    return cast("sp.Expr", sp.sympify(expression).xreplace(dict(swap)))


def _effectiveness(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    delta, gain = definition.inputs[0], 1 + parameters[0]
    rates = {s: gain * s for s in definition.inputs if s.name == "delta_rate"}
    return _substitute(definition, {delta: gain * delta, **rates})


def _helper(name: str, change: Callable[[sp.Expr, sp.Symbol, Definition], sp.Expr]) -> Apply:
    """An intermediate quantity of the family becomes `change(quantity, parameter, definition)`."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        helpers = {
            symbol: change(sp.sympify(expression), parameters[0], definition) if symbol.name == name else expression
            for symbol, expression in definition.helpers.items()
        }
        return replace(definition, helpers=helpers)

    return apply


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


def _added(*terms: tuple[int, Term]) -> Apply:
    """Terms of the motion in the prime system, one for each parameter, in the row of sway or yaw; of a response model
    in its yaw equation, of r in rad/s."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        helpers, motion, unit = _motion(definition, parameters[0].name)
        changed = replace(definition, helpers={**definition.helpers, **helpers})
        for (row, term), parameter in zip(terms, parameters, strict=True):
            own = row % len(unit)
            changed = _with_force(changed, own, unit[own] * parameter * term(motion))
        return changed

    return apply


def _alone(motion: Mapping[str, sp.Expr]) -> sp.Expr:
    return sp.S.One


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


DRIFT = (0.010, 0.020, 0.002)
"""Mean wave drift coefficients in surge, sway and yaw (times the length), those of `datasets.disturbances`."""


def _drift(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    """Mean wave drift rho g Hs^2 L as an earth-fixed vector towards where the waves come from, on the hull:
    X = -.010 along (times .3 in following seas), Y = -.020 across |across|/size, N = -.002 L 2 along across/size."""
    psi = _state(definition, "psi")
    length = next((s for s in definition.constants if s.name == "L"), sp.Symbol("wind_L", real=True))
    along, across, size = symbols("drift_along drift_across drift_size")
    north, east = parameters
    helpers = {
        along: north * sp.cos(psi) + east * sp.sin(psi),
        across: -north * sp.sin(psi) + east * sp.cos(psi),
        size: sp.sqrt(north**2 + east**2 + sp.Float(1e-12)),
    }
    surge = -sp.Float(DRIFT[0]) * along * (sp.Float(0.3) + sp.Float(0.7) * primitives.step(along))
    sway = -sp.Float(DRIFT[1]) * across * primitives.absv(across) / size
    yaw = -sp.Float(2 * DRIFT[2]) * length * across * along / size
    changed = replace(definition, helpers={**definition.helpers, **helpers})
    for row, force in enumerate((surge, sway, yaw)):
        changed = _pushed(changed, row, force)
    return changed


def _lead(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    """Rudder through (1 + T3 s)/(1 + T2 s), T3 = T2 (1 - lead).

    delta_hull = delta + lead (z - delta) with the state T2 z_dot = delta - z.
    With a first-order Nomoto model behind it this is the second-order one.
    """
    lead, time = parameters
    delta, z = definition.inputs[0], sp.Symbol("lead_state", real=True)
    swapped = _substitute(definition, {delta: delta + lead * (z - delta)})
    return replace(
        swapped,
        states=[*definition.states, z],
        kinematics=[*swapped.kinematics, (delta - z) / time],
    )


def _wind_on_yaw(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    """Yaw moment of the wind over the hull, from its velocity through the air (u_a, v_a): k1 v_a |V_a| + k2 u_a v_a.

    The two shapes are those of sin and sin 2 of the apparent angle (Isherwood 1972; Fujiwara et al. 1998).  Inputs
    added: wind north and east [m/s, towards].  A model that knows no speed has none of its own through the air.
    """
    across, both = parameters
    psi = _state(definition, "psi")
    north, east = inputs = symbols("wind_north wind_east")
    own = next((s for s in definition.inputs if s.name == "speed"), sp.S.Zero)
    ahead, side = symbols("air_ahead air_side")
    helpers = {
        ahead: own - north * sp.cos(psi) - east * sp.sin(psi),
        side: north * sp.sin(psi) - east * sp.cos(psi),
    }
    size = sp.sqrt(ahead**2 + side**2 + sp.Float(1e-12))
    force = definition.forces[0] + across * side * size + both * ahead * side
    return replace(
        definition,
        inputs=[*definition.inputs, *inputs],
        helpers={**definition.helpers, **helpers},
        forces=[force, *definition.forces[1:]],
    )


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


OWN_SPEED = {
    "speed_drive": "m/s2", "speed_drag": "1/m", "turn_drag": "m", "sway_lever": "m", "sway_time": "s",
}  # fmt: skip


def _own_speed(by_propeller: bool) -> Apply:
    """Surge and sway as states of a response model, in the place of a measured speed; the positions' speed is theirs.

    u_dot = drive + push n |n| - drag u |u| - turn_drag r^2,  sway_time v_dot = -(v + lever r): thrust against
    resistance, the loss in turns, and a hull that drifts about a point `lever` ahead of where sway is measured.  The
    speed is negative astern, as a measured one (`speed_of`).
    """

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        drive, drag, turning, lever, time = parameters[:5]
        r = _state(definition, "r")
        u, v, n, speed = symbols("u v n speed")
        has = {symbol.name for symbol in definition.inputs}
        inputs = [s for s in definition.inputs if s != speed]
        inputs += [n] if by_propeller and "n" not in has else []
        whole = primitives.sgn(u) * sp.sqrt(u**2 + v**2 + sp.Float(1e-12))
        changed = _substitute(definition, {speed: whole}) if "speed" in has else definition
        push = parameters[5] * n * primitives.absv(n) if by_propeller else sp.S.Zero
        surge = drive + push - drag * u * primitives.absv(u) - turning * r**2
        return replace(
            changed,
            states=[*definition.states, u, v],
            inputs=inputs,
            kinematics=[*changed.kinematics, surge, -(v + lever * r) / time],
            linear=False,
        )

    return apply


RIGID = "rigid_mass rigid_moment rigid_inertia"
"""Rigid-body mass [kg], m x_G [kg m] and yaw inertia [kg m2]: constants of the loading extension."""


def _loaded(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
    """Rigid-body mass, moment and inertia times (1 + fraction), added masses and hydrodynamic forces as they are."""
    (fraction,) = parameters
    mass, moment, inertia = symbols(RIGID)
    u, v, r = definition.states[:3]
    scale = definition.force_scale
    assert scale is not None
    rigid = sp.Matrix([[mass, 0, 0], [0, mass, moment], [0, moment, inertia]])
    carried = [mass * v * r + moment * r**2, -mass * u * r, -moment * u * r]
    return replace(
        definition,
        mass=definition.mass + fraction * sp.diag(*scale) * rigid,
        forces=[f + fraction * k * c for f, k, c in zip(definition.forces, scale, carried, strict=True)],
    )


def _size_of(*names: str) -> Term:
    """A product of the first motion and the size of the second, such as r |v|."""
    return lambda m: m[names[0]] * primitives.absv(m[names[1]])


class Axis(NamedTuple):
    """Where a force acts: row in the equations, unit, and whether it is the yaw acceleration of a response model."""

    row: int
    unit: str
    response: bool = False

    @classmethod
    def of(cls, letter: str) -> Axis:
        """Of X, Y, N of a 3-DOF model, R of a response model."""
        return cls("XYN".index(letter), "N m" if letter == "N" else "N") if letter != RESPONSE else YAW_ACCELERATION

    def per(self, motion: str) -> str:
        """The unit of a force over that of a motion."""
        return self.unit + {"v": " s/m", "r": " s/rad", "d": "/rad"}[motion]

    def extension(self, units: Mapping[str, str], force: Callable[..., sp.Expr], held: Sequence[str] = ()) -> Extension:
        """A force, N, or moment, N m, of the definition and of the parameters."""

        def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
            return _pushed(definition, self.row, force(definition, *parameters))

        return Extension(units, apply, three_dof=not self.response, held=tuple(held))


ANY_ORDER = "rad/s^k"
"""Unit of a response model's yaw acceleration: k is the order of the highest derivative."""
RESPONSE = "R"
YAW_ACCELERATION = Axis(0, ANY_ORDER, response=True)


PLACES = {"north": "x", "east": "y"}
"""Place -> its state."""
TEXTS: Mapping[str, tuple[str, Mapping[str, str]]] = {
    "count": ("a*cos(w*psi) + b*sin(w*psi)", {"cos": "", "sin": ""}),
    "speed": ("a*sqrt(u**2 + v**2 + 1e-12) + b*(u**2 + v**2 + 1e-12)", {"1": " s/m", "2": " s2/m2"}),
    "beyond": (
        "a + step(w - e)*(b + c*cos(psi) + d*sin(psi))",
        {"first": "", "size": "", "cos": "", "sin": "", "place": "m"},
    ),
    "growth": ("a*t*w", {"size": "/s"}),
    "time": ("a + b*t", {"first": "", "growth": "/s"}),
    "from": ("a*step(t - b)", {"size": "", "begin": "s"}),
    "span": ("a*(step(t - b) - step(t - c))", {"size": "", "begin": "s", "end": "s"}),
    "period": ("a*cos(2*pi*t/c) + b*sin(2*pi*t/c)", {"cos": "", "sin": "", "time": "s"}),
}
"""Force along the motion -> its formula in its parameters a, b, ..., the states, the time t and w, what it is of (a
number of turns, a place, a motion), and the parameters' units: s and m as they are, others behind that of the force.
With w = 1 turn by the heading it is that of a steady wind on a craft that turns in it."""


def _by_text(name: str, axis: Axis, kind: str, of: str) -> Extension:
    """The force of a row of `TEXTS`."""
    text, parts = TEXTS[kind]
    unit = axis.per(of) if kind == "growth" else axis.unit
    units = {f"{name}_{part}": own if own in ("s", "m") else unit + own for part, own in parts.items()}

    def force(definition: Definition, *parameters: sp.Symbol) -> sp.Expr:
        words: dict[str, Any] = {s.name: s for s in definition.states} | dict(zip("abcde", parameters, strict=False))
        words |= {"t": sp.Symbol(CLOCK, real=True), "pi": sp.pi.evalf(), "step": primitives.step}
        words["w"] = int(of) if of.isdigit() else words.get(PLACES.get(of, of), definition.inputs[0])
        parsed: Any = sp.sympify  # its overloads do not tell of `locals`
        return parsed(text, locals=words)

    return axis.extension(units, force, held=[one for one, own in units.items() if own in ("s", "m")])


EXTENSIONS: dict[str, Extension] = {
    "rudder_offset": Extension({"rudder_offset": "rad"}, _rudder(lambda d, p: d + p), held=("rudder_offset",)),
    "rudder_effectiveness": Extension({"rudder_effectiveness": "1"}, _effectiveness, held=("rudder_effectiveness",)),
    "yaw_damping_quadratic": Extension({"added_Nr_absr": "1"}, _added((YAW, _size_of("r", "r")))),
    "yaw_damping_cubic": Extension({"added_Nrrr": "1"}, _added((YAW, lambda m: m["r"] ** 3))),
    "still_damping": Extension({"still_damping": "1/s"}, _added((YAW, lambda m: -m["r"])), three_dof=False),
    "sway_damping_quadratic": Extension({"added_Yv_absv": "1"}, _added((SWAY, _size_of("v", "v"))), three_dof=True),
    "crossflow_coupling": Extension(
        dict.fromkeys(("added_Yr_absv", "added_Yv_absr", "added_Nv_absr", "added_Nr_absv"), "1"),
        _added(
            (SWAY, _size_of("r", "v")),
            (SWAY, _size_of("v", "r")),
            (YAW, _size_of("v", "r")),
            (YAW, _size_of("r", "v")),
        ),
        three_dof=True,
    ),
    "current": Extension(
        {"current_towards_north": "m/s", "current_towards_east": "m/s"},
        _absorbed("current_north current_east"),
        three_dof=True,
        held=("current_towards_north", "current_towards_east"),
    ),
    "wind": Extension(
        {"wind_towards_north": "m/s", "wind_towards_east": "m/s"},
        _absorbed("wind_north wind_east"),
        three_dof=True,
        held=("wind_towards_north", "wind_towards_east"),
    ),
    "constant_force": Extension(
        {"constant_X": "N", "constant_Y": "N", "constant_N": "N m"},
        _absorbed("force_x force_y moment_n"),
        three_dof=True,
    ),
    "wave_drift": Extension(
        {"wave_drift_north": "N", "wave_drift_east": "N"},
        _drift,
        three_dof=True,
        held=("wave_drift_north", "wave_drift_east"),
    ),
    "propeller_thrust": Extension(
        {"thrust_scale": "1"}, _helper("thrust", lambda f, p, d: (1 + p) * f), held=("thrust_scale",), helper="thrust"
    ),
    "rudder_large_angle": Extension(
        {"rudder_law": "1"},
        _helper("F_N", lambda f, p, d: f * (1 + p * sp.sin(d.inputs[0]) ** 2)),
        held=("rudder_law",),
        helper="F_N",
    ),
    "asymmetry": Extension(
        {"asymmetry_Y": "1", "asymmetry_N": "1"}, _added((SWAY, _alone), (YAW, _alone)), three_dof=True
    ),
    "loading_change": Extension({"loading_fraction": "1"}, _loaded, three_dof=True, held=("loading_fraction",)),
    "constant_yaw": Extension({"constant_yaw": ANY_ORDER}, _added((YAW, _alone)), three_dof=False),
    "second_order_lead": Extension({"lead": "1", "lead_T2": "s"}, _lead, three_dof=False, held=("lead", "lead_T2")),
    "rudder_asymmetry": Extension(
        {"rudder_asymmetry": "1"}, _rudder(lambda d, p: d + p * primitives.absv(d)), held=("rudder_asymmetry",)
    ),
    "rudder_stall": Extension(
        {"rudder_stall": "1/rad"}, _rudder(lambda d, p: d / (1 + p * primitives.absv(d))), held=("rudder_stall",)
    ),
    "heading_moment": _by_text("heading_moment", YAW_ACCELERATION, "count", "1"),
    "measured_wind": Extension({"wind_across": "rad/m2", "wind_both": "rad/m2"}, _wind_on_yaw, three_dof=False),
    "speed_loss": Extension(
        {"loss_gain": "s2/rad2", "loss_time": "s", "loss_power": "1"},
        _speed_loss,
        three_dof=False,
        held=("loss_gain", "loss_time", "loss_power"),
    ),
    "own_speed": Extension(OWN_SPEED, _own_speed(False), three_dof=False, held=tuple(OWN_SPEED)),
    "own_speed_by_propeller": Extension(
        OWN_SPEED | {"speed_push": "m"}, _own_speed(True), three_dof=False, held=(*OWN_SPEED, "speed_push")
    ),
}
"""Extension id -> what it adds.  The ids are those of the causes of diagnosis."""

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
    """The extension of an identifier: one of EXTENSIONS, a product term or a force of a 3-DOF model, or a number in a
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
        axis, kinds = Axis.of(force["axis"]), [*FORCE.groupindex][1:]
        kind, value = next((one, force[one]) for one in kinds if force[one] is not None)
        made = {"past": _of_the_past, "curve": _by_curve}.get(kind)
        return made(name, axis, value) if made else _by_text(name, axis, value if kind == "time" else kind, value)
    if TERM.fullmatch(name) is None:
        return EXTENSIONS[name]
    axis, *factors = name.split("_")

    def product(motion: Mapping[str, sp.Expr]) -> sp.Expr:
        """Of v', r' and the rudder angle, or of their sizes; of r and the rudder angle of a response model."""
        known = {**motion, **{f"abs{name}": primitives.absv(symbol) for name, symbol in motion.items()}}
        return sp.prod(known[factor] for factor in factors)

    if axis == RESPONSE:
        return Extension({f"term_{name}": "SI"}, _added((YAW, product)), three_dof=False)
    return Extension({f"term_{name}": "1"}, _added(("XYN".index(axis), product)), three_dof=True)


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


# ---- Forces and moments along the motion; of sway, yaw rate and rudder angle in SI units unless primes are named.


def _of_the_past(name: str, axis: Axis, motion: str) -> Extension:
    """a x + b z with T z_dot = x - z, x the motion.

    Memory that is linear in the velocities: W. E. Cummins, The impulse response function and ship motions, 1962.
    """

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        now, late, time = parameters
        x, z = _own_motion(definition, motion), sp.Symbol(f"{late.name}_state", real=True)
        changed = _pushed(definition, axis.row, now * x + late * z)
        return replace(changed, states=[*changed.states, z], kinematics=[*changed.kinematics, (x - z) / time])

    units = {f"{name}_now": axis.per(motion), f"{name}_late": axis.per(motion), f"{name}_time": "s"}
    return Extension(units, apply, three_dof=not axis.response, held=(f"{name}_time",))


def _own_motion(definition: Definition, motion: str) -> sp.Symbol:
    """Sway, m/s, yaw rate, rad/s, or rudder angle, rad."""
    return definition.inputs[0] if motion == "d" else _state(definition, motion)


def _by_curve(name: str, axis: Axis, curve: str) -> Extension:
    """The sum of a_k cos(k pi s), k = 1, 2, ..., of s = (x - first)/span, 0 to 1 and constant beyond; x is the place,
    or in the prime system v', r' or the rudder angle."""

    def apply(definition: Definition, parameters: Sequence[sp.Symbol]) -> Definition:
        *sizes, first, span = parameters
        helpers, motion, unit = _motion(definition, first.name)
        share = sp.Symbol(f"{first.name}_share", real=True)
        force = sum((a * sp.cos(k * sp.pi.evalf() * share) for k, a in enumerate(sizes, 1)), sp.S.Zero)
        if curve in PLACES:
            helpers, at, changed = {}, _state(definition, PLACES[curve]), _pushed(definition, axis.row, force)
        else:
            at, changed = motion[curve], _with_force(definition, axis.row, unit[axis.row] * force)
        along = (at - first) / span
        inside = (primitives.absv(along) - primitives.absv(along - 1) + 1) / 2
        return replace(changed, helpers={**helpers, share: inside, **changed.helpers})

    unit = "m" if curve in PLACES else "rad" if curve == "d" else "1"
    of_force = axis.unit if curve in PLACES or axis.response else "1"
    held = (f"{name}_first", f"{name}_span")
    units = {f"{name}_{k}": of_force for k in range(1, waves_of(curve) + 1)} | dict.fromkeys(held, unit)
    return Extension(units, apply, three_dof=not axis.response, held=held)


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
