"""Results from elsewhere: checked against the plan, computed again in part, added."""

import json

import pytest

from helmbench import run_suite
from helmbench.bench.journal import sealed, unsealed
from helmbench.bench.merging import merge
from helmbench.bench.store import read_manifest, read_tables
from helmbench.models.errors import BadInput

from ..support.inline_pool import without_workers

pytestmark = pytest.mark.usefixtures("in_this_process")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Results of one method each, of the same small suite."""
    base = tmp_path_factory.mktemp("merging")
    suite = base / "small.yaml"
    suite.write_text(
        "title: small\nentries:\n  - vessels: [response-1]\n    methods: [ls, rls]\n    noise: [low]\n    seeds: 2\n"
    )
    with without_workers():
        for name in ("ls", "rls"):
            run_suite(str(suite), directory=base / name, methods=[name], jobs=1)
    return base


@pytest.fixture
def copies(folders, tmp_path):
    """Fresh copies of both folders; copies(change) changes the first line of the source."""

    def build(change=None):
        for name in ("ls", "rls"):
            (tmp_path / name).mkdir()
            for path in (folders / name).iterdir():
                (tmp_path / name / path.name).write_bytes(path.read_bytes())
        if change:
            path = tmp_path / "rls" / "runs.jsonl"
            first, *others = path.read_bytes().splitlines(keepends=True)
            run = json.loads(unsealed(first.rstrip()))
            change(run)
            path.write_bytes(b"".join([sealed(run), *others]))
        return tmp_path / "rls", tmp_path / "ls"

    return build


def test_results_are_checked_and_added(copies):
    source, target = copies()
    found = merge(source, target, sample=1)
    assert (found.added, found.known, found.recomputed) == (2, 0, 1)
    assert set(read_tables(target)[0]["method"]) == {"ls", "rls"} and read_manifest(target)["planned"] == 4
    assert len((target / "traces.jsonl").read_text().splitlines()) == 2
    assert merge(source, target, sample=0).known == 2


def test_a_score_that_is_not_found_again_is_refused(copies):
    source, target = copies(lambda run: run["row"].update(r2_free_yaw_rate_rad_s=0.123456))
    before = (target / "runs.jsonl").read_bytes()
    told = r"runs\.jsonl: column r2_free_yaw_rate_rad_s: run method rls, vessel response-1, .*, noise low, "
    with pytest.raises(BadInput, match=told + r".*is 0\.123456, computed again it is"):
        merge(source, target, sample=2)
    assert (target / "runs.jsonl").read_bytes() == before


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda run: run["parameters"][0].update(estimate=9.0),
            r"column estimate: run method rls, .*, parameter \S+: estimate",
        ),
        (lambda run: run["parameters"].pop(), "column parameter: run method rls, vessel response-1, .*: parameter is"),
    ],
)
def test_parameters_that_are_not_found_again_are_refused(copies, change, told):
    source, target = copies(change)
    with pytest.raises(BadInput, match=told):
        merge(source, target, sample=2)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            lambda run: run.update(key="0" * 20),
            "column key: run method rls, vessel response-1, .*, seed 0 is not planned",
        ),
        (lambda run: run["row"].update(seed=7), "column seed: run method rls, .*: seed is 7, planned is 0"),
        (
            lambda run: run["row"].update(noise="high"),
            "column noise: run method rls, vessel response-1, .*: noise is 'high', planned is 'low'",
        ),
    ],
)
def test_runs_that_the_suite_does_not_plan_are_refused(copies, change, told):
    source, target = copies(change)
    with pytest.raises(BadInput, match=told):
        merge(source, target, sample=0)


def test_another_version_is_refused(copies):
    source, target = copies()
    manifest = json.loads((source / "environment.json").read_text())
    (source / "environment.json").write_text(json.dumps(manifest | {"version": "0.0.1"}))
    with pytest.raises(BadInput, match=r"made by version 0\.0\.1"):
        merge(source, target)
