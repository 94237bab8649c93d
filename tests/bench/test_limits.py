"""One bad method costs its own rows only: time, memory and the death of its process are told in them."""

import subprocess
import sys

import pytest

import helmbench
from helmbench.bench import runner
from helmbench.bench.environment import cpu_count
from helmbench.bench.execution import Limits
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification import execute
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.pool import processes
from helmbench.models.errors import BadInput, EnvironmentFault

from ..made_up.suites import suite_file
from ..support.inline_pool import inline

METHOD = """
import ctypes, os, time
import numpy as np
from helmbench.methods.base import Method

class Bad(Method):
    name = "{name}"
    def estimate(self, records, model):
        {body}
"""
DEAF_TO_EXCEPTIONS = """
        while True:
            try:
                time.sleep(0.01)
            except Exception:
                pass
"""
BODIES = {
    "crash": "ctypes.string_at(0)",
    "leave": "os._exit(0)",
    "hang": DEAF_TO_EXCEPTIONS,
    "deaf": "ctypes.PyDLL(None).sleep(600)  # holds the interpreter's lock",
    "greedy": "np.ones(2**29)",
}


@pytest.fixture
def named(tmp_path):
    """`path.py:Class` of bad methods."""
    for name, body in BODIES.items():
        (tmp_path / f"{name}.py").write_text(METHOD.format(name=name, body=body))
    return lambda *names: [f"{tmp_path / name}.py:Bad" for name in names]


def suite_of_one_run(tmp_path):
    return suite_file(tmp_path, "  - {vessels: response-1, methods: ls, noise: low, seeds: 1}\n")


def errors_of(tmp_path, methods, limits):
    """Method -> error of its row."""
    suite = suite_of_one_run(tmp_path)
    selection = RunSelection("mine", methods=tuple(methods))
    specs = plan(suite, selection)
    with processes(2) as pool, runner.open_store(tmp_path / "out", suite, selection, specs) as store:
        runner.run(specs, store, pool, limits=limits)
        assert len(store.runs) == len(specs)
        return {run["row"]["method"]: run["row"]["error"] for run in store.runs}


@pytest.mark.nightly
def test_a_method_that_ends_its_process_leaves_the_suite_running(tmp_path, named):
    suite_of_one_run(tmp_path)
    chosen = [word for name in ["ls", *named("crash", "leave")] for word in ("--method", name)]
    words = ["run", "--suite", str(tmp_path / "mine.yaml"), *chosen, "--jobs", "2", "-o", str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-m", "helmbench", *words], capture_output=True, text=True, timeout=300)
    assert done.returncode == 1, done.stderr
    rows = {row["method"]: row for row in helmbench.load_results(tmp_path / "out").rows}
    assert {name: row["status"] for name, row in rows.items()} == {"ls": "ok", "crash": "failed", "leave": "failed"}
    assert "worker process died (SIGSEGV)" in rows["crash"]["error"] and "died" in rows["leave"]["error"]
    assert "Traceback" not in done.stderr


@pytest.mark.nightly
def test_runs_out_of_time_say_so(tmp_path, named):
    errors = errors_of(tmp_path, named("hang", "deaf"), Limits(seconds=1.0, grace_s=1.0))
    assert errors == dict.fromkeys(("hang", "deaf"), "out of time: more than 1 s (--timeout)")


@pytest.mark.nightly
def test_runs_out_of_memory_say_so(tmp_path, named):
    errors = errors_of(tmp_path, named("greedy"), Limits(gib=2.0))
    assert errors["greedy"].startswith("out of memory: Unable to allocate 4.00 GiB")


@pytest.mark.parametrize("limits", [Limits(0.0), Limits(-1.0), Limits(float("nan")), Limits(1e300), Limits(None, 0.0)])
def test_limits_that_make_no_sense_are_refused(limits):
    with pytest.raises(BadInput, match="is needed"):
        limits.check()


@pytest.mark.nightly
def test_more_workers_than_processors_are_capped_with_a_word(tmp_path):
    suite_of_one_run(tmp_path)
    said = []
    asked = cpu_count() + 3
    wide = {"timeout_s": 600.0, "memory_gib": 8.0}
    given = {"directory": tmp_path / "out", "jobs": asked, "message": said.append}
    assert helmbench.run_suite(str(tmp_path / "mine.yaml"), **given, **wide).counts["ok"] == 1
    assert said == [f"{asked} workers asked for, {cpu_count()} processors here: {cpu_count()} workers"]


def test_limits_on_a_cluster_are_refused_before_anything_is_written(tmp_path):
    with pytest.raises(BadInput, match="dask has its own"):
        helmbench.run_suite(directory=tmp_path / "out", scheduler="tcp://127.0.0.1:1", timeout_s=5.0)
    assert not (tmp_path / "out").exists()


def test_a_fault_of_the_machine_ends_the_run_and_is_no_row(tmp_path, monkeypatch):
    def full(*_):
        raise EnvironmentFault("no space left", hint="free some")

    monkeypatch.setattr(execute, "fit_and_score", full)
    suite = suite_of_one_run(tmp_path)
    specs = plan(suite, RunSelection("mine"))
    with inline() as pool, runner.open_store(tmp_path / "out", suite, RunSelection("mine"), specs) as store:
        with pytest.raises(EnvironmentFault, match="no space left; free some"):
            runner.run(specs, store, pool)
        assert store.runs == []
