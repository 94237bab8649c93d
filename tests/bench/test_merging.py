"""Results from elsewhere: checked against the plan, computed again in part, added."""

import json
from math import comb

import pytest

from helmbench import run_suite, write_report
from helmbench.bench import merging
from helmbench.bench.journal import read_runs, sealed, unsealed
from helmbench.bench.merging import merge
from helmbench.bench.store import read_manifest, read_tables
from helmbench.bench.traces import read_traces
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
    assert len(read_traces(target)) == 2
    assert merge(source, target, sample=0).known == 2


def test_what_was_not_computed_again_is_marked(copies):
    source, target = copies()
    found = merge(source, target, sample=1)
    runs = {run["key"]: run for run in read_runs(target / "runs.jsonl")}
    marks = [run.get("recomputed") for run in runs.values() if run["row"]["method"] == "rls"]
    assert sorted(marks) == [False, True]
    assert [run["content"] is None for run in runs.values() if run.get("recomputed") is False] == [True]
    (entry,) = read_manifest(target)["merged"]
    assert (entry["added"], entry["recomputed"], entry["seed"]) == (2, 1, found.seed)
    text = write_report(target).markdown
    assert "MERGED: 2 runs come from elsewhere, 1 of them were not computed again." in text
    assert f"sample of seed {found.seed}" in text and "1 were not verified" in text


def test_the_sample_is_drawn_anew_and_drawn_again_by_its_seed(copies, monkeypatch):
    """A forger who knows no seed does not know which runs are computed again."""
    source, target = copies()
    drawn = []
    monkeypatch.setattr(merging, "_compare_runs", lambda kind, found, run, path: drawn.append(run["key"]))
    monkeypatch.setattr(merging, "_add", lambda *_: None)
    seeds = [merge(source, target, sample=1).seed for _ in range(20)]
    assert len(set(seeds)) == 20 and len(set(drawn)) == 2
    first = drawn.copy()
    drawn.clear()
    assert [merge(source, target, sample=1, seed=seed).seed for seed in seeds] == seeds and drawn == first


def test_runs_that_are_known_do_not_dilute_the_sample(copies):
    """Only what is added is drawn from: a folder that repeats the target's own runs does not hide a forged one."""
    source, target = copies(lambda run: run["row"].update(r2_free_yaw_rate_rad_s=0.123456))
    own = (target / "runs.jsonl").read_bytes().splitlines(keepends=True)
    forged, *_ = (source / "runs.jsonl").read_bytes().splitlines(keepends=True)
    (source / "runs.jsonl").write_bytes(b"".join([*own, forged]))
    for seed in range(4):
        with pytest.raises(BadInput, match="computed again it is"):
            merge(source, target, sample=1, seed=seed)


def test_a_score_in_a_column_that_the_run_does_not_have_is_refused(copies):
    source, target = copies(lambda run: run["row"].update(r2_free_surge_m_s=0.99))
    with pytest.raises(BadInput, match=r"column r2_free_surge_m_s: .*is 0\.99, computed again it is None"):
        merge(source, target, sample=2)


def test_what_is_no_column_is_left_out(copies):
    source, target = copies(lambda run: (run.update(content="f" * 20, note="x"), run["row"].update(extra=1.0)))
    merge(source, target, sample=0)
    for run in read_runs(target / "runs.jsonl"):
        assert "note" not in run and "extra" not in run["row"] and run["content"] != "f" * 20


def test_a_run_that_cannot_be_computed_here_is_named_and_another_one_drawn(copies):
    source, target = copies(
        lambda run: run["row"].update(status="failed", error="out of time: more than 1 s (--timeout)")
    )
    found = merge(source, target)
    assert (found.added, found.recomputed) == (2, 1)
    assert len(found.not_computable) == 1 and "a limit of the other machine ended it" in found.not_computable[0]
    assert "1 of the sample cannot be computed here: run method rls" in write_report(target).markdown


def test_files_that_the_source_names_are_not_read(copies, tmp_path):
    """Neither its suite, which is that of the target by its digest, nor a file of a vessel."""
    source, target = copies()
    manifest = json.loads((source / "environment.json").read_text())
    manifest["selection"]["suite"] = str(tmp_path / "none.yaml")
    (source / "environment.json").write_text(json.dumps(manifest))
    assert merge(source, target, sample=0).added == 2
    manifest["selection"]["vessels"] = ["/etc/secret.yaml"]
    (source / "environment.json").write_text(json.dumps(manifest))
    with pytest.raises(BadInput, match=r"names a file that the target does not: '/etc/secret\.yaml'"):
        merge(source, target)


@pytest.mark.parametrize(
    ("runs", "size"), [(1, 1), (29, 29), (30, 30), (31, 30), (600, 30), (601, 31), (1200, 60), (20_000, 1000)]
)
def test_the_sample_grows_with_what_is_added(runs, size):
    assert merging.sample_size(runs) == size


@pytest.mark.parametrize("runs", [1, 10, 31, 100, 600, 5000])
def test_a_tenth_of_forged_runs_is_detected(runs):
    """With a probability of 95 %, whatever their number (hypergeometric distribution)."""
    sample, forged = merging.sample_size(runs), -(-runs // 10)
    assert comb(runs - forged, sample) / comb(runs, sample) <= 0.05


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
