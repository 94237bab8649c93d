"""Suites from Python: run, load, rank."""

import pytest

import helmbench

from ...inline_pool import without_workers

pytestmark = pytest.mark.usefixtures("in_this_process")


@pytest.fixture(scope="module")
def suite(tmp_path_factory):
    path = tmp_path_factory.mktemp("suite") / "mine.yaml"
    path.write_text("title: mine\nentries: [{vessels: response-1, methods: [ls, rls], noise: [none, low], seeds: 2}]\n")
    return path


@pytest.fixture(scope="module")
def found(suite, tmp_path_factory):
    with without_workers():
        return helmbench.run_suite(str(suite), directory=tmp_path_factory.mktemp("runs") / "out", jobs=1)


def test_results_are_told_and_loaded_again(found):
    assert (found.suite, found.complete, found.counts) == ("mine", True, {"ok": 6, "failed": 0, "not_applicable": 0})
    assert repr(found).startswith("<SuiteResults 'mine': 6 runs, 6 ok, 0 failed, 0 not applicable; ")
    assert "6 ok" in found._repr_html_()
    again = helmbench.load_results(found.directory)
    assert [row["method"] for row in again.rows] == [row["method"] for row in found.rows] == ["ls"] * 3 + ["rls"] * 3
    assert len(again.runs()) == 6 and set(again.parameters()["parameter"]) == {"T", "K", "alpha"}
    assert (again.failures, again.failure_texts) == ([], {})


def test_the_leaderboard_is_the_same_from_results_and_directory(found):
    board = helmbench.leaderboard(found)
    assert set(board.overall["method"]) == {"ls", "rls"}
    assert board.overall.equals(helmbench.leaderboard(found.directory).overall)


def test_a_resumed_run_remembers_its_selection(suite, tmp_path):
    given = {"directory": tmp_path / "out", "jobs": 1}
    first = helmbench.run_suite(str(suite), methods=["ls"], seeds=1, **given)
    again = helmbench.run_suite(resume=True, **given)
    assert [row["method"] for row in first.rows] == [row["method"] for row in again.rows] == ["ls", "ls"]


def test_failed_runs_are_told(tmp_path):
    (tmp_path / "own.py").write_text(
        "from helmbench.methods.base import Method\n"
        "class Mine(Method):\n"
        "    name = 'mine'\n"
        "    def estimate(self, records, model):\n"
        "        raise RuntimeError('out of luck')\n"
    )
    (tmp_path / "mine.yaml").write_text("entries: [{vessels: response-1, methods: ls, noise: low, seeds: 2}]")
    methods = [f"{tmp_path / 'own.py'}:Mine"]
    found = helmbench.run_suite(str(tmp_path / "mine.yaml"), directory=tmp_path / "out", methods=methods, jobs=1)
    assert found.counts["failed"] == 2 and [failure["seed"] for failure in found.failures] == [0, 1]
    ((told, number),) = found.failure_texts.items()
    assert "out of luck" in told and number == 2


def test_what_holds_no_ranking_is_bad_input(tmp_path, manifest):
    with pytest.raises(helmbench.BadInput, match="no benchmark run"):
        helmbench.load_results(tmp_path)
    for kind, told in (("diagnosis", "ranks no identification methods"), ("identification", "no run is finished")):
        results = helmbench.SuiteResults(tmp_path, manifest(3) | {"kind": kind}, ())
        with pytest.raises(helmbench.BadInput, match=told):
            helmbench.leaderboard(results)
