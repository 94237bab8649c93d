"""Stored results of the same code stand for equal runs; another option or task makes a new one."""

import json
import os

import pytest

import helmbench
from helmbench.bench.journal import read_runs
from helmbench.bench.kinds import kind_of
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.suites import load_suite
from helmbench.bench.traces import read_traces
from helmbench.cli import status_of
from helmbench.models.errors import BadInput

pytestmark = pytest.mark.usefixtures("in_this_process")
SUITE = "entries: [{{vessels: response-1, methods: [{methods}], noise: low, seeds: {seeds}}}]\n"
OWN = """
from helmbench.methods.ls import Ls

class Own(Ls):
    name = "own"
"""


@pytest.fixture
def suite_of(tmp_path):
    def build(name, methods, seeds):
        path = tmp_path / f"{name}.yaml"
        path.write_text(SUITE.format(methods=", ".join(f"'{method}'" for method in methods), seeds=seeds))
        return str(path)

    return build


def journal(folder):
    return {run["key"]: run for run in read_runs(folder / "runs.jsonl")}


def contents(suite):
    loaded = load_suite(suite)
    return [kind_of(loaded.kind).content(spec) for spec in plan(loaded, RunSelection(loaded.name))]


def test_only_what_is_new_is_run(suite_of, tmp_path, capsys):
    first, more = suite_of("first", ["ls", "rls"], 2), suite_of("more", ["ls", "rls", "ridge"], 3)
    old = helmbench.run_suite(first, directory=tmp_path / "old", jobs=1).directory
    new = tmp_path / "new"
    assert status_of(["run", "--suite", more, "--reuse", str(old), "--jobs", "1", "-o", str(new)]) == 0
    assert "4 of 9 runs are taken from earlier results" in capsys.readouterr().err
    rows = helmbench.load_results(new).rows
    assert len(rows) == 9 and {row["suite"] for row in rows} == {"more"}
    times = {(row["method"], row["seed"]): row["wall_s"] for row in rows}
    earlier = {(row["method"], row["seed"]): row["wall_s"] for row in helmbench.load_results(old).rows}
    assert {name: times[name] for name in earlier} == earlier, "taken as they were"
    whole = helmbench.run_suite(more, directory=tmp_path / "whole", jobs=1)
    assert journal(new).keys() == journal(whole.directory).keys()
    assert [row["rel_error_median"] for row in rows] == [row["rel_error_median"] for row in whole.rows]
    traces = [{run["key"]: run["trace"] for run in read_traces(folder)} for folder in (new, whole.directory)]
    assert traces[0] == traces[1]


def test_a_method_of_a_file_is_always_run_anew(suite_of, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)
    own, shipped = contents(suite_of("own", [f"{file}:Own", "ls"], 1))
    assert own is None and shipped is not None


def test_options_and_tasks_are_part_of_the_content(suite_of):
    found = contents(suite_of("a", ["ls", "ls,scheme=midpoint", "rls", "tuned:ridge", "sklearn:SVR"], 2))
    assert None not in found and len(set(found)) == 10


def test_failed_runs_are_made_again(suite_of, tmp_path):
    file = tmp_path / "failing.py"
    file.write_text(
        f"import pathlib\n{OWN}\n    def estimate(self, records, model):\n"
        f"        if not pathlib.Path({str(tmp_path / 'go')!r}).exists():\n            raise ValueError('not yet')\n"
        "        return super().estimate(records, model)\n"
    )
    suite = suite_of("failing", [f"{file}:Own", "ls"], 1)
    old = helmbench.run_suite(suite, directory=tmp_path / "old", jobs=1, trust=True)
    assert old.counts == {"ok": 1, "failed": 1, "not_applicable": 0}
    (tmp_path / "go").touch()
    new = helmbench.run_suite(suite, directory=tmp_path / "new", jobs=1, trust=True, reuse=[old.directory])
    assert new.counts == {"ok": 2, "failed": 0, "not_applicable": 0}


def test_a_directory_without_results_is_refused(suite_of, tmp_path):
    os.mkdir(tmp_path / "empty")
    with pytest.raises(BadInput, match="holds no benchmark run"):
        helmbench.run_suite(suite_of("a", ["ls"], 1), directory=tmp_path / "new", jobs=1, reuse=[tmp_path / "empty"])
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(("name", "value"), [("version", "0+other"), ("packages", {"numpy": "1.0"})])
def test_results_of_other_code_or_packages_are_refused(suite_of, tmp_path, name, value):
    old = helmbench.run_suite(suite_of("a", ["ls"], 1), directory=tmp_path / "old", jobs=1).directory
    manifest = json.loads((old / "environment.json").read_text()) | {name: value}
    (old / "environment.json").write_text(json.dumps(manifest))
    with pytest.raises(BadInput, match="was made"):
        helmbench.run_suite(suite_of("a", ["ls"], 1), directory=tmp_path / "new", jobs=1, reuse=[old])
