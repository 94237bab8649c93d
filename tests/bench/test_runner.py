"""Running: a kill changes nothing, and the manifest says what was run."""

import json
import sys
import time

import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helmbench.bench import journal, runner, store
from helmbench.bench.kinds.base import TIMES, RunSelection
from helmbench.bench.kinds.identification.columns import PARAMETERS, RESULTS
from helmbench.bench.kinds.identification.kind import KIND
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.store import Store
from helmbench.models.errors import BadInput

from ..made_up.suites import suite_file
from ..support.inline_pool import inline


def fake_execute(spec):
    """Deterministic apart from the measured columns."""
    row = spec.row_key() | {"status": "ok", "error": None, "diverged": False, "n_samples": 10}
    row |= {"rel_error_median": spec.task.seed / 7.0, "wall_s": time.perf_counter(), "cpu_s": time.process_time()}
    return {"key": spec.key, "row": row, "parameters": [{"parameter": "K", "estimate": 1.0 / (1 + spec.task.seed)}]}


class Killed(BaseException):
    """Stands in for a kill at any moment between two finished runs."""


def stored_tables(folder):
    frames = [pd.read_parquet(folder / name) for name in (RESULTS, PARAMETERS)]
    return [frame.drop(columns=[c for c in TIMES if c in frame]) for frame in frames]


def assert_same_tables(one, other):
    for left, right in zip(stored_tables(one), stored_tables(other), strict=True):
        pd.testing.assert_frame_equal(left, right, check_exact=True)


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(stops=st.lists(st.integers(0, 6), max_size=3), torn=st.integers(0, 30))
def test_interrupted_runs_end_in_the_same_tables(tmp_path_factory, stops, torn):
    folder = tmp_path_factory.mktemp("store")
    suite = suite_file(folder, "  - {vessels: [response-1, remus-kt], methods: [ls, rls], noise: low, seeds: 3}\n")
    selection = RunSelection("mine")
    specs = plan(suite, selection)
    with pytest.MonkeyPatch.context() as patch, inline() as pool:
        patch.setattr(KIND, "execute", fake_execute)
        with runner.open_store(folder / "whole", suite, selection, specs) as whole:
            runner.run(specs, whole, pool)
        runner.open_store(folder / "broken", suite, selection, specs).close()
        for stop in stops:
            count = iter(range(stop + 1))

            def watch(_, count=count):
                if next(count, None) is None:
                    raise Killed

            try:
                with runner.resume_store(folder / "broken", suite, specs) as broken:
                    runner.run(specs, broken, pool, watch)
            except Killed:
                log = (folder / "broken" / journal.RUNS).read_bytes()
                (folder / "broken" / journal.RUNS).write_bytes(log[: len(log) - torn])
        with runner.resume_store(folder / "broken", suite, specs) as broken:
            runner.run(specs, broken, pool)
    assert_same_tables(folder / "whole", folder / "broken")


def test_finished_runs_are_not_run_again(tmp_path, monkeypatch):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: [ls, rls], noise: low, seeds: 2}\n")
    specs = plan(suite, RunSelection("mine"))
    ran = []
    monkeypatch.setattr(KIND, "execute", lambda spec: ran.append(spec) or fake_execute(spec))
    with inline() as pool:
        with runner.open_store(tmp_path / "out", suite, RunSelection("mine"), specs) as opened:
            runner.run(specs[:1], opened, pool)
        with runner.resume_store(tmp_path / "out", suite, specs) as opened:
            runner.run(specs, opened, pool)
    assert ran == specs


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"suite": "other"}, "suite differs"),
        ({"version": "9.9"}, "version differs"),
        ({"suite_digest": "0"}, "the suite's file differs"),
        ({"plan_digest": "0"}, "the selection of methods, vessels and seeds differs"),
    ],
)
def test_a_run_of_something_else_is_not_resumed(tmp_path, change, complaint):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls}\n")
    specs = plan(suite, RunSelection("mine"))
    runner.open_store(tmp_path / "out", suite, RunSelection("mine"), specs).close()
    path = tmp_path / "out" / store.MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(BadInput, match=complaint):
        runner.resume_store(tmp_path / "out", suite, specs)
    Store.resume(tmp_path / "out").close()  # and it is not left locked


def test_the_manifest_says_what_was_run_with_what(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls, noise: low, seeds: 2}\n")
    specs = plan(suite, RunSelection("mine"))
    with runner.open_store(tmp_path / "out", suite, RunSelection("mine", seeds=2), specs) as opened:
        manifest = opened.manifest
    assert manifest["planned"] == 2 and manifest["seeds"] == "0-1" and manifest["threads_per_worker"] == 1
    assert {"python", "platform", "cpu", "cpus", "packages", "version"} <= manifest.keys()
    assert json.loads((tmp_path / "out" / store.MANIFEST).read_text()) == json.loads(json.dumps(manifest))
    assert sys.prefix not in json.dumps(manifest)


def test_the_manifest_does_not_grow_with_the_runs(tmp_path):
    sizes = []
    for seeds in (2, 5000):
        entry = f"  - {{vessels: response-1, methods: [ls, rls], noise: low, seeds: {seeds}}}\n"
        suite, selection = suite_file(tmp_path, entry), RunSelection("mine")
        specs = plan(suite, selection)
        assert len(specs) == 2 * seeds
        runner.open_store(tmp_path / f"of-{seeds}", suite, selection, specs).close()
        sizes.append((tmp_path / f"of-{seeds}" / store.MANIFEST).stat().st_size)
    assert abs(sizes[1] - sizes[0]) < 100
