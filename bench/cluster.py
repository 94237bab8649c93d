"""A dask cluster as a pool: every worker has this version of the code; a lost cluster is told in one line."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Generator
from concurrent.futures import BrokenExecutor, Executor, Future
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from ..models.errors import BadInput, EnvironmentFault
from .environment import code_version
from .execution import one_line
from .pool import QUEUED_PER_WORKER, Pool

CONNECT_S = 10
WITHOUT_WORKERS_S = 120.0
"""How long a cluster may have no workers before the run is given up."""
UPDATE = "install the same helmbench on every worker and restart them"
RESUME = "what is finished is kept: continue with --resume"


@contextmanager
def cluster(address: str) -> Generator[Pool]:
    """Workers of a dask scheduler, `tcp://host:port`.

    Raises `BadInput` where dask.distributed is not installed, no scheduler answers or a worker has other code, and
    `EnvironmentFault` while tasks run, where the scheduler or all workers are lost.
    """
    try:
        client_class = import_module("distributed").Client
    except ImportError:
        hint = "install it with: pip install 'helmbench[distributed]'"
        raise BadInput("--scheduler needs dask.distributed", hint=hint) from None
    for name in logging.root.manager.loggerDict:  # no messages of dask: what matters is told by exceptions
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = client_class(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError) as error:
        raise BadInput(f"no dask scheduler at {address} ({one_line(error)})") from None
    try:
        _check_code(client)
        executor = _OnCluster(client, address)
        yield Pool(lambda: executor, max(1, sum(client.nthreads().values())) * QUEUED_PER_WORKER, executor.check)
    finally:
        client.close()


def _check_code(client: Any) -> None:
    """Refuse workers whose sources differ from those of this process: their rows would be another program's."""
    here = code_version()
    for worker, found in sorted(client.run(code_version, on_error="return").items()):
        if found != here:
            told = one_line(f"{type(found).__name__}: {found}") if isinstance(found, BaseException) else found
            raise BadInput(f"dask worker {worker} has other code than this process ({told}, here {here})", hint=UPDATE)


def on_worker(version: str, function: Callable[..., Any], *args: Any) -> Any:
    """`function(*args)` on a worker; `EnvironmentFault` on one that joined later, with other code."""
    if code_version() != version:
        raise EnvironmentFault(f"a dask worker has other code ({code_version()}, here {version})", hint=UPDATE)
    return function(*args)


class _OnCluster(Executor):
    """Tasks for the workers; their futures fail with `BrokenExecutor` for a task that killed its workers, and with
    `EnvironmentFault` for whatever is no fault of the task."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address, self._version = client, address, code_version()
        self._without_since: float | None = None

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future:
        found: Future = Future()
        try:
            task = self._client.submit(on_worker, self._version, fn, *args, **kwargs, pure=False)
        except Exception as error:
            found.set_exception(self._fault(error))
            return found
        task.add_done_callback(lambda ended: self._pass_on(ended, found))
        return found

    def _pass_on(self, task: Any, found: Future) -> None:
        """Enter what a dask future came to."""
        if task.status == "finished":
            try:
                return found.set_result(task.result())
            except Exception as error:
                return found.set_exception(self._fault(error))
        error = None if task.status in ("cancelled", "lost") else task.exception()
        if type(error).__name__ == "KilledWorker":
            found.set_exception(BrokenExecutor(one_line(error)))
        elif error is None and self._client.status == "running":
            found.set_exception(BrokenExecutor("the worker died before its result was fetched"))
        else:
            found.set_exception(error if isinstance(error, EnvironmentFault) else self._fault(error))

    def check(self) -> None:
        """Raise `EnvironmentFault` where the scheduler is lost, or all workers have been away for too long."""
        if self._client.status != "running":
            raise self._fault(None)
        now = time.monotonic()
        if self._client.nthreads():
            self._without_since = None
            return
        self._without_since = self._without_since or now
        if now - self._without_since > WITHOUT_WORKERS_S:
            raise EnvironmentFault(f"the dask cluster at {self._address} has lost all its workers", hint=RESUME)

    def _fault(self, error: BaseException | None) -> EnvironmentFault:
        why = "the connection is closed" if error is None else one_line(f"{type(error).__name__}: {error}")
        return EnvironmentFault(f"the dask cluster at {self._address} is lost ({why})", hint=RESUME)
