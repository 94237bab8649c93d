"""From a symbolic definition to the source text of its kernels.

Helper symbols stay unexpanded and derivatives follow the chain rule through them; the mass matrix is never
inverted inside a derivative: with W = M^-1 and a = W F, d a = W d(F - M a) with a held.

One file, although a long one: a third of it is the text that generated modules begin with.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import cast

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

from .definition import Definition

LANES = 32
"""Records that one call of a lanes kernel advances together."""

Assignment = tuple[str, sp.Expr]

HEADER = '''"""Generated from the definition {name!r}; do not edit."""
from math import atan2, cos, log, sin, sqrt

import numpy as np
from helmbench.models.compilation import njit

FAST = {{"contract", "nsz", "arcp"}}
JIT = dict(cache=True, error_model="numpy", nogil=True, fastmath=FAST)


@njit(inline="always")
def sgn(x):
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@njit(inline="always")
def step(x):
    return 1.0 if x > 0.0 else 0.0


'''

LANE_FUNCTIONS = '''
ROUNDING = 6755399441055744.0  # 1.5 * 2**52: a sum with it ends in the bits of the nearest whole number


@njit(inline="always")
def lane_sincos(x):
    """Sine and cosine without branches: Cody-Waite reduction and polynomials of fdlibm, for |x| < 1e5."""
    shifted = x * 0.6366197723675814 + ROUNDING
    q = shifted - ROUNDING
    y = x - q * 1.5707963267341256
    y = y - q * 6.077100506303966e-11
    y = y - q * 2.0222662487959506e-21
    z = y * y
    s = y + y * z * (-1.66666666666666307295e-1 + z * (8.33333333332211858878e-3 + z * (
        -1.98412698295895385996e-4 + z * (2.75573136213857245213e-6 + z * (
            -2.50507477628578072866e-8 + z * 1.58962301576546568060e-10)))))
    c = 1.0 - 0.5 * z + z * z * (4.16666666666665929218e-2 + z * (-1.38888888888730564116e-3 + z * (
        2.48015872888517045348e-5 + z * (-2.75573141792967388112e-7 + z * (
            2.08757008419747316778e-9 + z * -1.13585365213876817300e-11)))))
    quarter = np.float64(shifted).view(np.int64)
    odd = (quarter & 1) == 1
    sine = np.float64(c if odd else s).view(np.int64) ^ ((quarter & 2) << 62)
    cosine = np.float64(s if odd else c).view(np.int64) ^ (((quarter + 1) & 2) << 62)
    return np.int64(sine).view(np.float64), np.int64(cosine).view(np.float64)


@njit(inline="always")
def lane_sin(x):
    return lane_sincos(x)[0]


@njit(inline="always")
def lane_cos(x):
    return lane_sincos(x)[1]


@njit(inline="always")
def lane_exp(x):
    """Exponential without branches: 2**k e**y with |y| <= log(2)/2, Taylor's series of e**y; 0 below -700."""
    shifted = min(max(x, -700.0), 700.0) * 1.4426950408889634 + ROUNDING
    k = shifted - ROUNDING
    y = min(max(x, -700.0), 700.0) - k * 0.6931471803691238 - k * 1.9082149292705877e-10
    p = 1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (
        1.0 / 720.0 + y * (1.0 / 5040.0 + y * (1.0 / 40320.0 + y * (1.0 / 362880.0 + y * (
            1.0 / 3628800.0 + y * (1.0 / 39916800.0 + y / 479001600.0)))))))))))
    power = (np.float64(shifted).view(np.int64) + 1023) << 52
    return p * np.int64(power).view(np.float64)


@njit(inline="always")
def lane_atan2(y, x):
    """Arc tangent without branches: an angle below pi/8, less pi/4 if need be, and a polynomial (Chebyshev, 1e-17)."""
    ay = abs(y)
    ax = abs(x)
    low = min(ax, ay)
    high = max(ax, ay) + 1e-300
    big = low > 0.4142135623730951 * high
    t = (low - high if big else low) / (low + high if big else high)
    z = t * t
    p = -0.3333333333333333 + z * (0.1999999999999552 + z * (-0.14285714284666542 + z * (
        0.11111111015256361 + z * (-0.09090904578123903 + z * (0.07692183190826087 + z * (
            -0.06664511447381948 + z * (0.0585814891280221 + z * (-0.0508544973794026 + z * (
                0.03923165829558719 + z * -0.01917688711906226)))))))))
    a = t + t * z * p + (0.7853981633974483 if big else 0.0)
    a = 1.5707963267948966 - a if ay > ax else a
    a = 3.141592653589793 - a if x < 0.0 else a
    return -a if y < 0.0 else a


'''


class _Printer(PythonCodePrinter):
    """Prints expressions as float arithmetic that numba compiles well (small powers as products)."""

    def __init__(self, prefix: str = ""):
        super().__init__({"fully_qualified_modules": False})
        self.functions = {name: prefix + name for name in ("sin", "cos")}
        self.functions |= {"exp": f"{prefix or 'np.'}exp", "atan2v": f"{prefix}atan2", "absv": "abs"}

    def _print_call(self, expr) -> str:
        name = type(expr).__name__
        return f"{self.functions.get(name, name)}({', '.join(self._print(argument) for argument in expr.args)})"

    _print_sin = _print_cos = _print_exp = _print_atan2v = _print_absv = _print_sgn = _print_step = _print_call

    def _print_Float(self, expr):
        return repr(float(expr))

    def _print_Integer(self, expr):
        return f"{int(expr)}.0" if expr >= 0 else f"({int(expr)}.0)"

    def _print_Rational(self, expr):
        return repr(float(expr)) if expr >= 0 else f"({float(expr)!r})"

    _print_Half = _print_Rational
    _print_One = _print_Zero = _print_NegativeOne = _print_Integer

    def _print_Pow(self, expr, *_, **__):
        base, power = expr.args
        if power == sp.S.Half:
            return f"sqrt({self._print(base)})"
        if power == -sp.S.Half:
            return f"(1.0/sqrt({self._print(base)}))"
        inner = self._print(base) if base.is_Atom else f"({self._print(base)})"
        if power.is_Integer and abs(power) <= 8:
            product = "*".join([inner] * abs(int(power)))
            return f"({product})" if power > 0 else f"(1.0/({product}))"
        return f"({inner})**({self._print(power)})"


def _emit(assignments: Iterable[Assignment]) -> list[str]:
    """Assignment lines with common subexpressions bound once, each just before its first use."""
    return _lines(_bound(assignments))


def _lines(assignments: Iterable[Assignment], indent: int = 4, prefix: str = "") -> list[str]:
    printer = _Printer(prefix)
    return [" " * indent + f"{name} = {printer.doprint(expression)}" for name, expression in assignments]


def _bound(assignments: Iterable[Assignment]) -> list[Assignment]:
    """The assignments with common subexpressions as further ones, each just before its first use."""
    names, expressions = zip(*[(name, sp.sympify(expression)) for name, expression in assignments], strict=True)
    shared, reduced = sp.cse(list(expressions), symbols=sp.numbered_symbols("_t"), order="none", list=True)
    pending, bound = dict(shared), list[Assignment]()

    def bind(expression: sp.Expr) -> None:
        for symbol in sorted(expression.free_symbols & pending.keys(), key=str):
            if symbol in pending:
                value = pending.pop(symbol)
                bind(value)
                bound.append((str(symbol), value))

    for name, expression in zip(names, reduced, strict=True):
        bind(expression)
        bound.append((name, expression))
    return bound


class _Once:
    """What parameters alone determine, which is worked out once a run: assignments, each before its first use."""

    def __init__(self, parameters: Iterable[sp.Symbol]) -> None:
        self.alone = {str(symbol) for symbol in parameters}
        self.assignments: list[Assignment] = []
        self._names: dict[sp.Basic, sp.Symbol] = {}

    def determines(self, expression: sp.Basic) -> bool:
        return bool(expression.free_symbols) and {str(symbol) for symbol in expression.free_symbols} <= self.alone

    def add(self, name: str, expression: sp.Basic) -> None:
        self.assignments.append((name, cast(sp.Expr, expression)))
        self.alone.add(name)

    def symbol_of(self, expression: sp.Basic) -> sp.Symbol:
        """The symbol of a value that is determined."""
        if expression not in self._names:
            self._names[expression] = sp.Symbol(f"_c{len(self._names)}")
            self.add(str(self._names[expression]), expression)
        return self._names[expression]

    def without(self, expression: sp.Basic) -> sp.Basic:
        """The expression with what is determined in it as symbols; of a sum or product its part."""
        if not expression.args:
            return expression
        if self.determines(expression):
            return self.symbol_of(expression)
        parts = [part for part in expression.args if part.is_number or self.determines(part)]
        if isinstance(expression, sp.Add | sp.Mul) and len(parts) > 1:
            others = [self.without(part) for part in expression.args if part not in parts]
            return expression.func(self.symbol_of(expression.func(*parts)), *others)
        return expression.func(*[self.without(part) for part in expression.args])


def _split(
    definition: Definition, assignments: Iterable[Assignment]
) -> tuple[list[Assignment], list[sp.Basic], list[Assignment]]:
    """What the parameters alone determine, the symbols that the rest needs of it and of them, and the rest."""
    once, rest = _Once(definition.parameters), list[Assignment]()
    for name, expression in _bound(assignments):
        if once.determines(expression):
            once.add(name, expression)
        else:
            rest.append((name, cast(sp.Expr, once.without(expression))))
    return once.assignments, sorted((symbol for symbol in _used(rest) if str(symbol) in once.alone), key=str), rest


def _used(assignments: Iterable[Assignment]) -> set[sp.Basic]:
    return set().union(*(sp.sympify(expression).free_symbols for _, expression in assignments))


def _loads(definition: Definition, used: set[sp.Basic], pattern: str, indent: int = 4) -> list[str]:
    """`name = _array[index]` for what is used; pattern has {array} and {index}."""
    arrays = (("_x", definition.states), ("_u", definition.inputs), ("_th", definition.parameters))
    return [
        " " * indent + f"{symbol} = " + pattern.format(array=array, index=index)
        for array, symbols in arrays
        for index, symbol in enumerate(symbols)
        if symbol in used
    ]


def _inverse_mass(definition: Definition) -> tuple[list[Assignment], dict[tuple[int, int], sp.Symbol]]:
    mass, size = definition.mass, len(definition.forces)
    assignments: list[Assignment] = [("_idet", 1 / cast(sp.Expr, mass.det(method="berkowitz")))]
    cofactors, inverse = mass.adjugate(), {}
    for row in range(size):
        for column in range(size):
            if cofactors[row, column] != 0:
                inverse[row, column] = sp.Symbol(f"_W{row}{column}")
                assignments.append((f"_W{row}{column}", sp.cancel(cofactors[row, column]) * sp.Symbol("_idet")))
    return assignments, inverse


def _accelerations(definition: Definition) -> tuple[list[Assignment], list[sp.Expr], dict]:
    """Assignments of helpers, forces and inverse mass; the accelerations as expressions; the inverse mass."""
    inverse_lines, inverse = _inverse_mass(definition)
    size = len(definition.forces)
    forces = [sp.Symbol(f"_F{row}") for row in range(size)]
    assignments = [(str(name), expression) for name, expression in definition.helpers.items()]
    assignments += [(str(name), force) for name, force in zip(forces, definition.forces, strict=True)]
    accelerations = [
        sp.Add(*[inverse[row, column] * forces[column] for column in range(size) if (row, column) in inverse])
        for row in range(size)
    ]
    return assignments + inverse_lines, accelerations, inverse


def _derivatives(definition: Definition, expressions: Sequence[sp.Expr], wrt: Sequence[sp.Symbol]):
    """Total derivatives through the helpers, and the assignments of the helpers' own derivatives."""
    rows: dict[sp.Symbol, dict[sp.Symbol, sp.Expr]] = {}
    assignments: list[Assignment] = []
    for helper, expression in definition.helpers.items():
        rows[helper] = {}
        for symbol in wrt:
            total = _total(expression, symbol, rows)
            if total != 0 and not total.is_Atom:
                name = sp.Symbol(f"_D_{helper}_{symbol}")
                assignments.append((str(name), total))
                total = name
            if total != 0:
                rows[helper][symbol] = total
    return [[_total(expression, symbol, rows) for symbol in wrt] for expression in expressions], assignments


def _total(expression: sp.Expr, symbol: sp.Symbol, rows: dict) -> sp.Expr:
    free = expression.free_symbols
    total = expression.diff(symbol) if symbol in free else sp.S.Zero
    for helper in sorted(free & rows.keys(), key=str):
        if symbol in rows[helper]:
            total += expression.diff(helper) * rows[helper][symbol]
    return total


def _differentiated(definition: Definition, wrt: Sequence[sp.Symbol]):
    """Assignments of the accelerations and of what derivatives need; the accelerations as symbols; by symbol of `wrt`
    the assignments of d(F - M a), and the derivatives of every state's rate in them."""
    assignments, accelerations, inverse = _accelerations(definition)
    size = len(definition.forces)
    held = [sp.Symbol(f"_a{row}") for row in range(size)]
    residuals = _residuals(definition, held)
    rows, helper_lines = _derivatives(definition, [*residuals, *definition.kinematics], wrt)
    columns = []
    for index, symbol in enumerate(wrt):
        parts = {row: sp.Symbol(f"_G{row}_{symbol}") for row in range(size) if rows[row][index] != 0}
        solved = [
            sp.Add(*[inverse[row, i] * part for i, part in parts.items() if (row, i) in inverse]) for row in range(size)
        ]
        own = [(str(part), rows[row][index]) for row, part in parts.items()]
        columns.append((own, [*solved, *(row[index] for row in rows[size:])]))
    return [*assignments, *zip(map(str, held), accelerations, strict=True), *helper_lines], held, columns


def _residuals(definition: Definition, accelerations: Sequence[sp.Symbol]) -> list[sp.Expr]:
    """F - M a, row by row, with the accelerations as plain symbols."""
    product = definition.mass * sp.Matrix(accelerations)
    return [sp.Add(force, -moved) for force, moved in zip(definition.forces, product, strict=True)]


def _outputs(definition: Definition, accelerations: Sequence[sp.Expr], pattern: str) -> list[Assignment]:
    return [(pattern.format(row), value) for row, value in enumerate([*accelerations, *definition.kinematics])]


def rhs_source(definition: Definition) -> str:
    """`rhs(x, u, th, dx)`: the state derivative."""
    assignments, accelerations, _ = _accelerations(definition)
    body = [*assignments, *_outputs(definition, accelerations, "_dx[{}]")]
    lines = ['@njit("void(f8[::1],f8[::1],f8[::1],f8[::1])", **JIT)', "def rhs(_x, _u, _th, _dx):"]
    return "\n".join([*lines, *_loads(definition, _used(body), "{array}[{index}]"), *_emit(body)]) + "\n\n\n"


def lanes_source(definition: Definition) -> str:
    """`prepare_lanes(th, p)`: the LANE_NUMBERS values of each of LANES records that its parameters determine, and
    `rhs_lanes(x, u, p, dx)`: the state derivative; element `index * LANES + lane`."""
    assignments, accelerations, _ = _accelerations(definition)
    outputs = _outputs(definition, accelerations, "_o{}")
    ahead, loads, rest = _split(definition, [*assignments, *outputs])
    pattern, lanes = "{array}[{index}*" + str(LANES) + "+_l]", f"    for _l in range({LANES}):"
    lines = [f"LANE_NUMBERS = {len(loads)}", "", ""]
    lines += ['@njit("void(f8[::1],f8[::1])", **JIT)', "def prepare_lanes(_th, _p):", lanes]
    lines += _loads(definition, {*_used(ahead), *loads}, pattern, 8) + _lines(ahead, 8, "lane_")
    lines += [f"        _p[{place * LANES}+_l] = {name}" for place, name in enumerate(loads)]
    lines += ["", "", '@njit("void(f8[::1],f8[::1],f8[::1],f8[::1])", **JIT)', "def rhs_lanes(_x, _u, _p, _dx):", lanes]
    lines += _loads(definition, _used(rest) - {*definition.parameters}, pattern, 8)
    lines += [f"        {name} = " + pattern.format(array="_p", index=place) for place, name in enumerate(loads)]
    lines += _lines(rest, 8, "lane_")
    lines += [f"        _dx[{row * LANES}+_l] = {name}" for row, (name, _) in enumerate(outputs)]
    return LANE_FUNCTIONS + "\n".join(lines) + "\n\n\n"


def simulate_source(definition: Definition) -> str:
    """`simulate(x0, U, th, h, substeps, hold, X)`: RK4 with the states as local variables."""
    assignments, accelerations, _ = _accelerations(definition)
    ahead, loads, rest = _split(definition, [*assignments, *_outputs(definition, accelerations, "_o{}")])
    states, inputs = [str(s) for s in definition.states], [str(s) for s in definition.inputs]
    rows = range(len(states))
    lines = ['@njit(error_model="numpy", fastmath=FAST, inline="never")']
    lines.append(f"def _rates({', '.join(states + inputs)}, _p):")
    lines += [f"    {name} = _p[{place}]" for place, name in enumerate(loads)] + _lines(rest)
    lines.append(f"    return {', '.join(f'_o{row}' for row in rows)}{',' if len(states) == 1 else ''}")
    lines += ["", "", '@njit("void(f8[::1],f8[:,::1],f8[::1],f8,i8,b1,f8[:,::1])", **JIT)']
    lines.append("def simulate(_x0, _U, _th, _h, _substeps, _hold, _X):")
    lines += _loads(definition, {*_used(ahead), *loads}, "{array}[{index}]")
    lines += [*_lines(ahead), f"    _p = np.empty({len(loads)})"]
    lines += [f"    _p[{place}] = {name}" for place, name in enumerate(loads)]
    lines += [f"    _z{row} = _x0[{row}]" for row in rows] + [f"    _X[0, {row}] = _z{row}" for row in rows]
    lines += ["    for _k in range(_U.shape[0] - 1):", "        for _s in range(_substeps):"]
    for tag, offset in (("a", "_s"), ("b", "(_s + 0.5)"), ("c", "(_s + 1.0)")):
        lines.append(f"            _f{tag} = 0.0 if _hold else {offset} / _substeps")
        lines += [
            f"            _{tag}u{i} = _U[_k, {i}] + _f{tag} * (_U[_k + 1, {i}] - _U[_k, {i}])"
            for i in range(len(inputs))
        ]
    stages = (("_p", "", "a"), ("_q", "0.5 * _h * _p{}", "b"), ("_r", "0.5 * _h * _q{}", "b"), ("_w", "_h * _r{}", "c"))
    for stage, move, tag in stages:
        arguments = [f"_z{row} + {move.format(row)}" if move else f"_z{row}" for row in rows]
        arguments += [f"_{tag}u{i}" for i in range(len(inputs))] + ["_p"]
        targets = "".join(f"{stage}{row}, " for row in rows)
        lines.append(f"            {targets}= _rates({', '.join(arguments)})")
    lines += [f"            _z{row} += _h / 6.0 * (_p{row} + 2.0 * (_q{row} + _r{row}) + _w{row})" for row in rows]
    lines += [f"        _X[_k + 1, {row}] = _z{row}" for row in rows]
    return "\n".join(lines) + "\n\n\n"


def tangent_source(definition: Definition) -> str:
    """`tangent(x, u, th, S, m, dx, dS, Ju, Jt)`: dS = Jx S for m columns at once; Ju dense, Jt sparse values.

    `JT_COLUMN`, `JT_ROW` say which coefficient and state each value of Jt belongs to; the caller adds them to dS.
    """
    count = len(definition.states)
    body, held, found = _differentiated(definition, [*definition.states, *definition.inputs, *definition.coefficients])
    columns: list[dict[int, sp.Expr]] = []
    for lines, derivatives in found:
        body += lines
        columns.append({row: value for row, value in enumerate(derivatives) if value != 0})
    body += _outputs(definition, held, "_dx[{}]")
    state_entries = {(row, j): value for j in range(count) for row, value in columns[j].items()}
    body += [(f"_j{row}_{j}", value) for (row, j), value in state_entries.items()]
    width = len(definition.inputs)
    body += [(f"_Ju[{row * width + j}]", v) for j in range(width) for row, v in columns[count + j].items()]
    sparse = [(j, row, v) for j, column in enumerate(columns[count + width :]) for row, v in sorted(column.items())]
    body += [(f"_Jt[{index}]", value) for index, (_, _, value) in enumerate(sparse)]
    lines = [f"JT_COLUMN = np.array({[j for j, _, _ in sparse]}, dtype=np.int64)"]
    lines += [f"JT_ROW = np.array({[row for _, row, _ in sparse]}, dtype=np.int64)", "", ""]
    lines.append('@njit("void(f8[::1],f8[::1],f8[::1],f8[::1],i8,f8[::1],f8[::1],f8[::1],f8[::1])", **JIT)')
    lines.append("def tangent(_x, _u, _th, _S, _m, _dx, _dS, _Ju, _Jt):")
    lines += _loads(definition, _used(body), "{array}[{index}]") + _emit(body)
    return "\n".join([*lines, *_product_loop(state_entries, count)]) + "\n\n\n"


def jacobian_source(definition: Definition) -> str:
    """`jacobian(x, u, th, dx, Jx, Ju)`: the state derivative, d dx/dx (n*n) and d dx/du (n*nu), row by row."""
    count, width = len(definition.states), len(definition.inputs)
    body, held, columns = _differentiated(definition, [*definition.states, *definition.inputs])
    body += _outputs(definition, held, "_dx[{}]")
    for index, (own, derivatives) in enumerate(columns):
        body += own
        name, at, step = ("_Jx", index, count) if index < count else ("_Ju", index - count, width)
        body += [(f"{name}[{row * step + at}]", value) for row, value in enumerate(derivatives)]
    lines = ['@njit("void(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1])", **JIT)']
    lines.append("def jacobian(_x, _u, _th, _dx, _Jx, _Ju):")
    return "\n".join([*lines, *_loads(definition, _used(body), "{array}[{index}]"), *_emit(body)]) + "\n\n\n"


def _product_loop(entries: dict[tuple[int, int], sp.Expr], count: int) -> list[str]:
    lines = ["    for _c in range(_m):"]
    lines += [f"        _s{j} = _S[{j} * _m + _c]" for j in sorted({j for _, j in entries})]
    values = [
        " + ".join(f"_j{row}_{j} * _s{j}" for j in range(count) if (row, j) in entries) or "0.0" for row in range(count)
    ]
    lines += [f"        _v{row} = {value}" for row, value in enumerate(values)]
    return lines + [f"        _dS[{row} * _m + _c] = _v{row}" for row in range(count)]


def regress_source(definition: Definition) -> str:
    """`regress(x, a, u, th, y, Phi)`: y = Phi c exactly, with y = M0 a - F0 and Phi = d(F - M a)/dc.

    Raises
    ------
    ValueError : if a coefficient enters in a non-linear way.
    """
    definition = _without_held(definition)
    size, coefficients = len(definition.forces), list(definition.coefficients)
    accelerations = [sp.Symbol(f"_a{row}") for row in range(size)]
    residuals = _residuals(definition, accelerations)
    rows, helper_lines = _derivatives(definition, residuals, coefficients)
    free = set().union(*(value.free_symbols for row in rows for value in row))
    if helper_lines or free & set(coefficients):
        raise ValueError(f"{definition.name}: the forces are not linear in the coefficients")
    zero = dict.fromkeys(coefficients, sp.S.Zero)
    body = [(str(name), expression.xreplace(zero)) for name, expression in definition.helpers.items()]
    body += [(f"_y[{row}]", -cast(sp.Expr, residual.xreplace(zero))) for row, residual in enumerate(residuals)]
    width = len(coefficients)
    body += [
        (f"_Phi[{row * width + j}]", value) for row in range(size) for j, value in enumerate(rows[row]) if value != 0
    ]
    used = _used(body)
    lines = ['@njit("void(f8[::1],f8[::1],f8[::1],f8[::1],f8[::1],f8[::1])", **JIT)']
    lines += ["def regress(_x, _a, _u, _th, _y, _Phi):", "    _Phi[:] = 0.0"]
    lines += [f"    _a{row} = _a[{row}]" for row in range(size) if accelerations[row] in used]
    return "\n".join([*lines, *_loads(definition, used, "{array}[{index}]"), *_emit(body)]) + "\n\n\n"


def _without_held(definition: Definition) -> Definition:
    """The definition with the coefficients that regression holds at zero."""
    zero = dict.fromkeys(definition.held, sp.S.Zero)
    return replace(
        definition,
        helpers={name: cast(sp.Expr, expression.xreplace(zero)) for name, expression in definition.helpers.items()},
        forces=[cast(sp.Expr, force.xreplace(zero)) for force in definition.forces],
    )


def public_source(definition: Definition) -> str:
    """`public(c, p, J)` and `private(p, c)`: coefficients to published parameters with Jacobian, and back."""
    if definition.public is None or definition.inverse is None:
        return ""
    names = list(definition.public)
    forward = [(f"_p[{i}]", definition.public[name]) for i, name in enumerate(names)]
    forward += [
        (f"_J[{i}, {j}]", definition.public[name].diff(symbol))
        for i, name in enumerate(names)
        for j, symbol in enumerate(definition.coefficients)
    ]
    backward = [(f"_c[{j}]", definition.inverse[str(s)]) for j, s in enumerate(definition.coefficients)]
    signature = '@njit("void(f8[::1],f8[::1],{})", **JIT)'
    lines = [signature.format("f8[:,::1]"), "def public(_c, _p, _J):"]
    lines += [f"    {symbol} = _c[{j}]" for j, symbol in enumerate(definition.coefficients)] + _emit(forward)
    lines += ["", "", '@njit("void(f8[::1],f8[::1])", **JIT)', "def private(_p, _c):"]
    lines += [f"    {name} = _p[{i}]" for i, name in enumerate(names)] + _emit(backward)
    return "\n".join(lines) + "\n\n\n"


def sources(definition: Definition) -> dict[str, str]:
    """The generated modules of a definition by part, each complete in itself: facts and rhs, and the heavier kernels.

    Raises
    ------
    ValueError : if a coefficient that is not declared `held` enters in a non-linear way.
    """
    simulated = definition.simulated()
    bodies = {
        "core": _facts(definition) + rhs_source(simulated) + public_source(definition),
        "simulate": simulate_source(simulated),
        "tangent": tangent_source(simulated),
        "lanes": lanes_source(simulated),
        "regress": regress_source(definition),
    }
    return {part: HEADER.format(name=definition.name) + body for part, body in bodies.items()}


def bank_sources(definition: Definition) -> dict[str, str]:
    """The generated modules of a bank variant: facts and rhs, and the Jacobian."""
    simulated = definition.simulated()
    bodies = {"core": _facts(definition) + rhs_source(simulated), "jacobian": jacobian_source(simulated)}
    return {part: HEADER.format(name=definition.name) + body for part, body in bodies.items()}


def _facts(definition: Definition) -> str:
    simulated, gain = definition.simulated(), definition.rate_gain
    coefficients = [str(s) for s in definition.coefficients]
    public = list(definition.public) if definition.public is not None else coefficients
    facts = {
        "TITLE": definition.title,
        "SOURCE": definition.source,
        "STATES": tuple(str(s) for s in simulated.states),
        "INPUTS": tuple(str(s) for s in simulated.inputs),
        "COEFFICIENTS": tuple(coefficients),
        "CONSTANTS": tuple(str(s) for s in definition.constants),
        "PARAMETERS": tuple(public),
        "UNITS": tuple(definition.units[name] for name in public),
        "REGRESSION_STATES": tuple(str(s) for s in definition.states),
        "REGRESSION_INPUTS": tuple(str(s) for s in definition.inputs),
        "HELPERS": tuple(str(s) for s in definition.helpers),
        "RATE_GAIN": coefficients.index(str(gain)) if gain is not None else None,
        "LINEAR": definition.linear,
        "ENVIRONMENT": definition.force_scale is not None,
        "PUBLISHED": definition.public is not None,
        "LANES": LANES,
    }
    return "".join(f"{name} = {value!r}\n" for name, value in facts.items()) + "\n\n"
