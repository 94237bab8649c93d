"""Operators typed once: numba asks anew for the type of every `a * b`, two fifths of the time of compiling a kernel."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import types
from numba.core.types.functions import BaseFunction

PLAIN = (types.Float, types.Integer, types.Boolean, types.Literal, types.Array)
"""Types of arguments for which an operator always has the same signature."""
_search = BaseFunction.get_call_type
_found: dict[tuple[BaseFunction, tuple[Any, ...]], Any] = {}


def _signature(self: BaseFunction, context: Any, args: Any, kws: Any) -> Any:
    """`BaseFunction.get_call_type`, which remembers the signatures of operators with plain arguments."""
    asked = getattr(self.key[0], "__module__", None) == "_operator" and not kws
    if not asked or not all(isinstance(arg, PLAIN) for arg in args):
        return _search(self, context, args, kws)
    key = (self, tuple(args))
    if key not in _found:
        _found[key] = _search(self, context, args, kws)
    return _found[key]


@contextmanager
def operators_typed_once() -> Iterator[None]:
    """What is compiled meanwhile types equal operators once.  The caller holds numba's compiler lock.

    A function's other compiling, as that of another package, is as numba does it.
    """
    before = BaseFunction.get_call_type
    BaseFunction.get_call_type = _signature
    try:
        yield
    finally:
        BaseFunction.get_call_type = before
