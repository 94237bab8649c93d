"""A model's equations from its symbolic definition: MathML for pages, LaTeX for Markdown.

What an extension added is marked: whole terms that its parameters multiply, else its symbols where they stand.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import sympy as sp

from .equation_lines import EquationLine, equation, statement, value_of
from .numbers import DEG, with_unit

if TYPE_CHECKING:
    from ..models.definition import Definition
    from ..models.model import Model

RUDDER_SIDE = ("rudder_offset", "rudder_effectiveness")
"""Extensions that are shown as a relation between the recorded and the effective rudder angle."""


@dataclass(frozen=True)
class Equations:
    """The equations in reading order; `added`: the values of new parameters."""

    relations: tuple[EquationLine, ...]
    dynamics: tuple[EquationLine, ...]
    helpers: tuple[EquationLine, ...]
    added: tuple[EquationLine, ...]


def equations(model: Model, base: Model) -> Equations:
    """The equations of an extended model; what `base` does not have is marked as new.

    Terms whose coefficient is zero are left out.
    """
    from ..models.kernels import definition_of

    own = [part for part in model.family.split("+")[1:] if part not in base.family.split("+")[1:]]
    as_relations = [part for part in own if part in RUDDER_SIDE]
    family = "+".join([model.family.split("+")[0], *(p for p in model.family.split("+")[1:] if p not in as_relations)])
    definition = definition_of(family)
    fresh = {name for name in model.coordinates if name not in base.coordinates}
    hull = bool(as_relations or _rudder_numbers(model, base))
    if hull:
        definition = _renamed(definition, {definition.inputs[0]: sp.Symbol("delta_hull", real=True)})
    marks = _marks(definition, fresh, {symbol.name for symbol in definition_of(base.family).helpers})
    values = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    zero = {s: sp.S.Zero for s in definition.coefficients if values.get(s.name) == 0.0 and s.name not in fresh}
    dynamics = tuple(_dynamics(definition, zero, marks))
    helpers = tuple(_helpers(definition, zero, marks))
    units = dict(zip(model.coordinates, model.parameter_units, strict=False))
    added = [value_of(n, _with_unit(values[n], units.get(n, ""))) for n in model.coordinates if n in fresh]
    return Equations(tuple(_relations(model, base, as_relations)), dynamics, helpers, tuple(added))


def _with_unit(value: float, unit: str) -> str:
    """The value of a parameter, an angle in degrees."""
    shown, factor = ("deg", DEG) if unit == "rad" else (unit, 1.0)
    return with_unit(factor * value, shown, 4)


# ---- the parts


def _dynamics(definition: Definition, zero: Mapping, marks: Mapping[str, bool]) -> Iterable[EquationLine]:
    size = len(definition.forces)
    for row, force in enumerate(definition.forces):
        left = [
            (definition.mass[row, j], definition.states[j].name) for j in range(size) if definition.mass[row, j] != 0
        ]
        shown = force.xreplace(dict(zero))
        yield equation(left, shown if definition.force_scale is not None else sp.expand(shown), marks)
    for state, rate in zip(definition.states[size:], definition.kinematics, strict=True):
        yield equation([(1, state.name)], rate.xreplace(dict(zero)), marks, whole=state.name in marks)


def _helpers(definition: Definition, zero: Mapping, marks: Mapping[str, bool]) -> Iterable[EquationLine]:
    seen = set()
    for symbol, expression in definition.helpers.items():
        clean = _without_floor(expression.xreplace(dict(zero)))
        line = equation([(symbol, None)], clean, marks, whole=symbol.name in marks)
        if line.pieces not in seen and clean != 0:
            seen.add(line.pieces)
            yield line


def _relations(model: Model, base: Model, as_relations: Sequence[str]) -> Iterable[EquationLine]:
    """Relations of the recorded to the effective rudder angle, and of recorded to true channels, that are new."""
    values = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    rudder = _rudder_numbers(model, base) | {name: values[name] for name in as_relations}
    if rudder:
        yield _rudder_relation(rudder)
    new = {k: v for k, v in model.instruments.items() if base.instruments.get(k) != v}
    yield from _channel_relations(new)
    yield from _velocity_relations(new)
    if "wave_rms" in new:
        yield statement("heading and yaw rate contain narrow-band wave motion")


def _rudder_relation(rudder: Mapping[str, float]) -> EquationLine:
    delay = sp.Symbol("tau_delta") if "rudder_delay" in rudder else 0
    gain = 1 + (sp.Symbol("e") if "rudder_effectiveness" in rudder else 0)
    gain += sp.Symbol("e_fault") if "rudder_fault" in rudder else 0
    sign = -1 if "rudder_reversed" in rudder else 1
    effective = sign * gain * sp.Function("delta")(sp.Symbol("t") - delay)  # ty: ignore[not-callable]
    effective += sp.Symbol("rudder_offset") if "rudder_offset" in rudder else 0
    return replace(equation([(sp.Symbol("delta_hull"), None)], effective, {}, True), note=_limits(rudder))


def _channel_relations(new: Mapping[str, float]) -> Iterable[EquationLine]:
    """Scale, bias and delay of sensors, play of the rudder's, and exchanged columns."""
    from ..models.instruments import SENSORS, SWAPS

    for short in SENSORS:
        own = {kind for kind in ("scale", "curve", "bias", "delay") if f"{short}_{kind}" in new}
        if own:
            channel = short.replace("_", " ")
            delay = sp.Symbol(f"tau_{short}") if "delay" in own else 0
            scale, bias = (sp.Symbol(s) if kind in own else 0 for kind, s in (("scale", "s"), ("bias", "b")))
            true = sp.Function(f"{channel}_true")(sp.Symbol("t") - delay)  # ty: ignore[not-callable]
            curve = sp.Symbol("c") * sp.Abs(true) if "curve" in own else 0
            recorded = true * (1 + scale + curve) + bias
            yield equation([(sp.Symbol(f"{channel}_recorded"), None)], recorded, {}, True)
    if "rudder_hysteresis" in new:
        yield statement("the recorded rudder angle is that of the rudder behind play of ± b of its sensor")
    if "rudder_sensor_delay" in new:
        yield statement("the recorded rudder angle is that of the rudder τ earlier")
    yield from (statement(f"columns {a} and {b} are exchanged") for name, (a, b) in SWAPS.items() if name in new)


def _velocity_relations(new: Mapping[str, float]) -> Iterable[EquationLine]:
    """Recorded velocities in axes that are turned against those of the hull."""
    u, v, alpha, psi = sp.symbols("u v alpha psi")
    if "point_ahead" in new:
        yield equation([(sp.Symbol("sway_recorded"), None)], v + sp.Symbol("x") * sp.Symbol("r"), {}, True)
    if "axis_misalignment" in new:
        yield equation([(sp.Symbol("surge_recorded"), None)], u * sp.cos(alpha) + v * sp.sin(alpha), {}, True)
        yield equation([(sp.Symbol("sway_recorded"), None)], v * sp.cos(alpha) - u * sp.sin(alpha), {}, True)
    if "earth_frame_velocity" in new:
        yield equation([(sp.Symbol("surge_recorded"), None)], u * sp.cos(psi) - v * sp.sin(psi), {}, True)
        yield equation([(sp.Symbol("sway_recorded"), None)], u * sp.sin(psi) + v * sp.cos(psi), {}, True)


def _limits(rudder: Mapping[str, float]) -> str:
    notes = {
        "rudder_backlash": "behind play of ± b",
        "rudder_rate_limit": "with a rate limit",
        "rudder_saturation": "with a largest angle",
        "rudder_fault": "e_fault from the fault time on",
    }
    return ", ".join(text for name, text in notes.items() if name in rudder)


def _rudder_numbers(model: Model, base: Model) -> dict[str, float]:
    from ..models.instruments import RUDDER

    return {k: v for k, v in model.instruments.items() if k in RUDDER and base.instruments.get(k) != v}


def _renamed(definition: Definition, swap: Mapping) -> Definition:
    return replace(
        definition,
        forces=[force.xreplace(dict(swap)) for force in definition.forces],
        kinematics=[rate.xreplace(dict(swap)) for rate in definition.kinematics],
        helpers={name: value.xreplace(dict(swap)) for name, value in definition.helpers.items()},
    )


def _marks(definition: Definition, fresh: set[str], known: set[str]) -> dict[str, bool]:
    """Names of new parameters and of the helpers and states that they brought; True where they vanish at the null, so
    that a term they multiply is new as a whole."""
    marks = dict.fromkeys(fresh, True)
    for symbol, expression in definition.helpers.items():
        if _names(expression) & marks.keys() and symbol.name not in known:
            null = {s: sp.S.Zero for s in expression.free_symbols if marks.get(str(s))}
            marks[symbol.name] = expression.xreplace(null) == 0
    for state, rate in zip(definition.states[len(definition.forces) :], definition.kinematics, strict=True):
        if _names(rate) & fresh:
            marks[state.name] = False
    return marks


def _names(expression: Any) -> set[str]:
    return {symbol.name for symbol in expression.free_symbols}


def _without_floor(expression: Any) -> Any:
    """An expression without the tiny numbers that keep kernels finite at rest."""
    return expression.replace(lambda e: e.is_Float and abs(e) < 1e-9, lambda e: sp.S.Zero)
