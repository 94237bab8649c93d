"""Lines of equations in two forms: HTML with MathML for pages, LaTeX for Markdown.

The additive terms of an equation are written one by one, so that new ones can be marked and a page can break the line
between them.  SymPy's printers write them with the symbols of this field; a symbol whose name is in `marks` is
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
from sympy.printing.mathml import MathMLPresentationPrinter
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.pretty.pretty_symbology import greek_unicode

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
LETTERS = {**greek_unicode, "nabla": "∇"}


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
    """LaTeX; new symbols are boxed, new terms stand over a brace.

    As `MathML` it writes the pieces of a line as well: the rate of a state, a factor (in brackets where it is a sum)
    times such a rate, the left side from its pieces, signs, and terms with their signs.
    """

    between = " "

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

    @classmethod
    def rate(cls, state: str) -> str:
        return f"\\dot{{{cls().doprint(sp.Symbol(state))}}}"

    @classmethod
    def product(cls, factor: Any, state: str) -> str:
        return f"{cls().parenthesize(factor, PRECEDENCE['Mul'], strict=True)} {cls.rate(state)}"

    @staticmethod
    def left(pieces: Sequence[str]) -> str:
        return " + ".join(pieces)

    @staticmethod
    def sign(sign: str) -> str:
        return {"−": "-", "[": "\\big[", "]": "\\big]"}.get(sign, sign)

    @staticmethod
    def term(sign: str, inside: str, new: bool) -> str:
        text = f"{sign} {inside}".strip()
        return f"\\underbrace{{{text}}}_{{\\text{{new}}}}" if new else text


class MathML(MathMLPresentationPrinter):
    """Presentation MathML within HTML; new symbols and terms have the class `new`."""

    between = "\n"

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

    @classmethod
    def rate(cls, state: str) -> str:
        return f"<mover>{cls().doprint(sp.Symbol(state))}<mo>˙</mo></mover>"

    @classmethod
    def product(cls, factor: Any, state: str) -> str:
        element: Any = cls().parenthesize(factor, PRECEDENCE["Mul"], strict=True)
        return f"{element.toxml()}{cls.rate(state)}"

    @staticmethod
    def left(pieces: Sequence[str]) -> str:
        return f"<math>{'<mo>+</mo>'.join(pieces)}</math>"

    @staticmethod
    def sign(sign: str) -> str:
        return f"<span class='op'>{sign}</span>"

    @staticmethod
    def term(sign: str, inside: str, new: bool) -> str:
        return f"<span class='term{' new' if new else ''}'>{sign}<math displaystyle='true'>{inside}</math></span>"


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


@dataclass(frozen=True)
class EquationLine:
    """One equation: HTML with MathML, LaTeX, and whether the extension added it or something in it."""

    html: str
    latex: str
    new: bool


Form = type[Latex] | type[MathML]
"""How the pieces of a line are written."""


def equation(left: Left, right: Any, marks: Mapping[str, bool], whole: bool = False) -> EquationLine:
    """An equation; `marks` holds the new names, True for those whose terms are new as a whole (`whole`: all of it)."""
    new = whole or any(name.name in marks for name in right.free_symbols)
    return EquationLine(_written(left, right, marks, MathML), _written(left, right, marks, Latex), new)


def statement(words: str) -> EquationLine:
    """A sentence that stands among equations."""
    return EquationLine(escape(words), f"\\text{{{words.replace('_', chr(92) + '_')}}}", True)


def with_note(line: EquationLine, note: str) -> EquationLine:
    """The line with a note in brackets behind it, if there is one."""
    if not note:
        return line
    html = f"{line.html} <span class='sub'>({escape(note)})</span>"
    return EquationLine(html, f"{line.latex}\\quad\\text{{({note})}}", line.new)


def value_of(name: str, value: str) -> EquationLine:
    """A symbol with its value, and its name in brackets behind it."""
    symbol = sp.Symbol(name)
    html = f"<math>{MathML().doprint(symbol)}</math> = {escape(value)} <span class='sub'>({escape(name)})</span>"
    plain = name.replace("_", "\\_")
    return EquationLine(html, f"{Latex().doprint(symbol)} = \\text{{{value}}}\\quad\\text{{({plain})}}", True)


def _written(left: Left, right: Any, marks: Mapping[str, bool], form: Form) -> str:
    head = form.left([_left(factor, state, form) for factor, state in left])
    return form.between.join([head, form.sign("="), *_terms(right, marks, form)])


def _left(factor: Any, state: str | None, form: Form) -> str:
    if state is None:
        return form().doprint(rounded(factor))
    if factor == 1:
        return form.rate(state)
    return form.product(factor, state)


def _terms(expression: Any, marks: Mapping[str, bool], form: Form) -> list[str]:
    """Additive terms one by one; long brackets are opened."""
    out: list[str] = []
    for place, term in enumerate(_ordered(expression)):
        negative = term.could_extract_minus_sign()
        term = -term if negative else term
        sign = form.sign("−") if negative else form.sign("+") if place else ""
        bracket = _long_bracket(term)
        if bracket is None:
            new = _is_new(term, marks)
            out.append(form.term(sign, form({} if new else marks).doprint(rounded(term)), new))
        else:
            out.append(form.term(sign, form(marks).doprint(rounded(term / bracket)), False))
            out += [form.sign("["), *_terms(bracket, marks, form), form.sign("]")]
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
