"""The worker pool: nothing is lost when workers die, and workers die with their parent."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor

from helmbench.bench import pool as pools
from helmbench.bench.environment import THREAD_VARIABLES

from ..inline_pool import inline


def collect(pool, function, items):
    return {item: future for item, future in pool.outcomes(function, items)}


def test_every_item_comes_back_once_and_exceptions_stay_with_their_item():
    with inline() as pool:
        found = collect(pool, float, ["1", "one", "2"])
    assert (found["1"].result(), found["2"].result()) == (1.0, 2.0)
    assert isinstance(found["one"].exception(), ValueError)


def test_a_dying_worker_costs_only_the_item_that_kills_it():
    def work(item):  # inside the test, so that it travels to the workers by value
        if item == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    items = [f"item {i}" for i in range(6)] + ["die"] + [f"item {i}" for i in range(6, 12)]
    with pools.processes(2) as pool:
        found = collect(pool, work, items)
    assert sorted(found) == sorted(items)
    assert isinstance(found.pop("die").exception(), BrokenExecutor)
    assert all(future.result() == item for item, future in found.items())


def test_workers_have_one_thread_each():
    with pools.processes(1) as pool:
        threads = collect(pool, os.getenv, THREAD_VARIABLES)
    assert [future.result() for future in threads.values()] == ["1"] * len(THREAD_VARIABLES)


def test_no_more_than_the_width_is_in_flight():
    running, most = set(), []

    class Watching(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            running.add(args[0])
            most.append(len(running))
            return super().submit(fn, *args, **kwargs)

    def done(item):
        running.discard(item)

    with Watching(1) as executor:
        collect(pools.Pool(lambda: executor, 3), done, range(20))
    assert max(most) <= 3


def test_workers_end_when_their_parent_is_killed(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import os, pathlib, sys, time\n"
        "from helmbench.bench import pool\n"
        "def child(path):\n"
        "    pathlib.Path(path).write_text(str(os.getpid()))\n"
        "    time.sleep(60)\n"
        "if __name__ == '__main__':\n"
        "    with pool.processes(1) as workers:\n"
        "        list(workers.outcomes(child, [sys.argv[1]]))\n"
    )
    mark = tmp_path / "pid"
    parent = subprocess.Popen([sys.executable, script, mark])
    try:
        assert _wait(lambda: mark.exists() and mark.read_text(), 60)
        child = int(mark.read_text())
    finally:
        parent.kill()
        parent.wait()
    assert _wait(lambda: not _alive(child), 30)


def _wait(condition, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.1)
    return False


def _alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    with open(f"/proc/{pid}/stat") as stat:
        return stat.read().rpartition(")")[2].split()[0] != "Z"
