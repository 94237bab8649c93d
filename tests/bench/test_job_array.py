"""Job arrays on submitit's local executor: results as of one process, nothing lost when a job or its parent dies."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

import helmbench
from helmbench.bench import job_array
from helmbench.bench.execution import Limits
from helmbench.bench.journal import RUNS
from helmbench.bench.traces import read_traces
from helmbench.models.errors import BadInput, EnvironmentFault

from .killed_runs import tables

SUITE = "entries: [{vessels: response-1, methods: [ls, rls], noise: low, seeds: 10}]\n"
SLOW = """
import time
from helmbench.methods.ls import Ls

class Slow(Ls):
    name = "slow"
    def estimate(self, records, model):
        time.sleep(0.5)
        return super().estimate(records, model)
"""


@pytest.fixture
def suite(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(SUITE)
    return str(path)


def submitted(suite, folder, **options):
    return helmbench.run_suite(suite, directory=folder, **{"array": "local", "jobs": 2, "trust": True} | options)


def started(folder):
    """A command that runs 12 slow runs in two jobs into `out`; each job has finished one when this returns."""
    method, path = folder / "slow.py", folder / "slow.yaml"
    method.write_text(SLOW)
    path.write_text(f"entries: [{{vessels: response-1, methods: ['{method}:Slow'], noise: low, seeds: 12}}]\n")
    words = ["run", "--suite", str(path), "--array", "local", "--jobs", "2", "--trust", "-o", str(folder / "out")]
    process = subprocess.Popen([sys.executable, "-m", "helmbench", *words], stderr=subprocess.PIPE, text=True)
    wait_for(lambda: len(found := lines(folder / "out")) == 2 and min(found) >= 1)
    return process


def lines(folder):
    """Numbers of lines in the journals of the jobs."""
    return [path.read_bytes().count(b"\n") for path in (folder / job_array.PARTS).glob(f"*/{RUNS}")]


def assert_each_run_once(folder, expected):
    assert (folder / RUNS).read_bytes().count(b"\n") == expected
    assert not (folder / job_array.PARTS).exists()


@pytest.mark.nightly
def test_an_array_stores_what_one_process_stores(suite, tmp_path):
    seen = submitted(suite, tmp_path / "jobs")
    alone = helmbench.run_suite(suite, directory=tmp_path / "alone", jobs=1)
    assert seen.counts == alone.counts == {"ok": 20, "failed": 0, "not_applicable": 0}
    assert_each_run_once(tmp_path / "jobs", 20)
    for left, right in zip(tables(alone.directory), tables(seen.directory), strict=True):
        pd.testing.assert_frame_equal(left, right, check_exact=True)
    traces = [{run["key"]: run["trace"] for run in read_traces(one.directory)} for one in (alone, seen)]
    assert traces[0] == traces[1]


@pytest.mark.nightly
def test_a_job_that_is_killed_costs_only_what_it_had_not_finished(tmp_path):
    process = started(tmp_path)
    kill_jobs(process.pid, 1)
    told = process.communicate(timeout=120)[1].strip().splitlines()[-1]
    assert process.returncode == 2 and re.search(r"1 of 2 jobs ended before their runs were finished", told), told
    kept = (tmp_path / "out" / RUNS).read_bytes().count(b"\n")
    assert 2 <= kept < 12
    found = helmbench.run_suite(directory=tmp_path / "out", array="local", jobs=1, resume=True, trust=True)
    assert found.counts["ok"] == 12
    assert_each_run_once(tmp_path / "out", 12)


@pytest.mark.nightly
def test_jobs_that_outlive_their_parent_are_waited_for(tmp_path):
    process = started(tmp_path)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    found = helmbench.run_suite(directory=tmp_path / "out", array="local", jobs=1, resume=True, trust=True)
    assert found.counts["ok"] == 12
    assert_each_run_once(tmp_path / "out", 12)


@pytest.mark.parametrize(("cluster", "workers"), [("local", 2), ("slurm", None)])
def test_jobs_of_one_machine_share_its_processors(tmp_path, monkeypatch, manifest, cluster, workers):
    monkeypatch.setattr(job_array, "cpu_count", lambda: 6)
    store = SimpleNamespace(manifest=manifest(9))
    array = job_array.JobArray(cluster, 3)
    shares = job_array._shares(list(range(9)), tmp_path, store, array, Limits())
    assert [share.workers for share in shares] == [workers] * 3
    assert [share.specs for share in shares] == [[0, 3, 6], [1, 4, 7], [2, 5, 8]]


def test_a_job_with_other_code_stores_nothing(suite, tmp_path, monkeypatch):
    share = job_array.JobShare(tmp_path, [], None, "9.9+other")
    with pytest.raises(EnvironmentFault, match="a job has other code"):
        job_array.work(share)
    assert "9.9+other" in (tmp_path / job_array.REASON).read_text()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"array": "pbs"}, "known: slurm, local"),
        ({"array_options": {"no_such_option": 1}}, "no_such_option"),
        ({"scheduler": "tcp://127.0.0.1:1"}, "exclude"),
    ],
)
def test_wrong_options_are_one_line(suite, tmp_path, options, told):
    with pytest.raises(BadInput, match=told):
        submitted(suite, tmp_path / "out", **options)


def test_without_slurm_its_absence_is_told(suite, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BadInput, match="--array slurm"):
        helmbench.run_suite(suite, directory=tmp_path / "out", array="slurm")


def kill_jobs(parent, number):
    """Kill so many of the jobs that a process has submitted, with all their processes."""
    jobs = [pid for pid in children(parent) if b"submitit" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    for pid in jobs[:number]:
        for own in [pid, *descendants(pid)]:
            os.kill(own, signal.SIGKILL)


def children(parent):
    return [int(text) for text in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]


def descendants(parent):
    return [pid for child in children(parent) for pid in (child, *descendants(child))]


def wait_for(condition, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
