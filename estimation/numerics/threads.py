"""Threads for work that mostly runs compiled code, which holds no lock."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import lru_cache
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")
_this = threading.local()


def in_threads(threads: int, work: Callable[[T], R], items: Iterable[T]) -> list[R]:
    """Results of work in the order of the items; below two threads, or in one of them, the caller does all of it."""
    if threads < 2 or getattr(_this, "of_pool", False):
        return [work(item) for item in items]
    return list(_pool(threads).map(in_context(work), items))


def beside(threads: int, one: Callable[[], T], other: Callable[[], R]) -> tuple[T, R]:
    """Results of two pieces of work that hand out work to threads themselves; below two threads one after the other."""
    if threads < 2:
        return one(), other()
    context = copy_context()
    with ThreadPoolExecutor(1) as pool:
        later = pool.submit(lambda: context.run(other))
        return one(), later.result()


def in_context(work: Callable[[T], R]) -> Callable[[T], R]:
    """Work that a thread does in the caller's context, which says how floating-point errors are treated."""
    context = copy_context()
    return lambda item: context.copy().run(work, item)


def _enter_pool() -> None:
    _this.of_pool = True


@lru_cache(maxsize=4)
def _pool(threads: int) -> ThreadPoolExecutor:
    """Threads, shared by all callers: they keep nothing.  Work that one of them hands out would wait for itself."""
    return ThreadPoolExecutor(threads, initializer=_enter_pool)
