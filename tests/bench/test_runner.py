"""Enumerating and running: what a suite holds, what becomes a row, and that a kill changes nothing."""

import dataclasses
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helmbench.bench import pool as pools
from helmbench.bench import runner, store
from helmbench.bench.kinds.identification.problems import Task
from helmbench.bench.runner import RunSpec, Selection, execute, plan
from helmbench.bench.store import Store
from helmbench.bench.suites import load_suite
from helmbench.datasets.disturbances import parse_disturbance
from helmbench.methods.registry import methods
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import list_vessels, resolve

FIRST_FIVE = {"ls", "rls", "fw-rls", "ekf", "output-error"}
TASK = Task(
    vessel="response-1",
    source="response-1",
    model="nomoto-1-cubic",
    train=("zigzag:20/20",),
    held_out=("zigzag:15/15:port",),
    noise="low",
)
OWN_METHOD = """
from helmbench.methods.base import CannotFit, Fit, FitFailed, Method

class Mine(Method):
    name = "mine"
    title = "for tests"

    def __init__(self, outcome="good"):
        self.outcome = outcome

    def estimate(self, records, model):
        if self.outcome == "not-applicable":
            raise CannotFit("no sway in\\n the record")
        if self.outcome == "failed":
            raise FitFailed("singular")
        if self.outcome == "bug":
            return {}["missing"]
        import numpy as np
        return Fit(np.full(len(model.coordinates), -0.1))
"""


def spec_of(maker="ls", **changes):
    name = maker.split(",")[0]
    return RunSpec("test", name, "corrected", maker, dataclasses.replace(TASK, **changes))


def suite_file(folder, text):
    path = folder / "mine.yaml"
    path.write_text("title: mine\nentries:\n" + text)
    return load_suite(str(path))


@pytest.fixture
def own_method(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(OWN_METHOD)
    return f"{path}:Mine"


# enumerating


def test_quick_covers_every_vessel_and_the_first_five_methods():
    specs = plan(load_suite("quick"))
    pairs = {(spec.task.vessel, spec.method) for spec in specs if spec.task.source == spec.task.vessel}
    assert pairs >= {(vessel, method) for vessel in list_vessels() for method in FIRST_FIVE}


def test_quick_holds_one_euler_row_of_ls_for_every_vessel():
    specs = [spec for spec in plan(load_suite("quick")) if spec.row_key()["train"].endswith("@euler")]
    assert sorted(spec.task.vessel for spec in specs) == sorted(list_vessels())
    assert {(spec.method, spec.task.noise) for spec in specs} == {("ls", "none")}


def test_quick_holds_noise_free_rows_of_output_error_for_every_vessel():
    specs = [spec for spec in plan(load_suite("quick")) if (spec.method, spec.task.noise) == ("output-error", "none")]
    assert {spec.task.vessel for spec in specs} == set(list_vessels())


def test_default_crosses_every_vessel_with_every_method_and_noise_level():
    specs = plan(load_suite("default"))
    found = {(spec.task.vessel, spec.method, spec.task.noise) for spec in specs if spec.task.source == spec.task.vessel}
    levels = ("none", "low", "high")
    assert found >= {(v, m, n) for v in list_vessels() for m in methods() for n in levels}
    assert any(spec.task.disturbance != "none" for spec in specs)


def test_measured_has_a_row_for_every_model_and_held_out_run_and_the_integrator():
    specs = plan(load_suite("measured"))
    first, second = {"nomoto-1", "nomoto-1-cubic"}, {"kt", "nomoto-2", "nomoto-2-cubic", "nomoto-2-quadratic"}
    models = {"integrator", *first, *second}
    runs = {("Z_25_05",), ("Z_10_10_P",), ("Z_10_10_S",), ("Z_20_10_S",)}
    found = {(spec.task.model, spec.task.held_out) for spec in specs if spec.method in ("ls", "output-error")}
    assert found >= {(model, run) for model in models for run in runs}
    assert {run for _, run in found} == runs
    assert all(spec.task.train == ("Z_15_05",) and spec.task.measured for spec in specs)


def test_seeds_are_repeated_only_where_something_is_random(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls, noise: [none, low], seeds: 3}\n")
    assert [(s.task.noise, s.task.seed) for s in plan(suite)] == [("none", 0), ("low", 0), ("low", 1), ("low", 2)]
    fewer = plan(suite, Selection("mine", seeds=2))
    assert [(s.task.noise, s.task.seed) for s in fewer] == [("none", 0), ("low", 0), ("low", 1)]


@pytest.mark.parametrize("name", ["disturbances", "excitation", "noise", "outliers", "sampling"])
def test_the_suite_of_a_theme_varies_it_and_nothing_else(name):
    factors = {"noise": {"noise"}, "outliers": {"noise"}, "disturbances": {"disturbance"}}
    factors |= {"excitation": {"train"}, "sampling": {"thinning", "length"}}
    specs = plan(load_suite(name))
    assert {spec.method for spec in specs} >= set(methods())
    for vessel in {spec.task.vessel for spec in specs}:
        own = [spec.task for spec in specs if spec.task.vessel == vessel]
        fixed = {"source", "held_out", "noise", "disturbance", "train", "thinning", "length"}
        varied = {field for field in fixed if len({getattr(task, field) for task in own}) > 1}
        assert varied == factors[name]


@pytest.mark.parametrize("name", ["default", "disturbances"])
def test_every_vessel_can_meet_the_disturbances_of_its_suite(name):
    for task in {spec.task for spec in plan(load_suite(name)) if spec.task.disturbance != "none"}:
        parse_disturbance(task.disturbance).check(resolve(task.vessel))


def test_lists_of_manoeuvres_shares_and_thinnings_make_a_row_each(tmp_path):
    text = "vessels: response-1, methods: [ls], train: [[turn:20], [turn:10, turn:20]], thinning: [1, 4], length: 0.5"
    tasks = [spec.task for spec in plan(suite_file(tmp_path, "  - {" + text + "}\n"))]
    trains = [("turn:20",), ("turn:10", "turn:20")]
    assert [(t.train, t.thinning, t.length) for t in tasks] == [(m, k, 0.5) for m in trains for k in (1, 4)]


def test_a_method_asked_for_joins_open_entries_only(tmp_path, own_method):
    text = "  - {vessels: response-1, methods: [ls]"
    suite = suite_file(tmp_path, text + ", open: false, euler: true}\n" + text + "}\n")
    asked = plan(suite, Selection("mine", methods=("rls", own_method)))
    assert [(spec.method, spec.task.train[0][-6:]) for spec in asked] == [("rls", "g:5/10"), ("mine", "g:5/10")]
    assert len(plan(suite, Selection("mine", methods=("ls",)))) == 2


def test_options_are_part_of_a_methods_name_and_the_variant_has_its_column(tmp_path):
    text = "  - {vessels: response-1, methods: [ls, 'ls,scheme=midpoint', 'fw-rls,variant=as_printed']}\n"
    found = [(spec.method, spec.variant) for spec in plan(suite_file(tmp_path, text))]
    assert found == [("ls", "corrected"), ("ls,scheme=midpoint", "corrected"), ("fw-rls", "as_printed")]


def test_a_row_listed_twice_is_run_once(tmp_path):
    text = "  - {vessels: response-1, methods: ls}\n"
    assert len(plan(suite_file(tmp_path, text + text))) == 1


def test_different_runs_under_one_name_are_refused(tmp_path):
    text = "  - {vessels: response-1, methods: ls}\n  - {vessels: response-1, methods: ls, dt_s: 0.2}\n"
    with pytest.raises(BadInput, match="two different runs have the same row"):
        plan(suite_file(tmp_path, text))


@pytest.mark.parametrize(
    ("selection", "complaint"),
    [
        (Selection("quick", methods=("huber-nonsense",)), "unknown method 'huber-nonsense'"),
        (Selection("quick", vessels=("titanic",)), "has no vessel 'titanic'"),
    ],
)
def test_unknown_filters_are_refused(selection, complaint):
    with pytest.raises(BadInput, match=complaint):
        plan(load_suite("quick"), selection)


def test_filters_that_leave_nothing_are_refused(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: [ls], open: false}\n")
    with pytest.raises(BadInput, match="nothing to run"):
        plan(suite, Selection("mine", methods=("rls",)))


def test_keys_tell_every_difference_and_stay():
    base = spec_of()
    changes = {
        "vessel": "response-2", "source": "nomoto-1", "model": "nomoto-1", "train": ("turn:20",), "held_out": ("x",),
        "noise": "high", "disturbance": "waves:1/5@0", "seed": 1, "measured": True, "duration_s": 5.0, "dt_s": 0.2,
        "thinning": 4, "length": 0.5,
    }  # fmt: skip
    assert set(changes) == {field.name for field in dataclasses.fields(Task)}
    others = [spec_of(**{name: value}) for name, value in changes.items()]
    others += [dataclasses.replace(base, **{name: "x"}) for name in ("suite", "method", "variant", "maker")]
    assert len({spec.key for spec in [base, *others]}) == len(others) + 1
    assert base.key == "4b25ae8a5afd3105ab59"


# executing


def test_a_run_fills_the_columns_of_the_tables():
    run = execute(spec_of())
    row = run["row"]
    assert (row["status"], row["error"], row["diverged"], row["n_samples"]) == ("ok", None, False, 1001)
    assert set(row) <= set(store.RESULT_COLUMNS)
    assert row["r2_free_heading_rad"] > 0.99 and row["rmse_one_yaw_rate_rad_s"] < row["rmse_free_yaw_rate_rad_s"]
    assert row["rel_error_median"] <= row["rel_error_max"] and row["crb_z_rms"] > 1.0
    assert row["wall_s"] > 0 and row["cpu_s"] > 0 and 20 < row["peak_memory_mib"] < 4000
    assert [entry["parameter"] for entry in run["parameters"]] == ["T", "K", "alpha"]
    assert all(row.keys() | entry.keys() >= set(store.PARAMETER_COLUMNS) for entry in run["parameters"])
    assert json.loads(store._json(run))["key"] == spec_of().key


@pytest.mark.parametrize(
    ("outcome", "status", "error"),
    [
        ("good", "ok", None),
        ("not-applicable", "not_applicable", "no sway in the record"),
        ("failed", "failed", "singular"),
        ("bug", "failed", "KeyError: 'missing'"),
    ],
)
def test_whatever_a_method_does_becomes_a_row(own_method, outcome, status, error):
    run = execute(spec_of(f"{own_method},outcome={outcome}"))
    assert (run["row"]["status"], run["row"]["error"]) == (status, error)
    assert bool(run["parameters"]) == (status == "ok")


def test_a_record_that_cannot_be_made_becomes_a_row():
    run = execute(spec_of(disturbance="wind:10@0deg"))
    assert run["row"]["status"] == "failed" and "wind" in run["row"]["error"]


def test_methods_are_never_given_the_truth(monkeypatch):
    seen = []

    class Spy:
        def fit(self, records, model):
            seen.append(model.coefficients.copy())
            raise CannotFit("only looking")

    monkeypatch.setattr("helmbench.methods.registry.make", lambda *_: Spy())
    monkeypatch.setattr(runner, "_WARMED", set())
    execute(spec_of())
    assert len(seen) == 2 and all(np.isnan(coefficients).all() for coefficients in seen)


def test_a_fit_that_did_not_converge_says_so(monkeypatch):
    from helmbench.methods.registry import make

    class Tired:
        def fit(self, records, model):
            return dataclasses.replace(make("ls").fit(records, model), converged=False, message="ran out of steps")

    monkeypatch.setattr("helmbench.methods.registry.make", lambda *_: Tired())
    row = execute(spec_of())["row"]
    assert (row["status"], row["error"]) == ("ok", "not converged: ran out of steps")


def test_time_is_that_of_the_fit_alone(monkeypatch):
    class Slow:
        def fit(self, records, model):
            time.sleep(0.2)
            raise FitFailed("slept")

    monkeypatch.setattr("helmbench.methods.registry.make", lambda *_: Slow())
    row = execute(spec_of())["row"]
    assert 0.2 <= row["wall_s"] < 2.0 and row["cpu_s"] < 0.15


def test_peak_memory_sees_what_a_fit_allocates():
    before = runner.reset_peak_memory()()
    peak = runner.reset_peak_memory()
    np.ones(30_000_000).sum()  # 229 MiB
    assert before is not None and peak() - before > 200
    assert runner.reset_peak_memory()() < before + 100


def test_noise_free_euler_records_are_recovered_to_rounding():
    row = execute(spec_of(noise="none", train=("zigzag:20/20@euler",)))["row"]
    assert row["rel_error_max"] < 1e-10 and row["train"] == "zigzag:20/20@euler"


# keeping


def fake_execute(spec):
    """Deterministic apart from the measured columns."""
    row = spec.row_key() | {"status": "ok", "error": None, "diverged": False, "n_samples": 10}
    row |= {"rel_error_median": spec.task.seed / 7.0, "wall_s": time.perf_counter(), "cpu_s": time.process_time()}
    return {"key": spec.key, "row": row, "parameters": [{"parameter": "K", "estimate": 1.0 / (1 + spec.task.seed)}]}


class Killed(BaseException):
    """Stands in for a kill at any moment between two finished runs."""


def stored_tables(folder):
    frames = [pd.read_parquet(folder / name) for name in (store.RESULTS, store.PARAMETERS)]
    return [frame.drop(columns=[c for c in store.MEASURED_COLUMNS if c in frame]) for frame in frames]


def assert_same_tables(one, other):
    for left, right in zip(stored_tables(one), stored_tables(other), strict=True):
        pd.testing.assert_frame_equal(left, right, check_exact=True)


@settings(deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(stops=st.lists(st.integers(0, 6), max_size=3), torn=st.integers(0, 30))
def test_interrupted_runs_end_in_the_same_tables(tmp_path_factory, stops, torn):
    folder = tmp_path_factory.mktemp("store")
    suite = suite_file(folder, "  - {vessels: [response-1, remus-kt], methods: [ls, rls], noise: low, seeds: 3}\n")
    selection = Selection("mine")
    specs = plan(suite, selection)
    with pytest.MonkeyPatch.context() as patch, pools.inline() as pool:
        patch.setattr(runner, "execute", fake_execute)
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
                log = (folder / "broken" / store.RUNS).read_bytes()
                (folder / "broken" / store.RUNS).write_bytes(log[: len(log) - torn])
        with runner.resume_store(folder / "broken", suite, specs) as broken:
            runner.run(specs, broken, pool)
    assert_same_tables(folder / "whole", folder / "broken")


def test_finished_runs_are_not_run_again(tmp_path, monkeypatch):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: [ls, rls], noise: low, seeds: 2}\n")
    specs = plan(suite)
    ran = []
    monkeypatch.setattr(runner, "execute", lambda spec: ran.append(spec) or fake_execute(spec))
    with pools.inline() as pool:
        with runner.open_store(tmp_path / "out", suite, Selection("mine"), specs) as opened:
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
    specs = plan(suite)
    runner.open_store(tmp_path / "out", suite, Selection("mine"), specs).close()
    path = tmp_path / "out" / store.MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(BadInput, match=complaint):
        runner.resume_store(tmp_path / "out", suite, specs)
    Store.resume(tmp_path / "out").close()  # and it is not left locked


def test_the_manifest_says_what_was_run_with_what(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls, noise: low, seeds: 2}\n")
    specs = plan(suite)
    with runner.open_store(tmp_path / "out", suite, Selection("mine", seeds=2), specs) as opened:
        manifest = opened.manifest
    assert manifest["planned"] == 2 and manifest["seeds"] == [0, 1] and manifest["threads_per_worker"] == 1
    assert {"python", "platform", "cpu", "cpus", "packages", "version"} <= manifest.keys()
    assert json.loads((tmp_path / "out" / store.MANIFEST).read_text()) == json.loads(json.dumps(manifest))
    assert sys.prefix not in json.dumps(manifest)


def test_a_killed_run_resumed_gives_the_tables_of_an_unbroken_one(tmp_path):
    suite = tmp_path / "mine.yaml"
    suite.write_text(
        "entries:\n"
        "  - {vessels: [response-1, response-2, remus-kt], methods: [ls, ekf, output-error], noise: low, seeds: 2}\n"
    )
    command = [sys.executable, "-m", "helmbench", "run", "--suite", str(suite), "--jobs", "2", "--quiet", "-o"]
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    assert subprocess.run([*command, str(whole)], timeout=600).returncode == 0
    process = subprocess.Popen([*command, str(broken)])
    log = broken / store.RUNS
    end = time.monotonic() + 300
    while time.monotonic() < end and not (log.exists() and log.read_bytes().count(b"\n") >= 3):
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.wait()
    finished = log.read_bytes().count(b"\n")
    assert 3 <= finished < 18 and not (broken / store.RESULTS).exists()
    assert subprocess.run([*command, str(broken), "--resume"], timeout=600).returncode == 0
    assert log.read_bytes().count(b"\n") == 18
    assert_same_tables(whole, broken)
