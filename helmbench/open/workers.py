"""Jobs in processes of their own: a cancelled job ends at once, a faulty log takes nothing with it."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

WAITING, RUNNING, DONE, REFUSED, CANCELLED, FAILED = "waiting", "running", "done", "refused", "cancelled", "failed"
UNFINISHED = (WAITING, RUNNING)
LOST = "the process that computed it ended (out of memory?); the logs and all earlier results are still there"


@dataclass
class Job:
    """One job and how far it is.

    steps : most stages that it has;  stages : text and time of its begin, s since the start;  seconds : that it took,
    or has taken until now.
    """

    task: str
    arguments: Mapping[str, Any]
    steps: int = 1
    state: str = WAITING
    message: str = ""
    stages: list[tuple[str, float]] = field(default_factory=list[tuple[str, float]])
    started: float = field(default_factory=time.monotonic)
    ended: float | None = None
    worker: Worker | None = None

    @property
    def seconds(self) -> float:
        """Seconds since the start, or until the end."""
        return (self.ended or time.monotonic()) - self.started

    def finish(self, state: str, message: str = "") -> None:
        """End it, unless it has ended."""
        if self.state in UNFINISHED:
            self.state, self.message, self.ended = state, message, time.monotonic()

    def to_json(self) -> dict[str, Any]:
        """What the page shows of it."""
        stages = [{"text": text, "at": round(at, 1)} for text, at in self.stages]
        return {"task": self.task, "state": self.state, "message": self.message, "stages": stages,
                "steps": self.steps, "seconds": round(self.seconds, 1)}  # fmt: skip


class Worker:
    """A process that does one task after the other; it is started afresh, so it holds nothing of the server."""

    def __init__(self) -> None:
        from .tasks import work

        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    @property
    def pipe(self) -> Connection:
        """Takes tasks, gives messages."""
        return self._pipe

    def kill(self) -> None:
        """End the process at once."""
        self._process.kill()
        self._process.join()


class Workers:
    """The processes: as many jobs at a time as there are processors, one process kept warm."""

    def __init__(self) -> None:
        self._lock, self._places = threading.Lock(), threading.Semaphore(max(1, os.cpu_count() or 1))
        self._all: set[Worker] = set()
        self._idle: list[Worker] = []
        self._closed = False

    def warm(self) -> None:
        """Start a process in advance: it imports what every task needs."""
        self._give_back(self._new())

    def start(self, job: Job, finished: Callable[[Job, Any], object]) -> None:
        """Begin a job; `finished` is called with it and its result when it is done, from another thread."""
        threading.Thread(target=self._run, args=(job, finished), daemon=True).start()

    def cancel(self, job: Job) -> None:
        """End a job at once."""
        with self._lock:
            job.finish(CANCELLED, "cancelled")
            worker, job.worker = job.worker, None
        if worker is not None:
            self._drop(worker)

    def close(self) -> None:
        """End all processes."""
        with self._lock:
            self._closed = True
            workers = list(self._all)
        for worker in workers:
            self._drop(worker)

    def _run(self, job: Job, finished: Callable[[Job, Any], object]) -> None:
        with self._places:
            try:
                worker = self._taken(job)
            except OSError as error:  # the system gives no further process
                job.finish(FAILED, f"no process could be started ({error.strerror or error})")
                return
            if worker is None:
                return
            try:
                worker.pipe.send((job.task, job.arguments))
                while job.state == RUNNING:
                    kind, content = worker.pipe.recv()
                    if kind == "stage":
                        job.stages.append((content, job.seconds))
                    elif kind == DONE:
                        finished(job, content)
                        job.finish(DONE)
                    else:
                        job.finish(kind, content)
            except (EOFError, OSError):
                job.finish(FAILED, LOST)
                self._drop(worker)
                return
            with self._lock:
                mine, job.worker = job.worker is worker, None
            if mine:
                self._give_back(worker)

    def _taken(self, job: Job) -> Worker | None:
        """A process for the job; None where it was cancelled meanwhile."""
        with self._lock:
            if job.state != WAITING or self._closed:
                return None
            job.state = RUNNING
            job.stages.append(("starting", 0.0))
            worker = self._idle.pop() if self._idle else None
        worker = worker or self._new()
        with self._lock:
            if job.state == RUNNING:
                job.worker = worker
                return worker
        self._give_back(worker)
        return None

    def _new(self) -> Worker:
        worker = Worker()
        with self._lock:
            self._all.add(worker)
        return worker

    def _give_back(self, worker: Worker) -> None:
        with self._lock:
            keep = not self._idle and not self._closed
            if keep:
                self._idle.append(worker)
        if not keep:
            self._drop(worker)

    def _drop(self, worker: Worker) -> None:
        with self._lock:
            known = worker in self._all
            self._all.discard(worker)
            if worker in self._idle:
                self._idle.remove(worker)
        if known:
            worker.kill()
