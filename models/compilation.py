"""Types, options and the decorator that all compiled functions share; what it compiles is kept in `cache_folder()`."""

from __future__ import annotations

import hashlib
import pickle
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numba
import numpy as np
from numba import types

from .cache import BUILDING, FIRST_USE, cache_folder, lock_of, store, stored
from .numba_internals import (
    CFunc,
    Dispatcher,
    Form,
    NullCache,
    dumps,
    found_at_once,
    global_compiler_lock,
    normalize_signature,
    operators_typed_once,
)

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


def njit(*signatures: Any, cache: bool = False, **options: Any) -> Callable[[FunctionType], Any]:
    """`numba.njit`, which with `cache` keeps the machine code in `cache_folder()`, checked by its digest."""

    def decorate(function: FunctionType) -> Any:
        dispatcher: Any = numba.njit(**options)(function)
        if cache:
            dispatcher._cache = KernelCache(function, options)
            dispatcher.compile = dispatcher._cache.guarding(dispatcher.compile)
        for signature in signatures:
            dispatcher.compile(signature)
        if signatures:
            dispatcher.disable_compile()
        if len(signatures) == 1:
            found_at_once(dispatcher)
        return dispatcher

    return decorate


def callback(signature: Any, function: FunctionType) -> Any:
    """`numba.cfunc` with division as numpy's, kept like the functions of `njit`."""
    options = {"error_model": "numpy"}
    compiled: Any = CFunc(function, normalize_signature(signature), {}, options)
    compiled._cache = KernelCache(function, {**options, "kind": "callback"})
    compiled._cache.guarding(lambda _: compiled.compile())(signature)
    return compiled


class KernelCache(NullCache):
    """numba's cache of one function: a file for each signature, processor, set of options and version of its sources.

    Damaged files are compiled again.  Of several processes that need the same function one compiles, the others wait.
    """

    def __init__(self, function: FunctionType, options: Mapping[str, Any]) -> None:
        self._function, self._form, self._locks = function, Form(function), dict[Path, Any]()
        self._options = sorted((name, str(sorted(v) if isinstance(v, set) else v)) for name, v in options.items())

    @property
    def cache_path(self) -> str:
        return str(cache_folder())

    def guarding(self, build: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """A compiler of the function whose time is told apart and which leaves no lock behind, however it ends."""

        def guarded(signature: Any) -> Any:
            with BUILDING.running(), global_compiler_lock, operators_typed_once():
                try:
                    return build(signature)
                finally:
                    self._release()

        return guarded

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        target_context.refresh()
        path = self._path(sig, target_context.codegen())
        if path is None:
            return None
        found = self._read(path, target_context)
        if found is None and path not in self._locks:
            self._locks[path] = lock_of(path)
            found = self._read(path, target_context)
        if found is None:
            FIRST_USE.begins()
        return found

    def save_overload(self, sig: Any, cres: Any) -> None:
        path = self._path(sig, cres.codegen)
        if path is None:
            return
        try:
            if self._form.check_cachable(cres):
                store(path, dumps(self._form.reduce(cres)))
        except OSError as error:
            warnings.warn(f"{path.parent}: compiled code is not kept ({error.strerror})", RuntimeWarning, stacklevel=2)

    def _path(self, sig: Any, codegen: Any) -> Path | None:
        """File of a signature; None for one that holds an address, which no other process has."""
        function = self._function
        made_by = (numba.__version__, sys.version_info[:2], codegen.magic_tuple(), self._options)
        text = repr((*made_by, _sources(function), str(sig), function.__module__, function.__qualname__))
        if " at 0x" in text:
            return None
        return cache_folder() / f"{function.__name__}-{hashlib.sha256(text.encode()).hexdigest()[:32]}.nbc"

    def _read(self, path: Path, target_context: Any) -> Any:
        """The compiled function of a file; None where it is missing, damaged or of another make."""
        data = stored(path)
        if data is None:
            return None
        try:
            return self._form.rebuild(target_context, pickle.loads(data))
        except Exception:
            return None

    def _release(self) -> None:
        while self._locks:
            _, lock = self._locks.popitem()
            if lock is not None:
                lock.release()


@cache
def _sources(function: FunctionType) -> str:
    """Digest of what a compiled function is made from: its file, those of the functions it calls, and constants."""
    seen: dict[FunctionType, None] = {}
    constants: list[str] = []
    todo = [function]
    while todo:
        one = todo.pop()
        if one in seen:
            continue
        seen[one] = None
        for name, value in _named(one):
            if isinstance(value, Dispatcher):
                todo.append(value.py_func)
            elif isinstance(value, bool | int | float | str | tuple):
                constants.append(f"{name}={value!r}")
            elif isinstance(value, np.ndarray):
                constants.append(f"{name}={value.dtype}{value.shape}{value.tobytes().hex()}")
    files = sorted({_digest(one.__code__.co_filename) for one in seen})
    return hashlib.sha256("\n".join([*files, *sorted(constants)]).encode()).hexdigest()


def _named(function: Any) -> Iterator[tuple[str, Any]]:
    """The globals and captured variables that a function's code names, with their values."""
    cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    yield from ((name, cell.cell_contents) for name, cell in cells)
    yield from (
        (name, function.__globals__[name]) for name in _names(function.__code__) if name in function.__globals__
    )


def _names(code: CodeType) -> set[str]:
    """Names in a code object and in those within it."""
    inner = (_names(part) for part in code.co_consts if isinstance(part, CodeType))
    return set(code.co_names).union(*inner)


@cache
def _digest(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()
