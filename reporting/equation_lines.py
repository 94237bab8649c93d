"""Lines of equations in two forms: HTML with MathML for pages, LaTeX for Markdown.

The additive terms of an equation are written one by one, so that new ones can be marked and a page can break the line
between them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import sympy as sp
from sympy.printing.precedence import PRECEDENCE

from .printers import Latex, MathML, rounded

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


class LatexForm:
    """LaTeX; new terms stand over a brace.

    A form writes expressions (symbols in `marks` are highlighted), rates of states, a factor (in brackets where it is a
    sum) times such a rate, the left side of an equation from its pieces, signs, and terms with their signs.
    """

    between = " "

    def expression(self, expression: Any, marks: Mapping[str, bool]) -> str:
        return Latex(marks).doprint(rounded(expression))

    def rate(self, state: str) -> str:
        return f"\\dot{{{self.expression(sp.Symbol(state), {})}}}"

    def product(self, factor: Any, state: str) -> str:
        return f"{Latex().parenthesize(factor, PRECEDENCE['Mul'], strict=True)} {self.rate(state)}"

    def left(self, pieces: Sequence[str]) -> str:
        return " + ".join(pieces)

    def sign(self, sign: str) -> str:
        return {"−": "-", "[": "\\big[", "]": "\\big]"}.get(sign, sign)

    def term(self, sign: str, inside: str, new: bool) -> str:
        text = f"{sign} {inside}".strip()
        return f"\\underbrace{{{text}}}_{{\\text{{new}}}}" if new else text


class HtmlForm:
    """HTML with MathML; new terms have the class `new`."""

    between = "\n"

    def expression(self, expression: Any, marks: Mapping[str, bool]) -> str:
        return MathML(marks).doprint(rounded(expression))

    def rate(self, state: str) -> str:
        return f"<mover>{self.expression(sp.Symbol(state), {})}<mo>˙</mo></mover>"

    def product(self, factor: Any, state: str) -> str:
        element: Any = MathML().parenthesize(factor, PRECEDENCE["Mul"], strict=True)
        return f"{element.toxml()}{self.rate(state)}"

    def left(self, pieces: Sequence[str]) -> str:
        return f"<math>{'<mo>+</mo>'.join(pieces)}</math>"

    def sign(self, sign: str) -> str:
        return f"<span class='op'>{sign}</span>"

    def term(self, sign: str, inside: str, new: bool) -> str:
        return f"<span class='term{' new' if new else ''}'>{sign}<math displaystyle='true'>{inside}</math></span>"


HTML, LATEX = HtmlForm(), LatexForm()
EquationForm = LatexForm | HtmlForm
"""How the pieces of a line are written."""


def equation(left: Left, right: Any, marks: Mapping[str, bool], whole: bool = False) -> EquationLine:
    """An equation; `marks` holds the new names, True for those whose terms are new as a whole (`whole`: all of it)."""
    new = whole or any(name.name in marks for name in right.free_symbols)
    return EquationLine(_written(left, right, marks, HTML), _written(left, right, marks, LATEX), new)


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
    html = f"<math>{HTML.expression(symbol, {})}</math> = {escape(value)} <span class='sub'>({escape(name)})</span>"
    plain = name.replace("_", "\\_")
    return EquationLine(html, f"{LATEX.expression(symbol, {})} = \\text{{{value}}}\\quad\\text{{({plain})}}", True)


def _written(left: Left, right: Any, marks: Mapping[str, bool], form: EquationForm) -> str:
    head = form.left([_left(factor, state, form) for factor, state in left])
    return form.between.join([head, form.sign("="), *_terms(right, marks, form)])


def _left(factor: Any, state: str | None, form: EquationForm) -> str:
    if state is None:
        return form.expression(factor, {})
    if factor == 1:
        return form.rate(state)
    return form.product(factor, state)


def _terms(expression: Any, marks: Mapping[str, bool], form: EquationForm) -> list[str]:
    """Additive terms one by one; long brackets are opened."""
    out: list[str] = []
    for place, term in enumerate(_ordered(expression)):
        negative = term.could_extract_minus_sign()
        term = -term if negative else term
        sign = form.sign("−") if negative else form.sign("+") if place else ""
        bracket = _long_bracket(term)
        if bracket is None:
            new = _is_new(term, marks)
            out.append(form.term(sign, form.expression(term, {} if new else marks), new))
        else:
            out.append(form.term(sign, form.expression(term / bracket, marks), False))
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
