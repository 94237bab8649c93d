"""A pool of this process: one task after the other."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

import pytest

from helmbench.bench.pool import Pool


@contextmanager
def inline() -> Iterator[Pool]:
    """The pool."""
    yield Pool(_Inline, 1)


@contextmanager
def without_workers() -> Iterator[None]:
    """Suites are executed in this process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("helmbench.bench.pool.processes", lambda jobs=None: inline())
        yield


class _Inline(Executor):
    def submit(self, fn: Callable, /, *args: Any, **kwargs: Any) -> Future:
        future: Future = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future
