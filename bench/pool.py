"""Executors: worker processes of this machine, behind the `concurrent.futures` interface.

Only a few calls are handed over at a time.  A call has as many items as take about `TOGETHER_S`, so that handing over
costs little for short items; what it does not come to within that time is handed over again.  When a worker dies, the
items that were in its pool are repeated one by one, so that only the item that kills its worker fails.
"""

from __future__ import annotations

import os
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, NamedTuple, TypeVar

from ..models.cache import cache_folder
from ..models.errors import EnvironmentFault
from ..models.folders import without_working_folder
from .environment import THREAD_VARIABLES, cpu_count

Item = TypeVar("Item")
IDLE_S = 60
MOST_GROWTH_BYTES = 2 * 2**30
"""Growth of a worker's memory beyond which loky renews it."""
QUEUED_PER_WORKER = 2
CHECKED_EVERY_S = 5.0
TOGETHER_S, MOST_TOGETHER = 0.25, 64
"""Time after which a call begins no further item, and the most items of a call."""


class Outcome(NamedTuple, Generic[Item]):
    """An item with the function's result, or with its error.

    The error is a `BrokenExecutor` only for an item that killed its worker when it ran alone.
    """

    item: Item
    result: Any
    error: BaseException | None


@dataclass(frozen=True)
class Pool:
    """`connect()` gives a working executor, a fresh one after a breakdown; `width` calls are in flight at a time.

    `check()` is called every `CHECKED_EVERY_S` while calls run and raises `EnvironmentFault` when they cannot end.
    """

    connect: Callable[[], Executor]
    width: int
    check: Callable[[], object] = lambda: None

    def outcomes(self, function: Callable[[Item], Any], items: Iterable[Item]) -> Iterator[Outcome[Item]]:
        """What the function makes of each item, in the order of completion.

        Raises `EnvironmentFault` where a worker met one.
        """
        queue, pending, together = deque(items), dict[Future, list[Item]](), 1
        while queue or pending:
            while queue and len(pending) < self.width:
                group = [queue.popleft() for _ in range(min(together, -(-len(queue) // self.width)))]
                pending[self._submit(function, group)] = group
            done = self._wait(pending)
            if any(_unanswered(future, pending[future]) for future in done):
                yield from self._one_by_one(function, pending)
                pending, together = {}, 1
                continue
            for future in done:
                group = pending.pop(future)
                found = _results(future, group)
                together = min(2 * together, MOST_TOGETHER) if len(found) == len(group) else len(found)
                queue.extendleft(reversed(group[len(found) :]))
                yield from found

    def _one_by_one(
        self, function: Callable[[Item], Any], pending: dict[Future, list[Item]]
    ) -> Iterator[Outcome[Item]]:
        """Results of the calls that are in flight; the items of those without an answer are run again, each alone."""
        while not all(future.done() for future in pending):
            self._wait([future for future in pending if not future.done()])
        for future, group in pending.items():
            found = [] if _unanswered(future, group) else _results(future, group)
            yield from found
            for item in group[len(found) :]:
                alone = self._submit(function, [item])
                self._wait([alone])
                yield from _results(alone, [item])

    def _wait(self, pending: Iterable[Future]) -> set[Future]:
        """The futures that have ended, as soon as one has."""
        pending = set(pending)
        while not (done := wait(pending, CHECKED_EVERY_S, FIRST_COMPLETED).done):
            self.check()
        return done

    def _submit(self, function: Callable[[Item], Any], group: Sequence[Item]) -> Future:
        """A future for one call; a pool that broke before it took the call counts as one that broke with it."""
        try:
            return self.connect().submit(call, function, group)
        except BrokenExecutor as error:
            future: Future = Future()
            future.set_exception(error)
            return future


def call(function: Callable[[Item], Any], group: Sequence[Item]) -> list[tuple[Any, Exception | None]]:
    """The function's results and errors for the first items: those that are begun within `TOGETHER_S`."""
    found: list[tuple[Any, Exception | None]] = []
    end = time.monotonic() + TOGETHER_S
    for item in group:
        try:
            found.append((function(item), None))
        except EnvironmentFault:
            raise
        except Exception as error:
            found.append((None, error))
        if time.monotonic() > end:
            break
    return found


def _results(future: Future, group: Sequence[Item]) -> list[Outcome[Item]]:
    """What a call came to; an `EnvironmentFault` is no result of its items and is raised."""
    error = future.exception()
    if isinstance(error, EnvironmentFault):
        raise error
    if error is not None:
        return [Outcome(item, None, error) for item in group]
    return [Outcome(item, *found) for item, found in zip(group, future.result(), strict=False)]


def _unanswered(future: Future, group: Sequence[Item]) -> bool:
    """Whether it is not known which items of a call ended: their worker died, or a result could not be sent back."""
    error = future.exception()
    if error is None or isinstance(error, EnvironmentFault):
        return False
    return isinstance(error, BrokenExecutor) or len(group) > 1


def worker_count(jobs: int | None) -> int:
    """Worker processes for a wish of `jobs` (None: one a processor): never more than there are processors."""
    return min(jobs or cpu_count(), cpu_count())


@contextmanager
def processes(jobs: int | None = None) -> Generator[Pool]:
    """Worker processes of this machine (default and most: one a processor), with single-threaded BLAS and numba."""
    from joblib.externals.loky import get_reusable_executor

    jobs = worker_count(jobs)
    cache_folder()  # before there are workers, which shall share it

    def connect() -> Any:
        return get_reusable_executor(
            max_workers=jobs,
            timeout=IDLE_S,
            initializer=_begin,
            initargs=(os.getpid(),),
            env=dict.fromkeys(THREAD_VARIABLES, "1"),
        )

    try:
        with warnings.catch_warnings(), without_working_folder():
            warnings.filterwarnings("ignore", "A worker stopped while some jobs")  # one that has grown is renewed
            yield Pool(connect, jobs * QUEUED_PER_WORKER)
    except BaseException:  # an interrupt, too, shall not wait for the tasks in flight
        connect().shutdown(wait=True, kill_workers=True)
        raise
    connect().shutdown(wait=True)


def _begin(parent: int) -> None:
    """Prepare a worker: it ends soon after its parent has gone, however that ended (loky's own workers wait for ever),
    and it is not renewed when it has grown by 300 MB, which libraries and compiled kernels alone do."""
    from joblib.externals.loky import process_executor

    process_executor._MAX_MEMORY_LEAK_SIZE = MOST_GROWTH_BYTES

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
