"""Runs of a small suite, killed at random moments and resumed: `python -m tests.bench.killed_runs FOLDER SEED KILLS`.

One process imports everything, then forks for each attempt, so that a kill costs a tenth of a second.
"""

import faulthandler
import json
import os
import signal
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

import helmbench
from helmbench.bench import pool
from helmbench.bench.journal import RUNS
from helmbench.bench.kinds.base import TIMES
from helmbench.bench.kinds.identification.columns import PARAMETERS, RESULTS
from helmbench.bench.kinds.identification.kind import KIND

from ..support.inline_pool import inline

SUITE = "entries: [{vessels: [response-1, remus-kt], methods: [ls, rls], noise: low, seeds: 5}]\n"
MOST_KILLS = 6
"""Kills of one run before it is left alone."""


def fake_execute(spec):
    """Deterministic apart from its times, of which one is some milliseconds."""
    time.sleep(0.003)
    row = spec.row_key() | {"status": "ok", "error": None, "diverged": False, "n_samples": 10}
    row |= {"rel_error_median": spec.task.seed / 7.0, "wall_s": time.perf_counter()}
    return {"key": spec.key, "row": row, "parameters": [{"parameter": "K", "estimate": 1.0 / (1 + spec.task.seed)}]}


def attempt(suite: Path, folder: Path, most_s: float) -> bool:
    """Run or resume the suite in a process of its own, killed after so many seconds; whether it was."""
    child = os.fork()
    if child == 0:
        done = 1
        faulthandler.dump_traceback_later(50.0)  # a run that hangs says where
        try:
            helmbench.run_suite(str(suite), directory=folder, resume=True)
            done = 0
        finally:
            os._exit(done)
    end = time.monotonic() + most_s
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            assert status == 0, f"the run ended with {status} by itself"
            return False
        time.sleep(0.001)
    os.kill(child, signal.SIGKILL)
    status = os.waitpid(child, 0)[1]
    assert status in (0, signal.SIGKILL), f"the run ended with {status} by itself"
    return status != 0


def tables(folder: Path) -> list[pd.DataFrame]:
    frames = [pd.read_parquet(folder / name) for name in (RESULTS, PARAMETERS)]
    return [frame.drop(columns=[name for name in TIMES if name in frame]) for frame in frames]


def check(whole: list[pd.DataFrame], folder: Path) -> None:
    """The tables are those of an unbroken run, every run is stored once, and nothing half-written is left."""
    for left, right in zip(whole, tables(folder), strict=True):
        pd.testing.assert_frame_equal(left, right, check_exact=True)
    lines = (folder / RUNS).read_text().splitlines()
    counts = Counter(json.loads(line)["key"] for line in lines)
    assert len(counts) == len(whole[0]) and set(counts.values()) == {1}
    assert not list(folder.glob(".*")), list(folder.glob(".*"))


def main(folder: Path, seed: int, kills: int) -> None:
    rng = np.random.default_rng(seed)
    suite = folder / "mine.yaml"
    suite.write_text(SUITE)
    tqdm.set_lock(threading.RLock())  # its own is shared with forks, of which one may be killed that holds it
    pool.processes = lambda jobs: inline()
    KIND.execute = fake_execute
    helmbench.run_suite(str(suite), directory=folder / "whole")  # imports all that the forks need
    begin = time.monotonic()
    assert not attempt(suite, folder / "timed", 60.0)
    lasts = time.monotonic() - begin
    whole, done, runs, began = tables(folder / "whole"), 0, 0, 0
    while done < kills:
        broken = folder / f"broken-{runs}"
        for _ in range(MOST_KILLS):
            if not attempt(suite, broken, rng.uniform(0.0, lasts)):
                break
            done += 1
            began += (broken / RUNS).exists()
        else:
            assert not attempt(suite, broken, 60.0)
        check(whole, broken)
        runs += 1
    print(f"seed {seed}: {done} kills, {began} of them after the first run was stored, {runs} runs, {lasts:.2f} s each")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
