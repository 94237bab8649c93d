"""Executors: worker processes of this machine, behind the `concurrent.futures` interface.

Only a few tasks are handed over at a time.  When a worker dies, the tasks that were in its pool are repeated one by
one, so that only the task that kills its worker fails.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from ..models.cache import cache_folder
from ..models.errors import EnvironmentFault
from .environment import THREAD_VARIABLES, cpu_count

Item = TypeVar("Item")
IDLE_S = 60
QUEUED_PER_WORKER = 2
CHECKED_EVERY_S = 5.0


@dataclass(frozen=True)
class Pool:
    """`connect()` gives a working executor, a fresh one after a breakdown; `width` tasks are in flight at a time.

    `check()` is called every `CHECKED_EVERY_S` while tasks run and raises `EnvironmentFault` when they cannot end.
    """

    connect: Callable[[], Executor]
    width: int
    check: Callable[[], object] = lambda: None

    def outcomes(self, function: Callable[[Item], Any], items: Iterable[Item]) -> Iterator[tuple[Item, Future]]:
        """Each item with its finished future, in the order of completion.

        `future.exception()` is a `BrokenExecutor` only for an item that killed its worker when it ran alone.
        Raises `EnvironmentFault` where a worker met one.
        """
        queue, pending = deque(items), dict[Future, Item]()
        while queue or pending:
            while queue and len(pending) < self.width:
                item = queue.popleft()
                pending[self._submit(function, item)] = item
            done = self._wait(pending)
            if any(_broken(future) for future in done):
                yield from self._one_by_one(function, pending)
                pending = {}
                continue
            for future in done:
                yield pending.pop(future), _checked(future)

    def _one_by_one(
        self, function: Callable[[Item], Any], pending: dict[Future, Item]
    ) -> Iterator[tuple[Item, Future]]:
        """Results of the tasks of a broken pool; those that it took down with it are run again, each alone."""
        while not all(future.done() for future in pending):
            self._wait([future for future in pending if not future.done()])
        for future, item in pending.items():
            if _broken(future):
                future = self._submit(function, item)
                self._wait([future])
            yield item, _checked(future)

    def _wait(self, pending: Iterable[Future]) -> set[Future]:
        """The futures that have ended, as soon as one has."""
        pending = set(pending)
        while not (done := wait(pending, CHECKED_EVERY_S, FIRST_COMPLETED).done):
            self.check()
        return done

    def _submit(self, function: Callable[[Item], Any], item: Item) -> Future:
        """A future for one call; a pool that broke before it took the task counts as one that broke with it."""
        try:
            return self.connect().submit(function, item)
        except BrokenExecutor as error:
            future: Future = Future()
            future.set_exception(error)
            return future


def _checked(future: Future) -> Future:
    """The future; an `EnvironmentFault` in it is no result of its item and is raised."""
    error = future.exception()
    if isinstance(error, EnvironmentFault):
        raise error
    return future


def _broken(future: Future) -> bool:
    return isinstance(future.exception(), BrokenExecutor)


def worker_count(jobs: int | None) -> int:
    """Worker processes for a wish of `jobs` (None: one a processor): never more than there are processors."""
    return min(jobs or cpu_count(), cpu_count())


@contextmanager
def processes(jobs: int | None = None) -> Iterator[Pool]:
    """Worker processes of this machine (default and most: one a processor), with single-threaded BLAS and numba."""
    from joblib.externals.loky import get_reusable_executor

    jobs = worker_count(jobs)
    cache_folder()  # before there are workers, which shall share it

    def connect() -> Any:
        return get_reusable_executor(
            max_workers=jobs,
            timeout=IDLE_S,
            initializer=_end_with,
            initargs=(os.getpid(),),
            env=dict.fromkeys(THREAD_VARIABLES, "1"),
        )

    try:
        yield Pool(connect, jobs * QUEUED_PER_WORKER)
    except BaseException:  # an interrupt, too, shall not wait for the tasks in flight
        connect().shutdown(wait=True, kill_workers=True)
        raise
    connect().shutdown(wait=True)


def _end_with(parent: int) -> None:
    """End this worker soon after its parent has gone, however that ended (loky's own workers wait for ever)."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
