"""Suites from Python: run, load, rank."""

import pytest

import helmbench

pytestmark = pytest.mark.usefixtures("in_this_process")


@pytest.fixture
def suite(board):
    return board.parent / "mine.yaml"


@pytest.fixture
def found(board):
    return helmbench.load_results(board)


def test_results_are_loaded(found):
    assert (found.suite, found.complete, found.counts) == ("mine", True, {"ok": 6, "failed": 0, "not_applicable": 0})
    assert repr(found).startswith("<SuiteResults 'mine': 6 runs, 6 ok, 0 failed, 0 not applicable; ")
    assert "6 ok" in found._repr_html_()
    assert [row["method"] for row in found.rows] == ["ls"] * 3 + ["rls"] * 3
    assert len(found.runs()) == 6 and set(found.parameters()["parameter"]) == {"T", "K", "alpha"}
    assert (found.failures, found.failure_texts) == ([], {})


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
