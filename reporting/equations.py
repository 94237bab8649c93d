"""A model's equations as text for people: MathML for pages, LaTeX for Markdown, from the symbolic definition.

What an extension added is marked: whole terms that its parameters multiply, else its symbols where they stand.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..models.definition import Definition
    from ..models.model import Model

GREEK = {
    **{"psi": "ψ", "delta": "δ", "alpha": "α", "beta": "β", "gamma": "γ", "rho": "ρ", "epsilon": "ε", "kappa": "κ"},
    **{"nabla": "∇", "tau": "τ", "omega": "ω", "phi": "φ", "eta": "η", "lambda": "λ", "zeta": "ζ", "theta": "θ"},
}
LATEX_GREEK = {letter: f"\\{name}" for name, letter in GREEK.items()}
SHOWN = {
    "rudder_offset": "δ_0",
    "rudder_effectiveness": "e",
    "added_Nr_absr": "N′_r|r|",
    "added_Nrrr": "N′_rrr",
    "added_Yv_absv": "Y′_v|v|",
    "added_Yr_absv": "Y′_r|v|",
    "added_Yv_absr": "Y′_v|r|",
    "added_Nv_absr": "N′_v|r|",
    "added_Nr_absv": "N′_r|v|",
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
    "lead": "λ",
    "lead_T2": "T_2",
    "lead_state": "z",
    "loss_gain": "k_U",
    "loss_time": "T_U",
    "loss_power": "m_U",
    "speed_loss_state": "l_U",
    "speed_ratio": "η_U",
    "loading_fraction": "f_m",
    "rigid_mass": "m_0",
    "rigid_moment": "m_0x_G",
    "rigid_inertia": "I_z",
    **{"U0": "U_0", "up": "u′", "vp": "v′", "rp": "r′", "iU": "U^−1", "delta_rate": "δ̇", "delta_hull": "δ_hull"},
    **{"ur": "u_r", "vr": "v_r", "uc": "u_c", "vc": "v_c", "cos": "c_ψ", "sin": "s_ψ"},
}
"""Symbol -> how it is written: a letter, then an index behind `_`."""
TAG = re.compile(r"^(env|curr|wind|forc|added_[A-Za-z]+(?:_abs[a-z])?)_(?=(ur|vr|uc|vc|cos|sin|U|vp|rp|ua|va)$)")
RUDDER_SIDE = ("rudder_offset", "rudder_effectiveness")
"""Extensions that are told as a relation between the recorded and the felt rudder angle."""


@dataclass(frozen=True)
class Line:
    """One equation: HTML with MathML, LaTeX, and whether the extension brought it or something in it."""

    html: str
    latex: str
    new: bool


@dataclass(frozen=True)
class Equations:
    """What a model says, in reading order; `added` are its new numbers (symbol in HTML and LaTeX, value, unit)."""

    relations: tuple[Line, ...]
    dynamics: tuple[Line, ...]
    helpers: tuple[Line, ...]
    added: tuple[tuple[str, str, str, float, str], ...]


def equations(model: Model, base: Model) -> Equations:
    """The equations of an extended model; what `base` does not have is marked as new.

    Terms whose coefficient is zero are left out.
    """
    import sympy as sp

    from ..models.kernels import definition_of

    own = [part for part in model.family.split("+")[1:] if part not in base.family.split("+")[1:]]
    told = [part for part in own if part in RUDDER_SIDE]
    family = "+".join([model.family.split("+")[0], *(p for p in model.family.split("+")[1:] if p not in told)])
    definition = definition_of(family)
    fresh = {name for name in model.coordinates if name not in base.coordinates}
    hull = bool(told or _rudder_numbers(model, base))
    if hull:
        definition = _renamed(definition, {definition.inputs[0]: sp.Symbol("delta_hull", real=True)})
    marks = _marks(definition, fresh, {symbol.name for symbol in definition_of(base.family).helpers})
    values = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    zero = {s: sp.S.Zero for s in definition.coefficients if values.get(s.name) == 0.0 and s.name not in fresh}
    dynamics = tuple(_dynamics(definition, zero, marks))
    helpers = tuple(_helpers(definition, zero, marks))
    units = dict(zip(model.coordinates, model.parameter_units, strict=False))
    added = [(_html(sp.Symbol(n), {}), _latex(sp.Symbol(n), {}), n, values[n], units.get(n, "")) for n in fresh]
    added.sort(key=lambda row: model.coordinates.index(row[2]))
    return Equations(tuple(_relations(model, base, told)), dynamics, helpers, tuple(added))


# ---- the parts


def _dynamics(definition: Definition, zero: Mapping, marks: Mapping[str, bool]) -> Iterable[Line]:
    import sympy as sp

    size = len(definition.forces)
    for row, force in enumerate(definition.forces):
        left = [
            (definition.mass[row, j], definition.states[j].name) for j in range(size) if definition.mass[row, j] != 0
        ]
        shown = force.xreplace(dict(zero))
        yield _equation(left, shown if definition.force_scale is not None else sp.expand(shown), marks)
    for state, rate in zip(definition.states[size:], definition.kinematics, strict=True):
        yield _equation([(1, state.name)], rate.xreplace(dict(zero)), marks, whole=state.name in marks)


def _helpers(definition: Definition, zero: Mapping, marks: Mapping[str, bool]) -> Iterable[Line]:
    seen = set()
    for symbol, expression in definition.helpers.items():
        clean = _without_floor(expression.xreplace(dict(zero)))
        line = _equation([(symbol, None)], clean, marks, whole=symbol.name in marks)
        if line.html not in seen and clean != 0:
            seen.add(line.html)
            yield line


def _relations(model: Model, base: Model, told: Sequence[str]) -> Iterable[Line]:
    """Recorded against felt rudder, and recorded against true channels, where the extension says so."""
    import sympy as sp

    from ..models.instruments import SENSORS, SWAPS

    new = {k: v for k, v in model.instruments.items() if base.instruments.get(k) != v}
    values = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    rudder = _rudder_numbers(model, base) | {name: values[name] for name in told}
    time = sp.Symbol("t")
    if rudder:
        late = sp.Symbol("tau_delta") if "rudder_delay" in rudder else 0
        gain = 1 + (sp.Symbol("e") if "rudder_effectiveness" in rudder else 0)
        gain += sp.Symbol("e_fault") if "rudder_fault" in rudder else 0
        sign = -1 if "rudder_reversed" in rudder else 1
        felt = sign * gain * sp.Function("delta")(time - late)
        felt += sp.Symbol("rudder_offset") if "rudder_offset" in rudder else 0
        yield _with_note(_equation([(sp.Symbol("delta_hull"), None)], felt, {}, True), _limits(rudder))
    for short in SENSORS:
        own = {kind: new[f"{short}_{kind}"] for kind in ("scale", "bias", "delay") if f"{short}_{kind}" in new}
        if own:
            true = sp.Function(f"{short.replace('_', ' ')}_true")(
                time - (sp.Symbol(f"tau_{short}") if "delay" in own else 0)
            )
            shown = true * (1 + (sp.Symbol("s") if "scale" in own else 0)) + (sp.Symbol("b") if "bias" in own else 0)
            yield _equation([(sp.Symbol(f"{short.replace('_', ' ')}_recorded"), None)], shown, {}, True)
    yield from (_text(f"columns {a} and {b} are exchanged") for name, (a, b) in SWAPS.items() if name in new)
    if "axis_misalignment" in new:
        u, v, angle = sp.symbols("u v alpha")
        yield _equation([(sp.Symbol("surge_recorded"), None)], u * sp.cos(angle) + v * sp.sin(angle), {}, True)
        yield _equation([(sp.Symbol("sway_recorded"), None)], v * sp.cos(angle) - u * sp.sin(angle), {}, True)
    if "earth_frame_velocity" in new:
        u, v, psi = sp.symbols("u v psi")
        yield _equation([(sp.Symbol("surge_recorded"), None)], u * sp.cos(psi) - v * sp.sin(psi), {}, True)
        yield _equation([(sp.Symbol("sway_recorded"), None)], u * sp.sin(psi) + v * sp.cos(psi), {}, True)
    if "wave_rms" in new:
        yield _text("heading and yaw rate carry narrow-band wave motion")


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
    import sympy as sp

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
    import sympy as sp

    return expression.replace(lambda e: e.is_Float and abs(e) < 1e-9, lambda e: sp.S.Zero)


# ---- lines


def _equation(
    left: Sequence[tuple[Any, str | None]], right: Any, marks: Mapping[str, bool], whole: bool = False
) -> Line:
    parts = [_rendered(left, right, marks, style) for style in (_html, _latex)]
    new = whole or bool(_names(right) & marks.keys())
    return Line(parts[0], parts[1], new)


def _text(words: str) -> Line:
    return Line(escape(words), f"\\text{{{words.replace('_', chr(92) + '_')}}}", True)


def _with_note(line: Line, note: str) -> Line:
    if not note:
        return line
    return Line(
        f"{line.html} <span class='sub'>({escape(note)})</span>", f"{line.latex}\\quad\\text{{({note})}}", line.new
    )


def _rendered(left: Sequence[tuple[Any, str | None]], right: Any, marks: Mapping[str, bool], style: Callable) -> str:
    head = [_rate(factor, state, style) for factor, state in left]
    pieces = [" + ".join(head) if style is _latex else _math("<mo>+</mo>".join(head)), _operator("=", style)]
    return (" " if style is _latex else "\n").join([*pieces, *_terms(right, marks, style)])


def _rate(factor: Any, state: str | None, style: Callable) -> str:
    if state is None:
        return style(factor, {})
    letter = SHOWN.get(state, GREEK.get(state, state))
    dotted = f"\\dot{{{_symbol_latex(state)}}}" if style is _latex else f"<mover><mi>{letter}</mi><mo>˙</mo></mover>"
    if factor == 1:
        return dotted
    inner = style(factor, {})
    if getattr(factor, "is_Add", False):
        inner = f"\\left({inner}\\right)" if style is _latex else f"<mo>(</mo>{inner}<mo>)</mo>"
    return f"{inner}\\,{dotted}" if style is _latex else f"{inner}{dotted}"


def _terms(expression: Any, marks: Mapping[str, bool], style: Callable) -> list[str]:
    """Additive terms one by one, so that a page can break the line between them; long brackets are opened."""
    out: list[str] = []
    for number, term in enumerate(_ordered(expression)):
        negative = term.could_extract_minus_sign()
        term = -term if negative else term
        sign = _operator("−", style) if negative else _operator("+", style) if number else ""
        long = next((f for f in term.args if f.is_Add and len(f.args) > 3), None) if term.is_Mul else None
        if long is None:
            whole = _multiplies(term, marks)
            inside = style(term, {} if whole else marks)
            out.append(_marked(_joined(sign, inside, style), whole, style))
        else:
            out.append(_joined(sign, style(term / long, marks), style))
            out += [_operator("[", style), *_terms(long, marks, style), _operator("]", style)]
    return out


def _ordered(expression: Any) -> list[Any]:
    if not expression.is_Add:
        return [expression]
    return sorted(expression.args, key=lambda term: (term.count_ops() > 60, _degree(term), str(term)))


def _degree(term: Any) -> int:
    return len([f for f in term.args if f.is_Add and len(f.args) > 3]) * -1 if term.is_Mul else 0


def _multiplies(term: Any, marks: Mapping[str, bool]) -> bool:
    """Whether the whole term is absent where the new parameters are zero."""
    factors = term.args if term.is_Mul else (term,)
    return any(f.is_Symbol and marks.get(f.name, False) for f in factors)


def _joined(sign: str, inside: str, style: Callable) -> str:
    return f"{sign} {inside}".strip() if style is _latex else f"{sign}{_math(inside)}"


def _operator(sign: str, style: Callable) -> str:
    if style is _latex:
        return {"−": "-", "[": "\\big[", "]": "\\big]"}.get(sign, sign)
    return f"<span class='op'>{sign}</span>"


def _marked(text: str, new: bool, style: Callable) -> str:
    if not new:
        return text if style is _latex else f"<span class='term'>{text}</span>"
    return f"\\underbrace{{{text}}}_{{\\text{{new}}}}" if style is _latex else f"<span class='term new'>{text}</span>"


def _math(inside: str) -> str:
    return f"<math>{inside}</math>"


# ---- expressions


def _html(expression: Any, marks: Mapping[str, bool]) -> str:
    return _write(expression, marks, MATHML)


def _latex(expression: Any, marks: Mapping[str, bool]) -> str:
    return _write(expression, marks, LATEX)


@dataclass(frozen=True)
class Style:
    """How the pieces of an expression are written."""

    symbol: Callable[[str, bool], str]
    number: Callable[[str], str]
    row: Callable[[Sequence[str]], str]
    sign: Callable[[str], str]
    bracket: Callable[[str], str]
    absolute: Callable[[str], str]
    fraction: Callable[[str, str], str]
    root: Callable[[str], str]
    power: Callable[[str, str], str]
    call: Callable[[str, str], str]


def _write(e: Any, marks: Mapping[str, bool], style: Style) -> str:
    import sympy as sp

    e = sp.sympify(e)
    if e.is_Symbol:
        return style.symbol(e.name, e.name in marks)
    if e.is_Number:
        return style.number(f"{float(e):.6g}" if not e.is_Integer else str(int(e)))
    if e.is_Add:
        return _write_sum(e, marks, style)
    if e.is_Mul:
        return _write_product(e, marks, style)
    if e.is_Pow:
        return _write_power(e, marks, style)
    arguments = style.sign(",").join(_write(a, marks, style) for a in e.args)
    name = type(e).__name__
    if name in ("absv", "Abs"):
        return style.absolute(arguments)
    return style.call({"atan2v": "atan2", "sgn": "sgn"}.get(name, name), arguments)


def _write_sum(e: Any, marks: Mapping[str, bool], style: Style) -> str:
    out: list[str] = []
    for term in e.as_ordered_terms():
        negative = term.could_extract_minus_sign()
        out += [style.sign("−")] if negative else [style.sign("+")] if out else []
        out.append(_write(-term if negative else term, marks, style))
    return style.row(out)


def _write_product(e: Any, marks: Mapping[str, bool], style: Style) -> str:
    import sympy as sp

    top, bottom = sp.fraction(e)
    if bottom != 1:
        return style.fraction(_write(top, marks, style), _write(bottom, marks, style))
    if e.could_extract_minus_sign():
        return style.row([style.sign("−"), _write(-e, marks, style)])
    factors = sorted(e.as_ordered_factors(), key=lambda f: (not f.is_Number, f.is_Add))
    written = [style.bracket(_write(f, marks, style)) if f.is_Add else _write(f, marks, style) for f in factors]
    return style.row(written)


def _write_power(e: Any, marks: Mapping[str, bool], style: Style) -> str:
    import sympy as sp

    base, exponent = e.args
    if exponent == sp.S.Half:
        return style.root(_write(base, marks, style))
    if exponent.could_extract_minus_sign():
        return style.fraction("1" if style is LATEX else "<mn>1</mn>", _write(base**-exponent, marks, style))
    inner = _write(base, marks, style)
    return style.power(inner if base.is_Atom else style.bracket(inner), _write(exponent, marks, style))


def written(name: str) -> tuple[str, str]:
    """Letter and index of a symbol's name."""
    name = TAG.sub("", name)
    text = SHOWN.get(name) or GREEK.get(name) or name
    if "_" in text:
        letter, _, index = text.partition("_")
        return GREEK.get(letter, letter), GREEK.get(index, index.replace("_", " "))
    if text == name and len(name) > 1 and name[0].isalpha():
        indexed = re.fullmatch(r"([A-Z](?=[0-9a-z])|[a-z](?=[0-9]))([0-9a-z]+)", name)
        return (indexed[1], indexed[2]) if indexed else (name, "")
    return text, ""


def _symbol_html(name: str, new: bool) -> str:
    letter, index = written(name)
    letter, _, power = letter.partition("^")
    inside = f"<mi>{escape(letter)}</mi>"
    if index:
        inside = f"<msub>{inside}<mtext>{escape(index)}</mtext></msub>"
    if power:
        inside = f"<msup>{inside}<mtext>{escape(power)}</mtext></msup>"
    return f"<mrow class='new'>{inside}</mrow>" if new else inside


def _symbol_latex(name: str, new: bool = False) -> str:
    letter, index = written(name)
    letter, _, power = letter.partition("^")
    plain = letter.rstrip("′̇")
    text = "".join(LATEX_GREEK.get(c, c) for c in plain)
    text = f"\\text{{{text}}}" if len(plain) > 1 and plain.replace(" ", "").isalpha() else text
    text = f"\\dot{{{text}}}" if "̇" in letter else text
    text += "'" if letter.endswith("′") else ""
    if index:
        index = LATEX_GREEK.get(index, index)
        text += (
            f"_{{{index}}}"
            if index.startswith("\\") or len(index) == 1 or "|" in index
            else f"_{{\\mathrm{{{index}}}}}"
        )
    text += f"^{{{power.replace('−', '-')}}}" if power else ""
    return f"\\boxed{{{text}}}" if new else text


def _call_html(name: str, arguments: str) -> str:
    known = _symbol_html(name, False) if "_" in name else f"<mi>{GREEK.get(name, name)}</mi>"
    return f"{known}<mo>(</mo>{arguments}<mo>)</mo>"


def _call_latex(name: str, arguments: str) -> str:
    known = f"\\{name}" if name in ("sin", "cos", "exp", "tan", "log") else _symbol_latex(name)
    return f"{known}\\left({arguments}\\right)"


MATHML = Style(
    symbol=_symbol_html,
    number=lambda text: f"<mn>{text}</mn>",
    row=lambda parts: f"<mrow>{''.join(parts)}</mrow>",
    sign=lambda text: f"<mo>{text}</mo>",
    bracket=lambda inside: f"<mrow><mo>(</mo>{inside}<mo>)</mo></mrow>",
    absolute=lambda inside: f"<mrow><mo>|</mo>{inside}<mo>|</mo></mrow>",
    fraction=lambda top, bottom: f"<mfrac><mrow>{top}</mrow><mrow>{bottom}</mrow></mfrac>",
    root=lambda inside: f"<msqrt>{inside}</msqrt>",
    power=lambda base, exponent: f"<msup><mrow>{base}</mrow><mrow>{exponent}</mrow></msup>",
    call=_call_html,
)
LATEX = Style(
    symbol=_symbol_latex,
    number=lambda text: text,
    row=lambda parts: "\\,".join(parts) if all(p not in "+-" for p in parts) else " ".join(parts),
    sign=lambda text: {"−": "-"}.get(text, text),
    bracket=lambda inside: f"\\left({inside}\\right)",
    absolute=lambda inside: f"\\left|{inside}\\right|",
    fraction=lambda top, bottom: f"\\frac{{{top}}}{{{bottom}}}",
    root=lambda inside: f"\\sqrt{{{inside}}}",
    power=lambda base, exponent: f"{{{base}}}^{{{exponent}}}",
    call=_call_latex,
)
