"""Symbolic expressions as LaTeX and MathML: SymPy's printers with the symbols of this field.

A symbol whose name is in `marks` is highlighted as new.
"""

from __future__ import annotations

import re
from collections.abc import Container
from html import escape
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.latex import LatexPrinter, accepted_latex_functions, translate
from sympy.printing.mathml import MathMLPresentationPrinter
from sympy.printing.pretty.pretty_symbology import greek_unicode

SHOWN = {
    "rudder_offset": "delta_0",
    "rudder_effectiveness": "e",
    "added_Nr_absr": "Nprime_r|r|",
    "added_Nrrr": "Nprime_rrr",
    "added_Yv_absv": "Yprime_v|v|",
    "added_Yr_absv": "Yprime_r|v|",
    "added_Yv_absr": "Yprime_v|r|",
    "added_Nv_absr": "Nprime_v|r|",
    "added_Nr_absv": "Nprime_r|v|",
    "current_towards_north": "V_c,north",
    "current_towards_east": "V_c,east",
    "wind_towards_north": "V_w,north",
    "wind_towards_east": "V_w,east",
    "wave_drift_north": "D_north",
    "wave_drift_east": "D_east",
    "drift_along": "D_u",
    "drift_across": "D_v",
    "drift_size": "D",
    "constant_X": "X_c",
    "constant_Y": "Y_c",
    "constant_N": "N_c",
    "constant_yaw": "N_c",
    "lead": "lambda",
    "lead_T2": "T_2",
    "lead_state": "z",
    "loss_gain": "k_U",
    "loss_time": "T_U",
    "loss_power": "m_U",
    "speed_loss_state": "l_U",
    "speed_ratio": "eta_U",
    "loading_fraction": "f_m",
    "rigid_mass": "m_0",
    "rigid_moment": "S_x",
    "rigid_inertia": "I_z",
    "U0": "U_0",
    "up": "uprime",
    "vp": "vprime",
    "rp": "rprime",
    "iU": "U^-1",
    "delta_rate": "deltadot",
    "delta_hull": "delta_hull",
    "ua": "u_a",
    "va": "v_a",
    "ur": "u_r",
    "vr": "v_r",
    "uc": "u_c",
    "vc": "v_c",
    "cos": "c_psi",
    "sin": "s_psi",
}
"""Symbol -> a letter (`prime` and `dot` behind it), an index behind `_`, an exponent behind `^`."""
TAG = re.compile(r"^(env|curr|wind|forc|added_[A-Za-z]+(?:_abs[a-z])?)_(?=(ur|vr|uc|vc|cos|sin|U|vp|rp|ua|va)$)")
DERIVATIVE = re.compile(r"([A-Z](?=[0-9a-z])|[a-z](?=[0-9]))([0-9a-z]+)")
"""Hydrodynamic derivatives and numbered symbols: `Yvvr`, `m11`."""
LETTERS = {**greek_unicode, "nabla": "∇"}


def parts(name: str) -> tuple[str, str, str]:
    """Letter, index and exponent of a symbol's name; an empty text where there is none."""
    name = TAG.sub("", name)
    name, _, exponent = SHOWN.get(name, name).partition("^")
    letter, _, index = name.partition("_")
    derivative = DERIVATIVE.fullmatch(name)
    if derivative and not re.search("(prime|dot)$", name):
        letter, index = derivative.groups()
    return letter, index.replace("_", " "), exponent


def rounded(expression: Any) -> Any:
    """The expression with six digits of every number."""
    return expression.xreplace({value: sp.Float(value, 6) for value in expression.atoms(sp.Float)})


class Latex(LatexPrinter):
    """LaTeX; new symbols are boxed."""

    def __init__(self, marks: Container[str] = ()) -> None:
        super().__init__({"full_prec": False})
        self.marks = marks

    def _split_super_sub(self, name: str) -> tuple[str, list[str], list[str]]:
        letter, index, exponent = parts(name)
        return _upright(letter, "text"), [exponent] if exponent else [], [_upright(index, "mathrm")] if index else []

    def _print_Symbol(self, expr: Any, style: str = "plain") -> str:
        text = super()._print_Symbol(expr, style)
        return f"\\boxed{{{text}}}" if expr.name in self.marks else text

    def _print_Function(self, expr: Any, exp: Any = None) -> str:
        if not isinstance(expr, AppliedUndef):
            return super()._print_Function(expr, exp)
        arguments = ", ".join(self._print(argument) for argument in expr.args)
        return f"{self._deal_with_super_sub(expr.func.__name__)}\\left({arguments}\\right)"

    def _hprint_Function(self, func: str) -> str:
        return f"\\{func}" if func in accepted_latex_functions else f"\\operatorname{{{func}}}"

    def _print_atan2v(self, expr: Any, exp: Any = None) -> str:
        return self._print_Function(sp.atan2(*expr.args, evaluate=False), exp)

    _print_absv = LatexPrinter._print_Abs


class MathML(MathMLPresentationPrinter):
    """Presentation MathML; new symbols have the class `new`."""

    def __init__(self, marks: Container[str] = ()) -> None:
        super().__init__({"mul_symbol": "\N{INVISIBLE TIMES}"})
        self.marks = marks

    def _split_super_sub(self, name: str) -> tuple[str, list[str], list[str]]:
        letter, index, exponent = parts(name)
        plain, prime, dot = (*letter.partition("prime")[:2], "")
        if letter.endswith("dot"):
            plain, dot = letter.removesuffix("dot"), "\N{COMBINING DOT ABOVE}"
        base = escape(LETTERS.get(plain, plain) + dot)
        raised = ["′"] if prime else [escape(exponent.replace("-", "−"))] if exponent else []
        return base, raised, [escape(index)] if index else []

    def _print_Symbol(self, sym: Any, style: str = "plain") -> Any:
        element = super()._print_Symbol(sym, style)
        if sym.name in self.marks:
            element.setAttribute("class", "new")
        return element

    def _print_Function(self, e: Any) -> Any:
        if not isinstance(e, AppliedUndef):
            return super()._print_Function(e)
        row = self.dom.createElement("mrow")
        row.appendChild(self._print_Symbol(sp.Symbol(e.func.__name__)))
        row.appendChild(self._paren_comma_separated(*e.args))
        return row

    def _print_atan2v(self, expr: Any) -> Any:
        return self._print_Function(sp.atan2(*expr.args, evaluate=False))

    _print_absv = MathMLPresentationPrinter._print_Abs


def _upright(text: str, command: str) -> str:
    """A name as LaTeX: Greek and accented letters by their commands, words upright, all others as they are."""
    shown = "\\nabla" if text == "nabla" else translate(text)
    word = re.fullmatch("(?![uvrd]+$)[A-Za-z ]{3,}", text)
    return f"\\{command}{{{text}}}" if word and shown == text else shown
