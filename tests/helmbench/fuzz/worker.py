"""Reading one input after the other in a process of its own, with limits of time and memory, and a watch for code."""

import multiprocessing
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from helmbench.models.errors import BadInput, CannotFit

from .readers import Reader

CPU_S, WALL_S = 10.0, 60.0
MEMORY = 2 * 2**30
"""Limits of one input: processor time, wall time (another load of the machine counts there), bytes beyond the start."""
FORBIDDEN = ("os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "subprocess.Popen")
LONGEST_LINE = 2000


@dataclass(frozen=True)
class ReaderOutcome:
    """accepted, refused, crash, hang, memory or code; what was said; seconds."""

    state: str
    said: str = ""
    wall_s: float = 0.0

    @property
    def failed(self) -> bool:
        return self.state not in ("accepted", "refused")


class _Hang(BaseException):
    pass


class ReaderProcess:
    """A process that reads inputs for one reader; a new one takes its place where it dies."""

    def __init__(self, reader: Reader, folder: Path) -> None:
        self.reader, self.folder = reader, folder
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self._inputs = 0

    def outcome(self, data: bytes) -> ReaderOutcome:
        """What reading the bytes comes to."""
        if self._process is None:
            self._start()
        assert self._pipe is not None and self._process is not None
        self._inputs += 1
        self._pipe.send_bytes(data)
        if not self._pipe.poll(WALL_S):
            self.close()
            return ReaderOutcome("hang", f"no answer after {WALL_S:.0f} s", WALL_S)
        try:
            found = self._pipe.recv()
            if found.state == "memory" and self._inputs > 1:  # by this input, or by what all before it have left?
                self.close()
                return self.outcome(data)
            whole = self.reader.whole if found.state == "hang" else None
            return found if whole is None else self._whole(whole)
        except EOFError:
            self._process.join()
            code = self._process.exitcode
            self.close()
            if self.reader.whole is not None:
                return self._whole(self.reader.whole)
            return ReaderOutcome("crash", f"the process ended with status {code}")

    def _whole(self, read: Callable[[Path], object]) -> ReaderOutcome:
        """What the call comes to that reads in processes of its own; the input ended this one, or held it up."""
        started, before = time.perf_counter(), signal.signal(signal.SIGPROF, _stop)
        signal.setitimer(signal.ITIMER_PROF, CPU_S)
        try:
            found = _called(read, self.folder / self.reader.name)
        except _Hang:
            found = ReaderOutcome("hang", f"more than {CPU_S:.0f} s")
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.signal(signal.SIGPROF, before)
        return ReaderOutcome(found.state, found.said, time.perf_counter() - started)

    def close(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._process, self._inputs = None, 0

    def _start(self) -> None:
        context = multiprocessing.get_context("fork")
        self._pipe, child = context.Pipe()
        self._process = context.Process(target=_serve, args=(child, self.reader, self.folder), daemon=True)
        with warnings.catch_warnings():  # after a test that used jax, jax warns of any fork
            warnings.filterwarnings("ignore", r"os\.fork\(\) was called", RuntimeWarning)
            self._process.start()
        child.close()
        self._pipe.recv()  # it has read the seeds: what an input takes begins here


def _serve(pipe: Connection, reader: Reader, folder: Path) -> None:
    warnings.simplefilter("ignore")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "trap.py").write_text(f"open({str(folder / 'canary')!r}, 'w').close()\nclass Mine: pass\n")
    path, ran = folder / reader.name, []
    for seed in reader.seeds:  # compiled and imported before limits and watch begin
        path.write_bytes(seed)
        _called(reader.read, path)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
    sys.addaudithook(lambda event, given: ran.append(event) if _is_code(event, given, folder) else None)
    signal.signal(signal.SIGPROF, _stop)
    pipe.send(None)
    while True:
        try:
            data = pipe.recv_bytes()
        except EOFError:
            return
        path.write_bytes(data)
        ran.clear()
        started = time.perf_counter()
        signal.setitimer(signal.ITIMER_PROF, CPU_S)
        try:
            found = _called(reader.read, path)
        except _Hang:
            found = ReaderOutcome("hang", f"more than {CPU_S:.0f} s")
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        if ran or (folder / "canary").exists():
            found = ReaderOutcome("code", f"{ran[:1]} ran; {found.said}")
            (folder / "canary").unlink(missing_ok=True)
        pipe.send(ReaderOutcome(found.state, found.said, time.perf_counter() - started))


def _called(read: Callable[[Path], object], path: Path) -> ReaderOutcome:
    try:
        read(path)
    except (BadInput, CannotFit) as refused:
        said = str(refused)
        if not said.isprintable() or len(said) > LONGEST_LINE:
            return ReaderOutcome("crash", f"not one short line: {said[:300]!r}")
        return ReaderOutcome("refused", said)
    except MemoryError as error:
        return ReaderOutcome("memory", str(error))
    except Exception as error:
        frames = traceback.extract_tb(error.__traceback__)[-3:]
        places = " > ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in frames)
        return ReaderOutcome("crash", f"{type(error).__name__}: {str(error)[:200]} at {places}")
    return ReaderOutcome("accepted")


def _is_code(event: str, given: tuple, folder: Path) -> bool:
    """Whether an audit event is a program that starts, or code of the folder that is executed."""
    if event == "exec":
        return str(folder) in str(getattr(given[0], "co_filename", ""))
    return event.startswith(FORBIDDEN)


def _stop(*_: object) -> None:
    raise _Hang
