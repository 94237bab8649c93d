"""MATLAB and Simulink: a struct of the numbers, the derivative as a function, and scripts for idgrey and idnlgrey."""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from ..definition import Definition
from ..model import Model
from .equations import Octave, values_of
from .texts import inert, template


def simulink(model: Model) -> dict[str, str]:
    """File name -> text.

    NAME.m returns the struct; NAME_ode.m is the derivative dx = f(t, x, u, p), which a MATLAB Function block of
    Simulink or `ode45` takes; NAME_idnlgrey.m with NAME_idnl.m starts a grey-box estimation, and of a linear model
    NAME_idgrey.m with NAME_matrices.m.
    """
    values = values_of(model, Octave())
    own, name = values["own"], values["name"]
    values |= {"coefficients": dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))}
    values |= {"constants": dict(zip(model.constant_names, model.constants.tolist(), strict=True))}
    values |= {"units": dict(zip(model.parameter_names, model.parameter_units, strict=True))}
    values |= {"slopes": _slopes(own) if own.linear else (), "text": _text, "cell": _cell, "number": _number}
    parts = ("struct", "ode", "idnl", "idnlgrey", *(("matrices", "idgrey") if own.linear else ()))
    module = template("simulink.m").make_module(values)
    return {f"{name}.m" if part == "struct" else f"{name}_{part}.m": getattr(module, part)() for part in parts}


def _text(value: str) -> str:
    return f"'{inert(value)}'"


def _cell(values: Sequence[str]) -> str:
    return "{" + ", ".join(map(_text, values)) + "}"


def _number(value: float) -> str:
    return {"inf": "Inf", "-inf": "-Inf", "nan": "NaN"}.get(repr(value), repr(value))


def _slopes(own: Definition) -> list[str]:
    """A and B of x' = A x + B u: the mass is a unit matrix in every linear family."""
    rates = sp.Matrix([*(own.mass.inv() * sp.Matrix(own.forces)), *own.kinematics])
    rates = rates.subs(dict(reversed(list(own.helpers.items()))))
    matrices = [rates.jacobian(list(by)).tolist() for by in (own.states, own.inputs)]
    return ["; ".join(", ".join(str(Octave().doprint(v)) for v in row) for row in rows) for rows in matrices]
