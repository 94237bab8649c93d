"""Everything of numba that is not its public interface: no other file imports `numba.core` or sets what numba owns.

`pyproject.toml` bounds the version.  Beside the names that `compilation` needs, two changes: operators are typed once
(numba asks anew for the type of every `a * b`, two fifths of the time of compiling a kernel), and a function with one
signature is found at once where it is an argument.
"""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from types import FunctionType
from typing import Any

import numba

try:
    from numba.core import types
    from numba.core.caching import CompileResultCacheImpl, NullCache
    from numba.core.ccallback import CFunc
    from numba.core.compiler_lock import global_compiler_lock
    from numba.core.dispatcher import Dispatcher
    from numba.core.serialize import dumps
    from numba.core.sigutils import normalize_signature
    from numba.core.types.functions import BaseFunction
except ImportError as error:
    raise ImportError(
        f"numba {numba.__version__} lacks what helmbench uses ({error}); install numba >= 0.60, < 0.70"
    ) from error

__all__ = [
    "CFunc",
    "Dispatcher",
    "Form",
    "NullCache",
    "dumps",
    "found_at_once",
    "global_compiler_lock",
    "normalize_signature",
    "operators_typed_once",
]
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
def operators_typed_once() -> Generator[None]:
    """What is compiled meanwhile types equal operators once.  The caller holds numba's compiler lock.

    A function's other compiling, as that of another package, is as numba does it.
    """
    before = BaseFunction.get_call_type
    BaseFunction.get_call_type = _signature
    try:
        yield
    finally:
        BaseFunction.get_call_type = before


class Form(CompileResultCacheImpl):
    """How numba writes and reads a compiled function; where it lies is said by `compilation.KernelCache`."""

    class _Locator:
        def __init__(self, file: str) -> None:
            self._py_file = file

    def __init__(self, function: FunctionType) -> None:
        self._lineno, self._locator = function.__code__.co_firstlineno, self._Locator(function.__code__.co_filename)


def found_at_once(dispatcher: Any) -> None:
    """Remember where the only version of a function lies: numba looks for it at every call that takes the function as
    an argument, which costs .1 ms."""
    ((types_of_arguments, compiled),) = dispatcher.overloads.items()
    search = dispatcher.get_compile_result
    compiled.library.get_pointer_to_function = cache(compiled.library.get_pointer_to_function)
    dispatcher.get_compile_result = lambda sig: compiled if sig.args == types_of_arguments else search(sig)
