"""The worker pool: nothing is lost when workers die, and workers die with their parent."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor

import pytest

from helmbench.bench import pool as pools
from helmbench.bench.environment import THREAD_VARIABLES

from ..support.inline_pool import inline


def collect(pool, function, items):
    return {outcome.item: outcome for outcome in pool.outcomes(function, items)}


def test_every_item_comes_back_once_and_exceptions_stay_with_their_item():
    with inline() as pool:
        found = collect(pool, float, ["1", "one", "2"])
    assert (found["1"].result, found["2"].result) == (1.0, 2.0)
    assert isinstance(found["one"].error, ValueError) and found["1"].error is None


def test_a_dying_worker_costs_only_the_item_that_kills_it():
    def work(item):  # inside the test, so that it travels to the workers by value
        if item == "die":
            os.kill(os.getpid(), signal.SIGKILL)
        return item

    items = [f"item {i}" for i in range(6)] + ["die"] + [f"item {i}" for i in range(6, 12)]
    with pools.processes(2) as pool:
        found = collect(pool, work, items)
    assert sorted(found) == sorted(items)
    assert isinstance(found.pop("die").error, BrokenExecutor)
    assert all(outcome.result == item for item, outcome in found.items())


@pytest.mark.nightly
def test_a_worker_that_dies_behind_many_short_items_costs_only_the_item_that_kills_it():
    def work(item):
        if item == 150:
            os.kill(os.getpid(), signal.SIGKILL)
        return -item

    with pools.processes(2) as pool:
        found = list(pool.outcomes(work, range(300)))
    assert sorted(outcome.item for outcome in found) == list(range(300))
    assert [outcome.item for outcome in found if outcome.error is not None] == [150]
    assert all(outcome.result == -outcome.item for outcome in found if outcome.error is None)


def test_a_result_that_cannot_be_sent_back_costs_only_its_own_item():
    def work(item):
        return (lambda: threading.Lock())() if item == 40 else item

    with pools.processes(1) as pool:
        found = collect(pool, work, range(60))
    assert sorted(found) == list(range(60))
    assert [item for item, outcome in found.items() if outcome.error is not None] == [40]


class CountingExecutor(ThreadPoolExecutor):
    """Keeps the groups of items that were handed over, and the most that were in flight at once."""

    def __init__(self, workers):
        super().__init__(workers)
        self.groups, self.running, self.most = [], 0, 0

    def submit(self, fn, /, *args, **kwargs):
        self.groups.append(len(args[1]))
        self.running += 1
        self.most = max(self.most, self.running)
        future = super().submit(fn, *args, **kwargs)
        future.add_done_callback(self._done)
        return future

    def _done(self, future):
        self.running -= 1


def test_short_items_are_handed_over_together_and_each_comes_back_once():
    with CountingExecutor(1) as executor:
        found = [outcome.item for outcome in pools.Pool(lambda: executor, 2).outcomes(float, range(5000))]
    assert sorted(found) == list(range(5000))
    assert len(executor.groups) < 5000 / 20 and max(executor.groups) <= pools.MOST_TOGETHER


def test_twenty_thousand_tiny_runs_are_handed_over_in_hundreds_of_calls(monkeypatch):
    """What a run costs beside its work is handing it over: a call takes as many runs as it may."""
    monkeypatch.setattr(pools, "TOGETHER_S", 1e9)  # however slow the machine is, all runs are tiny
    items, width = 20_000, 4
    with CountingExecutor(1) as executor:
        found = [outcome.item for outcome in pools.Pool(lambda: executor, width).outcomes(abs, range(items))]
    assert sorted(found) == list(range(items))
    assert len(executor.groups) < 1.2 * items / pools.MOST_TOGETHER + 10 * width


def test_long_items_come_back_one_by_one(monkeypatch):
    """The first items are short, so that many are handed over together; those that a call does not begin go back."""
    monkeypatch.setattr(pools, "TOGETHER_S", 0.02)
    begun = []

    def work(item):
        begun.append(item)
        time.sleep(0.05 if item >= 100 else 0.0)

    with CountingExecutor(1) as executor:
        found = [outcome.item for outcome in pools.Pool(lambda: executor, 1).outcomes(work, range(120))]
    assert found == list(range(120)) == begun
    assert set(executor.groups[-10:]) <= {1, 2}


def test_workers_have_one_thread_each():
    with pools.processes(1) as pool:
        threads = collect(pool, os.getenv, THREAD_VARIABLES)
    assert [outcome.result for outcome in threads.values()] == ["1"] * len(THREAD_VARIABLES)


def test_no_more_than_the_width_is_in_flight():
    with CountingExecutor(1) as executor:
        collect(pools.Pool(lambda: executor, 3), float, range(2000))
    assert executor.most <= 3


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
