"""Lines of equations: LaTeX for Markdown, and MathML of it for pages.

The additive terms of an equation are written one by one, so that new ones can be marked and a page can break the line
between them.  SymPy's printer writes them with the symbols of this field; a symbol whose name is in `marks` is
highlighted as new.
"""

from __future__ import annotations

import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.latex import LatexPrinter, accepted_latex_functions, translate
from sympy.printing.precedence import PRECEDENCE

SHOWN = {
    "rudder_offset": "delta_0",
    "rudder_effectiveness": "e",
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
    "iU": "U^-1",
    "delta_rate": "deltadot",
    "delta_hull": "delta_hull",
    "cos": "c_psi",
    "sin": "s_psi",
}
"""Symbol -> a letter (`prime` and `dot` behind it), an index behind `_`, an exponent behind `^`."""
RULES = {
    "([uv])([arc])": r"\1_\2",
    "([uvr])p": r"\1prime",
    "added_([A-Z])([a-z]+)": r"\1prime_\2",
    "added_([A-Z])([a-z]+)_abs([a-z])": r"\1prime_\2|\3|",
}
"""The same for symbols of one form: velocities against air, water and current, without dimension, added derivatives."""
TAG = re.compile(r"^(env|curr|wind|forc|added_[A-Za-z]+(?:_abs[a-z])?)_(?=(ur|vr|uc|vc|cos|sin|U|vp|rp|ua|va)$)")
DERIVATIVE = re.compile(r"([A-Z](?=[0-9a-z])|[a-z](?=[0-9]))([0-9a-z]+)")
"""Hydrodynamic derivatives and numbered symbols: `Yvvr`, `m11`."""


def parts(name: str) -> tuple[str, str, str]:
    """Letter, index and exponent of a symbol's name; an empty text where there is none."""
    name = TAG.sub("", name)
    form = next((form for form in RULES if re.fullmatch(form, name)), "")
    name, _, exponent = (re.sub(form, RULES[form], name) if form else SHOWN.get(name, name)).partition("^")
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


def _upright(text: str, command: str) -> str:
    """A name as LaTeX: Greek and accented letters by their commands, words upright, all others as they are."""
    shown = "\\nabla" if text == "nabla" else translate(text)
    word = re.fullmatch("(?![uvrd]+$)[A-Za-z ]{3,}", text)
    return f"\\{command}{{{text}}}" if word and shown == text else shown


# ---- Lines.

LONG_BRACKET = 3
"""Brackets of more terms than this are written term by term."""
Left = Sequence[tuple[Any, str | None]]
"""Left side: (factor, state whose rate it multiplies), or (expression, None)."""


ON_PAGES = {"\\boxed{": "\\class{new}{", "\\operatorname{": "\\text{", "\\mathrm{": "\\text{"}
"""LaTeX -> what browsers draw better as MathML."""


@dataclass(frozen=True)
class EquationLine:
    """One equation, or a sentence that stands among equations.

    pieces : LaTeX of its pieces, between which a page may break the line, each with whether it is a term that the
        extension added; none of a sentence.
    new : whether the extension added the line, or something in it.
    note : stands in brackets behind it; the sentence.
    """

    pieces: tuple[tuple[str, bool], ...]
    new: bool
    note: str = ""

    @property
    def latex(self) -> str:
        """The line as LaTeX; new terms stand over a brace."""
        plain = self.note.replace("_", "\\_")
        if not self.pieces:
            return f"\\text{{{plain}}}"
        shown = (f"\\underbrace{{{text}}}_{{\\text{{new}}}}" if new else text for text, new in self.pieces)
        return " ".join(shown) + (f"\\quad\\text{{({plain})}}" if plain else "")

    @property
    def html(self) -> str:
        """The line as HTML with MathML; new symbols and terms have the class `new`."""
        if not self.pieces:
            return escape(self.note)
        shown = (f"<span class='term{' new' if new else ''}'>{_mathml(text)}</span>" for text, new in self.pieces)
        return "\n".join(shown) + (f" <span class='sub'>({escape(self.note)})</span>" if self.note else "")


def _mathml(latex: str) -> str:
    from latex2mathml.converter import convert

    for text, other in ON_PAGES.items():
        latex = latex.replace(text, other)
    return convert(f"\\displaystyle {latex}")


def equation(left: Left, right: Any, marks: Mapping[str, bool], whole: bool = False) -> EquationLine:
    """An equation; `marks` holds the new names, True for those whose terms are new as a whole (`whole`: all of it)."""
    head = " + ".join(_left(factor, state) for factor, state in left)
    new = whole or any(name.name in marks for name in right.free_symbols)
    return EquationLine(((f"{head} =", False), *_terms(right, marks)), new)


def statement(words: str, new: bool = True) -> EquationLine:
    """A sentence that stands among equations."""
    return EquationLine((), new, words)


def value_of(name: str, value: str) -> EquationLine:
    """A symbol with its value, and its name in brackets behind it."""
    return EquationLine(((f"{Latex().doprint(sp.Symbol(name))} = \\text{{{value}}}", False),), True, name)


def _left(factor: Any, state: str | None) -> str:
    if state is None:
        return Latex().doprint(rounded(factor))
    rate = f"\\dot{{{Latex().doprint(sp.Symbol(state))}}}"
    return rate if factor == 1 else f"{Latex().parenthesize(factor, PRECEDENCE['Mul'], strict=True)} {rate}"


def _terms(expression: Any, marks: Mapping[str, bool]) -> list[tuple[str, bool]]:
    """Additive terms one by one, each with whether it is new as a whole; long brackets are opened."""
    out: list[tuple[str, bool]] = []
    for place, term in enumerate(_ordered(expression)):
        negative = term.could_extract_minus_sign()
        term = -term if negative else term
        sign = "- " if negative else "+ " if place else ""
        bracket = _long_bracket(term)
        if bracket is None:
            new = _is_new(term, marks)
            out.append((f"{sign}{Latex({} if new else marks).doprint(rounded(term))}", new))
        else:
            out.append((f"{sign}{Latex(marks).doprint(rounded(term / bracket))}", False))
            out += [("\\big[", False), *_terms(bracket, marks), ("\\big]", False)]
    return out


def _ordered(expression: Any) -> list[Any]:
    """Terms of a sum: those with a long bracket first, very long ones last."""
    if not expression.is_Add:
        return [expression]
    return sorted(expression.args, key=lambda term: (term.count_ops() > 60, _long_bracket(term) is None, str(term)))


def _long_bracket(term: Any) -> Any:
    factors = term.args if term.is_Mul else ()
    return next((f for f in factors if f.is_Add and len(f.args) > LONG_BRACKET), None)


def _is_new(term: Any, marks: Mapping[str, bool]) -> bool:
    """Whether the whole term is absent where the new parameters are zero."""
    factors = term.args if term.is_Mul else (term,)
    return any(f.is_Symbol and marks.get(f.name, False) for f in factors)
