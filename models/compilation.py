"""Types and options that all compiled functions share."""

from __future__ import annotations

from typing import Any

from numba import types

f8, i8, b1 = types.float64, types.int64, types.boolean
A1 = types.Array(f8, 1, "C")
A2 = types.Array(f8, 2, "C")
A3 = types.Array(f8, 3, "C")
I1 = types.Array(i8, 1, "C")
JIT: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True, "fastmath": {"contract", "nsz", "arcp"}}
"""Options of every kernel; the allowed floating-point rewrites keep infinities and NaN."""
BORROWED: dict[str, Any] = {"_nrt": False}
"""For inner kernels that allocate nothing: their arrays are not counted as references at every assignment (a fifth of
the innovations filter's time)."""
