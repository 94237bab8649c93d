"""A kill at any moment costs nothing: a resumed run ends as an unbroken one, with every run stored once."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

import helmbench
from helmbench.bench.journal import RUNS

from .killed_runs import tables

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.nightly
def test_runs_killed_at_random_moments_end_as_unbroken_ones(tmp_path, seed):
    command = [sys.executable, "-m", "tests.bench.killed_runs", str(tmp_path), str(seed), "20"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    print(done.stdout)


@pytest.mark.nightly
def test_a_command_with_workers_that_is_killed_goes_on_where_it_was(tmp_path, rng):
    (tmp_path / "mine.yaml").write_text("entries: [{vessels: response-1, methods: [ls, rls], noise: low, seeds: 20}]\n")
    words = ["run", "--suite", str(tmp_path / "mine.yaml"), "--jobs", "2", "--quiet", "-o", str(tmp_path / "broken")]
    broken, at = tmp_path / "broken", int(rng.integers(1, 39))
    process = subprocess.Popen([sys.executable, "-m", "helmbench", *words])
    log, end = broken / RUNS, time.monotonic() + 300
    while time.monotonic() < end and not (log.exists() and log.read_bytes().count(b"\n") >= at):
        time.sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    helmbench.run_suite(directory=broken, jobs=1, resume=True)
    whole = helmbench.run_suite(str(tmp_path / "mine.yaml"), directory=tmp_path / "whole", jobs=1)
    assert log.read_bytes().count(b"\n") == len(whole.rows) == 40
    for left, right in zip(tables(whole.directory), tables(broken), strict=True):
        pd.testing.assert_frame_equal(left, right, check_exact=True)
