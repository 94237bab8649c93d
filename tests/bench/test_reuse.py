"""Stored results stand for equal runs; a changed source, option or task makes a new one."""

import os
import subprocess
import sys

import pytest

import helmbench
from helmbench.bench import content
from helmbench.bench.journal import read_runs
from helmbench.bench.kinds import kind_of
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification import kind as identification
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


def test_a_changed_file_of_a_method_changes_its_content(suite_of, tmp_path):
    file = tmp_path / "own.py"
    file.write_text(OWN)
    suite = suite_of("own", [f"{file}:Own", "ls"], 1)
    before = contents(suite)
    content._file_digest.cache_clear()
    content.sources_digest.cache_clear()
    identification._sources.cache_clear()
    file.write_text(OWN + "\n    trials = 3\n")
    after = contents(suite)
    assert before[0] != after[0] and before[1] == after[1]


def test_options_and_tasks_are_part_of_the_content(suite_of):
    found = contents(suite_of("a", ["ls", "ls,scheme=midpoint", "rls", "tuned:ridge", "sklearn:SVR"], 2))
    assert None not in found and len(set(found)) == 10


def test_the_sources_of_a_method_are_those_that_it_imports():
    files, packages = content._reached(["helmbench.methods.narx"])
    reached = {path.relative_to(content.ROOT).as_posix() for path in files if content.ROOT in path.parents}
    assert {"methods/narx.py", "methods/learner.py", "estimation/methods_only/black_box/narx.py"} <= reached
    assert "methods/pem.py" not in reached and not any(name.startswith("reporting/") for name in reached)
    assert {"sklearn", "numpy"} <= packages


def test_sources_are_found_without_importing_them():
    code = (
        "import sys; from helmbench.bench.content import sources_digest; "
        "print(sources_digest('helmbench.models.families.extensions'), 'sympy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    digest, imported = done.stdout.split()
    assert len(digest) == 20 and imported == "False"


def test_what_belongs_to_no_package_is_not_reused(suite_of, tmp_path, monkeypatch):
    (tmp_path / "local_helper.py").write_text("X = 1\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    file = tmp_path / "leaning.py"
    file.write_text("import local_helper\n" + OWN)
    assert contents(suite_of("leaning", [f"{file}:Own"], 1)) == [None]


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
