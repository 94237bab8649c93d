"""MATLAB and Simulink: a struct of the numbers, the derivative as a function, and scripts for idgrey and idnlgrey."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from ..definition import Definition
from ..model import Model
from ..simulate import initial_state
from .equations import Octave, definition, gear, heading, identifier, statements
from .texts import inert


def simulink(model: Model) -> dict[str, str]:
    """File name -> text.

    NAME.m returns the struct; NAME_ode.m is the derivative dx = f(t, x, u, p), which a MATLAB Function block of
    Simulink or `ode45` takes; NAME_idnlgrey.m with NAME_idnl.m starts a grey-box estimation, and of a linear model
    NAME_idgrey.m with NAME_matrices.m.
    """
    own, name = definition(model), identifier(model)
    files = {
        f"{name}.m": _struct(model, name),
        f"{name}_ode.m": _ode(model, own, name),
        f"{name}_idnl.m": _idnl(model, name),
        f"{name}_idnlgrey.m": _idnlgrey(model, own, name),
    }
    if own.linear:
        files |= {f"{name}_matrices.m": _matrices(model, own, name), f"{name}_idgrey.m": _idgrey(model, name)}
    return files


def _text(value: str) -> str:
    return f"'{inert(value)}'"


def _cell(values: Sequence[str]) -> str:
    return "{" + ", ".join(map(_text, values)) + "}"


def _number(value: float) -> str:
    return {"inf": "Inf", "-inf": "-Inf", "nan": "NaN"}.get(repr(value), repr(value))


def _fields(group: str, values: Mapping[str, float]) -> list[str]:
    return [f"p.{group}.{name} = {_number(value)};" for name, value in values.items()]


def _comments(model: Model) -> list[str]:
    return [f"% {line}" for line in heading(model)]


def _struct(model: Model, name: str) -> str:
    lines = [f"function p = {name}()", *_comments(model), f"p.id = {_text(model.id)};"]
    lines += [f"p.family = {_text(model.family)};", f"p.positive_rudder = {_text(model.positive_rudder)};"]
    lines += [f"p.states = {_cell(model.states)};", f"p.inputs = {_cell(model.inputs)};"]
    start = " ".join(_number(value) for value in initial_state(model).tolist())
    lines += [f"p.x0 = [{start}]';  % straight course", f"p.max_step_s = {_number(model.max_step_s)};"]
    lines += _fields("coefficients", dict(zip(model.coordinates, model.coefficients.tolist(), strict=True)))
    lines += _fields("constants", dict(zip(model.constant_names, model.constants.tolist(), strict=True)))
    lines += _fields("parameters", model.parameters)
    units = zip(model.parameter_names, model.parameter_units, strict=True)
    lines += [f"p.units.{parameter} = {_text(unit)};" for parameter, unit in units]
    lines += _fields("rudder", gear(model))
    return "\n".join([*lines, "end", ""])


def _ode(model: Model, own: Definition, name: str) -> str:
    lines = [f"function dx = {name}_ode(t, state, input, p)", *_comments(model)]
    for group, symbols in (("state", own.states), ("input", own.inputs)):
        lines += [f"% {group}: {', '.join(s.name for s in symbols)}"]
        lines += [f"{symbol.name} = {group}({place});" for place, symbol in enumerate(symbols, 1)]
    for group, symbols in (("coefficients", own.coefficients), ("constants", own.constants)):
        lines += [f"{symbol.name} = p.{group}.{symbol.name};" for symbol in symbols]
    lines += [f"{left} = {right};" for left, right in statements(own, Octave())]
    lines += [f"dx = [{'; '.join(f'd_{symbol.name}' for symbol in own.states)}];", "end", ""]
    return "\n".join(lines)


def _idnl(model: Model, name: str) -> str:
    lines = [f"function [dx, y] = {name}_idnl(t, x, u, coefficients, varargin)", *_comments(model), f"p = {name}();"]
    lines += [f"p.coefficients.{c} = coefficients({place});" for place, c in enumerate(model.coordinates, 1)]
    return "\n".join([*lines, f"dx = {name}_ode(t, x, u, p);", "y = x;", "end", ""])


def _idnlgrey(model: Model, own: Definition, name: str) -> str:
    count = len(own.states)
    lines = [*_comments(model), "% data: iddata with the inputs and all states as outputs", f"p = {name}();"]
    lines += [f"coefficients = [{'; '.join(f'p.coefficients.{c}' for c in model.coordinates)}];"]
    order = f"[{count} {len(own.inputs)} {count}]"
    lines += [f"sys = idnlgrey({_text(name + '_idnl')}, {order}, {{coefficients}}, p.x0, 0);"]
    lines += [f"sys.InputName = {_cell(model.inputs)};", f"sys.OutputName = {_cell(model.states)};"]
    return "\n".join([*lines, "% sys = nlgreyest(data, sys);", ""])


def _matrices(model: Model, own: Definition, name: str) -> str:
    """A, B, C, D of x' = A x + B u, y = x: the mass is a unit matrix in every linear family."""
    rates = sp.Matrix([*(own.mass.inv() * sp.Matrix(own.forces)), *own.kinematics])
    rates = rates.subs(dict(reversed(list(own.helpers.items()))))
    given = [symbol.name for symbol in own.coefficients]
    lines = [f"function [A, B, C, D] = {name}_matrices({', '.join([*given, 'Ts'])})", *_comments(model)]
    if own.constants:
        lines += [f"p = {name}();"]
    lines += [f"{symbol.name} = p.constants.{symbol.name};" for symbol in own.constants]
    for letter, by in (("A", own.states), ("B", own.inputs)):
        rows = rates.jacobian(list(by)).tolist()
        lines += [f"{letter} = [{'; '.join(', '.join(str(Octave().doprint(v)) for v in row) for row in rows)}];"]
    count = len(own.states)
    return "\n".join([*lines, f"C = eye({count});", f"D = zeros({count}, {len(own.inputs)});", "end", ""])


def _idgrey(model: Model, name: str) -> str:
    pairs = ", ".join(f"{_text(c)}, p.coefficients.{c}" for c in model.coordinates)
    lines = [*_comments(model), f"p = {name}();", f"sys = idgrey({_text(name + '_matrices')}, {{{pairs}}}, 'c');"]
    lines += [f"sys.InputName = {_cell(model.inputs)};", f"sys.OutputName = {_cell(model.states)};"]
    return "\n".join([*lines, "% sys = greyest(data, sys);", ""])
