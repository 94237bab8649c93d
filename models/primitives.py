"""Non-smooth functions for symbolic models, with fixed derivatives.

SymPy differentiates Abs, sign and Max into DiracDelta and Heaviside, which neither print nor evaluate.
These functions have the derivatives that hold almost everywhere, chosen once here.
"""

from __future__ import annotations

from typing import cast

import sympy as sp


class step(sp.Function):
    """1 where x > 0, else 0; derivative 0."""

    nargs = 1
    is_real = True

    def fdiff(self, argindex=1):
        return sp.S.Zero


class sgn(sp.Function):
    """Sign of x with sgn(0) = 0; derivative 0."""

    nargs = 1
    is_real = True

    def fdiff(self, argindex=1):
        return sp.S.Zero


class absv(sp.Function):
    """|x|; derivative sgn(x)."""

    nargs = 1
    is_real = True

    def fdiff(self, argindex=1):
        return sgn(self.args[0])


class atan2v(sp.Function):
    """atan2(y, x) whose derivatives stay finite at the origin."""

    nargs = 2
    is_real = True

    def fdiff(self, argindex=1):
        y, x = cast("tuple[sp.Expr, sp.Expr]", self.args)
        square = x**2 + y**2 + sp.Float(1e-300)
        return x / square if argindex == 1 else -y / square
