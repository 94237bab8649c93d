"""Small suites with a stub diagnoser, by the command line: run, resume after a kill, report."""

import json

import pandas as pd
import pytest

from helmbench.bench import runner
from helmbench.bench.journal import RUNS
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.columns import CASES, SIZES
from helmbench.bench.kinds.diagnosis.execute import execute, injected_of
from helmbench.bench.kinds.diagnosis.kind import KIND
from helmbench.bench.kinds.diagnosis.plan import CaseSpec, plan
from helmbench.bench.suites import load_suite
from helmbench.cli import status_of

from ....support.inline_pool import inline

here = pytest.mark.usefixtures("in_this_process")
STUB = """
from helmbench.diagnosis.registry import Diagnoser
from helmbench.diagnosis.result import Diagnosis, Finding, Gain
from helmbench.checks.result import Size

class Guess(Diagnoser):
    name = "guess"
    title = "always a rudder offset"

    def diagnose(self, model, train, held_out, options):
        assert [len(train), len(held_out)] == [3, 2] or len(train[0].time_s) == 120
        sizes = (Size("delta0", 0.0, -1.0, 1.0, "rad"),)
        found = (Finding("rudder_offset", (), "dynamics", 9.0, 0.0, sizes),)
        gain = {"heading_rad": Gain(1.0, 0.5, 0.4, 0.6, 0.0, 0.0, 0.0)}
        told = (model, model, "file", (), .01, options.seed, "named", "", found, ())
        return Diagnosis(*told, gain, None, {}, (), (), None, 0., 0.)
"""
ENTRIES = """kind: diagnosis
methods: [innovations]
entries:
  - {group: injected, inject: [rudder_offset], vessels: [response-1]}
  - {group: "null", inject: [none], vessels: [response-1], each: 2}
"""


@pytest.fixture
def suite(tmp_path):
    (tmp_path / "mine.yaml").write_text(ENTRIES)
    return str(tmp_path / "mine.yaml")


@pytest.fixture
def guess(tmp_path):
    (tmp_path / "guess.py").write_text(STUB)
    return f"{tmp_path / 'guess.py'}:Guess"


@pytest.mark.usefixtures("here_or_in_a_worker")
def test_a_suite_is_run_and_reported(suite, guess, tmp_path, capsys):
    out = str(tmp_path / "out")
    arguments = ["run", "--suite", suite, "--method", guess, "--jobs", "1", "--json", "-o", out]
    assert status_of(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["runs"] == told["ok"] == 3 and told["seed"] > 0
    cases, sizes = pd.read_parquet(tmp_path / "out" / CASES), pd.read_parquet(tmp_path / "out" / SIZES)
    assert cases["outcome"].tolist() == ["alone", "false_alarm", "false_alarm"]
    assert sizes[["parameter", "covered"]].values.tolist() == [["delta0", True]]
    assert status_of(["report", out, "--json"]) == 0
    rows = {row["rate"]: row for row in json.loads(capsys.readouterr().out)["leaderboard"]}
    assert rows["named"]["value"] == 1.0 and rows["false_clean"]["value"] == 1.0


@here
def test_a_killed_run_is_continued_with_the_same_cases(suite, guess, tmp_path, capsys):
    out, whole = tmp_path / "out", tmp_path / "whole"
    arguments = ["run", "--suite", suite, "--method", guess, "--jobs", "1", "--quiet"]
    assert status_of([*arguments, "-o", str(out)]) == 0
    lines = (out / RUNS).read_bytes().splitlines(keepends=True)
    (out / RUNS).write_bytes(lines[0] + lines[1][:-9])
    assert status_of(["run", "--resume", "--trust", "--jobs", "1", "-o", str(out)]) == 0
    seed = json.loads((out / "environment.json").read_text())["selection"]["seed"]
    assert f"--seed {seed}" in capsys.readouterr().err
    assert status_of([*arguments, "--seed", str(seed), "-o", str(whole)]) == 0
    cost = ["wall_s", "cpu_s", "peak_memory_mib"]
    resumed, fresh = (pd.read_parquet(folder / CASES).drop(columns=cost) for folder in (out, whole))
    pd.testing.assert_frame_equal(resumed, fresh)
    assert (out / RUNS).read_bytes().splitlines()[0] == lines[0].rstrip(b"\n")


@here
def test_another_seed_cannot_continue_a_run(suite, guess, tmp_path, capsys):
    arguments = ["run", "--suite", suite, "--method", guess, "--jobs", "1", "--quiet", "-o", str(tmp_path / "out")]
    assert status_of([*arguments, "--seed", "1"]) == 0
    assert status_of([*arguments, "--seed", "2", "--resume"]) == 2
    assert "cannot be resumed" in capsys.readouterr().err


def test_a_suite_of_methods_takes_no_seed(tmp_path, capsys):
    assert status_of(["run", "--suite", "quick", "--seed", "1", "-o", str(tmp_path / "out")]) == 2
    assert "--seed" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_case_is_made_again_from_its_row(suite, guess, seed):
    specs = plan(load_suite(suite), RunSelection(suite, methods=(guess,), seed=seed))
    first, again = (injected_of(specs[0]) for _ in range(2))
    assert first.effects == again.effects
    assert (first.train[0].column("heading_rad") == again.train[0].column("heading_rad")).all()


def test_a_diagnoser_that_fails_is_a_row(suite, tmp_path, seed, guess):
    (tmp_path / "guess.py").write_text(STUB.replace("sizes = ", "raise RuntimeError('no idea')\n        sizes = "))
    loaded = load_suite(suite)
    specs = plan(loaded, RunSelection(suite, methods=(guess,), seed=seed))
    with inline() as pool, runner.open_store(tmp_path / "out", loaded, RunSelection(suite), specs) as store:
        runner.run(specs[:1], store, pool)
    (run,) = store.runs
    assert run["row"]["status"] == "failed" and run["row"]["error"] == "RuntimeError: no idea"
    assert run["row"]["noncentrality"] > 0 and "no idea" in KIND.describe(run["row"])


def test_the_oracle_of_a_gross_fault_runs(seed):
    """Its causes are no parameters of the filter: the bank it is told is empty."""
    spec = CaseSpec("diagnosis", "oracle", "oracle", "injected", "cargo", ("rudder_sign",), "moderate", "none", seed)
    row = execute(spec)["row"]
    assert (row["status"], row["named"]) == ("ok", "rudder_sign"), row["error"]
