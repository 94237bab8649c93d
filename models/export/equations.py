"""The derivative of a model as a list of assignments, in the language of a printer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter
from sympy.printing.octave import OctaveCodePrinter
from sympy.printing.pycode import PythonCodePrinter

from ..definition import Definition
from ..errors import BadInput
from ..kernels import definition_of
from ..model import Model
from ..simulate import initial_state
from .texts import inert, name_of


class OwnFunctions(CodePrinter):
    """The models' own functions in a language: `forms` has what each becomes."""

    forms: ClassVar[Mapping[str, str]] = {}

    def _print_own(self, expr: sp.Expr) -> str:
        return self.forms[type(expr).__name__].format(*map(self._print, expr.args))

    _print_absv = _print_sgn = _print_step = _print_atan2v = _print_own


class Octave(OwnFunctions, OctaveCodePrinter):
    """Expressions of MATLAB and Octave."""

    forms: ClassVar = {"absv": "abs({})", "sgn": "sign({})", "step": "double({} > 0)", "atan2v": "atan2({}, {})"}


class Python(OwnFunctions, PythonCodePrinter):
    """Expressions of Python's `math`."""

    forms: ClassVar = {
        "absv": "abs({})",
        "sgn": "(({0}) > 0) - (({0}) < 0)",
        "step": "float({} > 0)",
        "atan2v": "math.atan2({}, {})",
    }


class C(OwnFunctions, C99CodePrinter):
    """Expressions of C with `math.h`."""

    forms: ClassVar = {
        "absv": "fabs({})",
        "sgn": "((({0}) > 0) - (({0}) < 0))",
        "step": "(({}) > 0 ? 1.0 : 0.0)",
        "atan2v": "atan2({}, {})",
    }


def definition(model: Model) -> Definition:
    """The equations of a model as it is integrated; BadInput where it has no numbers."""
    if not model.known:
        raise BadInput(f"{model.id} has no coefficients", hint="give a vessel or a model.json that `identify` wrote")
    return definition_of(model.family).simulated()


def statements(own: Definition, printer: CodePrinter) -> list[tuple[str, str]]:
    """(name, expression) of the helpers, then of every state's derivative, `d_NAME`, in the order of evaluation.

    Names are those of states, inputs, coefficients and constants.  M(p) a = F is solved by Cramer's rule: k <= 3.
    """
    count = len(own.forces)
    forces = sp.symbols([f"F_{place}" for place in range(1, count + 1)], real=True)
    matrix = sp.Matrix(count, count, lambda i, j: sp.Symbol(f"M_{i + 1}{j + 1}", real=True) if own.mass[i, j] else 0)
    named = [(symbol.name, value) for symbol, value in own.helpers.items()]
    named += [(str(symbol), value) for symbol, value in zip(forces, own.forces, strict=True)]
    named += [(str(matrix[i]), own.mass[i]) for i in range(count**2) if matrix[i] != 0]
    solved = [sp.simplify(value) for value in matrix.adjugate() * sp.Matrix(forces) / matrix.det()]
    names = [f"d_{symbol.name}" for symbol in own.states]
    named += list(zip(names, [*solved, *own.kinematics], strict=True))
    return [(name, str(printer.doprint(sp.sympify(value)))) for name, value in named]


def numbers(model: Model) -> dict[str, float]:
    """Value of every coefficient and constant by name."""
    values = [*model.coefficients.tolist(), *model.constants.tolist()]
    return dict(zip((*model.coordinates, *model.constant_names), values, strict=True))


def mass_matrix(model: Model) -> NDArray[np.float64]:
    """Mass, static moment and moment of inertia (3, 3) of a 3-DOF model with their added parts: kg, kg m, kg m2."""
    own = definition(model)
    scale = own.force_scale
    if scale is None or not all(scale):
        raise BadInput(f"{model.id}: a model of heading alone or at a fixed speed", hint="export a 3-DOF model")
    values = {sp.Symbol("rho", real=True): model.environment_numbers()["rho"]}
    values |= {symbol: numbers(model)[symbol.name] for symbol in own.parameters}
    scaled = sp.Matrix(3, 3, lambda i, j: own.mass[i, j] / scale[i]).xreplace(values)
    return np.array(scaled.evalf(), dtype=float)


def identifier(model: Model) -> str:
    """The model's id as a name of MATLAB and Python, and of files."""
    return name_of(model.id, (*model.coordinates, *model.constant_names))


def heading(model: Model) -> list[str]:
    """Lines that say what a file holds, and what of the model it does not hold; texts of the model are `inert`."""
    lines = [f"{inert(model.title or model.id)}: family {inert(model.family)}"]
    lines += ["SI units and radians; x forward, y to starboard, z down"]
    lines += [f"a positive rudder angle turns the ship to {inert(model.positive_rudder)}"]
    lines += [f"source: {inert(model.source)}"] if model.source else []
    left: Mapping[str, Any] = {
        "instruments (rudder linkage and sensors)": model.instruments,
        "wind force": model.windage,
        "heading controller": model.controller,
    }
    absent = [name for name, value in left.items() if value]
    lines += [f"not exported: {', '.join(absent)}"] if absent else []
    return lines


def gear(model: Model) -> dict[str, float]:
    """Limits of the steering gear, inf where there is none."""
    return {
        "max_rad": float(model.rudder.max_rad),
        "rate_rad_s": float(model.rudder.rate_rad_s),
        "lag_s": float(model.rudder.lag_s),
    }


def values_of(model: Model, printer: CodePrinter) -> dict[str, Any]:
    """What every template may name: the model, its equations in a language, and its numbers by name."""
    own = definition(model)
    return {
        "model": model,
        "own": own,
        "name": identifier(model),
        "heading": heading(model),
        "statements": statements(own, printer),
        "numbers": numbers(model),
        "gear": gear(model),
        "start": dict(zip(model.states, initial_state(model).tolist(), strict=True)),
    }
