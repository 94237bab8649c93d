"""Enumerating: what an identification suite holds."""

import dataclasses

import pytest

from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.kinds.identification.problems import Task
from helmbench.bench.suites import load_suite, suite_names
from helmbench.datasets.disturbances import parse_disturbance
from helmbench.datasets.measured_sets import DATASETS
from helmbench.methods.registry import methods
from helmbench.models.errors import BadInput
from helmbench.models.model import list_vessels, resolve

from ....made_up.suites import own_method_file, spec_of, suite_file

FAMILIES = {
    *("ls", "rls", "fw-rls", "fci-ls", "mi-rls", "nmi-rls", "ekf", "ls-svr", "output-error"),
    *("eso-rw-lssvr", "tuned:eso-rw-lssvr"),
}
"""Methods of the papers and what they are compared with."""
SECONDS = [name for name, cls in methods().items() if not cls.minutes]


def planned(name):
    return plan(load_suite(name), RunSelection(name))


@pytest.fixture
def own_method(tmp_path):
    return own_method_file(tmp_path)


def test_methods_of_the_class_of_minutes_are_in_the_suite_of_minutes_only():
    slow = methods().keys() - SECONDS
    assert slow == {"cma-es", "lstm", "mcmc", "moving-horizon", "pinn"}
    minutes, default = ({s.method.partition(",")[0] for s in plan(load_suite(name))} for name in ("minutes", "default"))
    assert slow <= minutes and not slow & default


def test_quick_compares_every_family_on_every_problem_of_every_vessel():
    specs = planned("quick")
    tasks = {spec.task for spec in specs}
    assert {spec.method for spec in specs} == FAMILIES and len(specs) == len(tasks) * len(FAMILIES)
    assert {task.vessel for task in tasks} == set(list_vessels())


def test_quick_has_noisy_zigzags_and_sines_and_outliers_and_no_method_that_does_not_apply():
    tasks = {spec.task for spec in planned("quick")}
    for task in tasks:
        records = " ".join(task.train + task.held_out)
        assert task.noise != "none" and ("sine" in records or "heading" in records)
        assert ("zigzag" in records) == (task.vessel != "remus")  # which is unstable: it cannot zigzag
    assert {task.vessel for task in tasks if "outliers" in task.noise} == {
        vessel for vessel in list_vessels() if not resolve(vessel).is_3dof
    }
    assert not any(resolve(task.source).is_3dof for task in tasks)


def test_default_crosses_every_vessel_but_the_scaled_one_with_every_method_and_noise_level():
    specs = planned("default")
    found = {(spec.task.vessel, spec.method, spec.task.noise) for spec in specs if spec.task.source == spec.task.vessel}
    ships = set(list_vessels()) - {"mariner-model"}
    assert found >= {(v, m, n) for v in ships for m in SECONDS for n in ("low", "high")}


IDENTIFICATION_SUITES = [name for name in suite_names() if load_suite(name).kind == "identification"]


@pytest.mark.parametrize("name", IDENTIFICATION_SUITES)
def test_a_choice_never_compares_different_sets_of_methods(name):
    """All problems of a suite in which methods are compared have the same ones."""
    problems = {}
    for spec in planned(name):
        row = spec.row_key()
        key = tuple(value for column, value in row.items() if column not in ("method", "variant", "seed"))
        problems.setdefault(key, set()).add(spec.method)
    assert len({frozenset(own) for own in problems.values() if len(own) > 1}) == 1


def test_measured_has_every_method_on_every_set():
    specs = planned("measured")
    assert {spec.task.vessel for spec in specs} >= set(DATASETS)
    found = {(spec.task.vessel, spec.method) for spec in specs}
    assert found >= {(name, method) for name in DATASETS for method in SECONDS}
    assert all(spec.task.measured and not set(spec.task.train) & set(spec.task.held_out) for spec in specs)


def test_conditions_of_measured_records_are_as_measured_and_only_channels_are_taken_away():
    rows = [(spec.task, spec.row_key()) for spec in planned("channels")]
    measured = {(row["noise"], row["disturbance"]) for task, row in rows if task.measured}
    assert measured >= {("as measured", "as measured"), ("as measured,only=heading", "as measured")}
    assert not {text for pair in measured for text in pair if text.startswith("none")}
    assert all((row["noise"], row["disturbance"]) == (task.noise, "none") for task, row in rows if not task.measured)


def test_an_optional_entry_is_left_out_where_its_records_are_missing(tmp_path):
    entry = "  - {records: {train: [no.csv], held_out: [none.csv]}, models: nomoto-1, methods: ls, optional: true}\n"
    suite = suite_file(tmp_path, entry + "  - {vessels: response-1, methods: ls}\n")
    assert [spec.task.vessel for spec in plan(suite, RunSelection("mine"))] == ["response-1"]


def test_response_models_has_a_row_for_every_model_and_held_out_run_and_the_integrator():
    specs = planned("response-models")
    first, second = {"nomoto-1", "nomoto-1-cubic"}, {"kt", "nomoto-2", "nomoto-2-cubic", "nomoto-2-quadratic"}
    models = {"integrator", *first, *second}
    runs = {("Z_25_05",), ("Z_10_10_P",), ("Z_10_10_S",), ("Z_20_10_S",)}
    found = {(spec.task.model, spec.task.held_out) for spec in specs if spec.method in ("ls", "output-error")}
    assert found >= {(model, run) for model in models for run in runs}
    assert {run for _, run in found} == runs
    assert all(spec.task.train == ("Z_15_05",) and spec.task.measured for spec in specs)


def test_seeds_are_repeated_only_where_something_is_random(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls, noise: [none, low], seeds: 3}\n")
    assert [(s.task.noise, s.task.seed) for s in plan(suite, RunSelection("mine"))] == [
        ("none", 0),
        ("low", 0),
        ("low", 1),
        ("low", 2),
    ]
    fewer = plan(suite, RunSelection("mine", seeds=2))
    assert [(s.task.noise, s.task.seed) for s in fewer] == [("none", 0), ("low", 0), ("low", 1)]


@pytest.mark.parametrize("name", ["disturbances", "excitation", "noise", "outliers", "sampling"])
def test_the_suite_of_a_theme_varies_it_and_nothing_else(name):
    factors = {"noise": {"noise"}, "outliers": {"noise"}, "disturbances": {"disturbance"}}
    factors |= {"excitation": {"train"}, "sampling": {"thinning", "length"}}
    specs = planned(name)
    assert {spec.method for spec in specs} >= {name for name in SECONDS if methods()[name].kind == "grey box"}
    for vessel in {spec.task.vessel for spec in specs}:
        own = [spec.task for spec in specs if spec.task.vessel == vessel]
        fixed = {"source", "held_out", "noise", "disturbance", "train", "thinning", "length"}
        varied = {field for field in fixed if len({getattr(task, field) for task in own}) > 1}
        assert varied == factors[name]


def test_every_vessel_can_meet_the_disturbances_of_its_suite():
    for task in {spec.task for spec in planned("disturbances") if spec.task.disturbance != "none"}:
        parse_disturbance(task.disturbance).check(resolve(task.vessel))


def test_lists_of_manoeuvres_shares_and_thinnings_make_a_row_each(tmp_path):
    text = "vessels: response-1, methods: [ls], train: [[turn:20], [turn:10, turn:20]], thinning: [1, 4], length: 0.5"
    tasks = [spec.task for spec in plan(suite_file(tmp_path, "  - {" + text + "}\n"), RunSelection("mine"))]
    trains = [("turn:20",), ("turn:10", "turn:20")]
    assert [(t.train, t.thinning, t.length) for t in tasks] == [(m, k, 0.5) for m in trains for k in (1, 4)]


def test_a_method_asked_for_joins_open_entries_only(tmp_path, own_method):
    text = "  - {vessels: response-1, methods: [ls]"
    suite = suite_file(tmp_path, text + ", open: false, euler: true}\n" + text + "}\n")
    asked = plan(suite, RunSelection("mine", methods=("rls", own_method)))
    assert [(spec.method, spec.task.train[0][-6:]) for spec in asked] == [("rls", "g:5/10"), ("mine", "g:5/10")]
    assert len(plan(suite, RunSelection("mine", methods=("ls",)))) == 2


def test_options_are_part_of_a_methods_name_and_the_variant_has_its_column(tmp_path):
    text = "  - {vessels: response-1, methods: [ls, 'ls,scheme=midpoint', 'fw-rls,variant=as_printed']}\n"
    found = [(spec.method, spec.variant) for spec in plan(suite_file(tmp_path, text), RunSelection("mine"))]
    assert found == [("ls", "corrected"), ("ls,scheme=midpoint", "corrected"), ("fw-rls", "as_printed")]


def test_a_row_listed_twice_is_run_once(tmp_path):
    text = "  - {vessels: response-1, methods: ls}\n"
    assert len(plan(suite_file(tmp_path, text + text), RunSelection("mine"))) == 1


def test_different_runs_under_one_name_are_refused(tmp_path):
    text = "  - {vessels: response-1, methods: ls}\n  - {vessels: response-1, methods: ls, dt_s: 0.2}\n"
    with pytest.raises(BadInput, match="two different runs have the same row"):
        plan(suite_file(tmp_path, text), RunSelection("mine"))


@pytest.mark.parametrize(
    ("selection", "complaint"),
    [
        (RunSelection("quick", methods=("huber-nonsense",)), "unknown method 'huber-nonsense'"),
        (RunSelection("quick", vessels=("titanic",)), "has no vessel 'titanic'"),
    ],
)
def test_unknown_filters_are_refused(selection, complaint):
    with pytest.raises(BadInput, match=complaint):
        plan(load_suite("quick"), selection)


def test_filters_that_leave_nothing_are_refused(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: [ls], open: false}\n")
    with pytest.raises(BadInput, match="nothing to run"):
        plan(suite, RunSelection("mine", methods=("rls",)))


def test_keys_tell_every_difference_and_stay():
    base = spec_of()
    changes = {
        "vessel": "response-2", "source": "nomoto-1", "model": "nomoto-1", "train": ("turn:20",), "held_out": ("x",),
        "noise": "high", "disturbance": "waves:1/5@0", "seed": 1, "measured": True, "duration_s": 5.0, "dt_s": 0.2,
        "thinning": 4, "length": 0.5, "held_out_noise": "high", "held_out_disturbance": "wind:5@0",
        "held_out_speed": 0.7, "held_out_dataset": "kvlcc2-marin",
            "vessel_file": "ferry.yaml", "own_records": True, "positive_rudder": "port",
            "digest": "a1", "constants": (("f_alpha", 1.2),), "terms": (("current", (("current_north", 0.2),)),),
    }  # fmt: skip
    assert set(changes) == {field.name for field in dataclasses.fields(Task)}
    others = [spec_of(**{name: value}) for name, value in changes.items()]
    others += [dataclasses.replace(base, **{name: "x"}) for name in ("suite", "method", "variant", "maker")]
    assert len({spec.key for spec in [base, *others]}) == len(others) + 1
    assert base.key == "6fcce629e7883e068506"


def test_generalise_trains_on_zigzags_and_predicts_something_else():
    specs = planned("generalise")
    tasks = {spec.task for spec in specs}
    assert all("zigzag" in text or text.startswith("Z_") for task in tasks for text in task.train)
    assert not any(
        set(task.train) & set(task.held_out) and task.held_out_text == "+".join(task.held_out) for task in tasks
    )
    assert len({spec.method for spec in specs if methods()[spec.method].kind != "grey box"}) >= 12
    texts = " ".join(task.held_out_text for task in tasks)
    for condition in ("set kvlcc2-marin", "noise high", "in wind:8@40deg", "start speed 0.7", "turn:35", "zigzag:5/5"):
        assert condition in texts
    for task in {task for task in tasks if task.held_out_disturbance != "none"}:
        parse_disturbance(task.held_out_disturbance).check(resolve(task.vessel))


def test_conditions_of_held_out_records_need_the_right_entry(tmp_path):
    for text, words in (
        ("dataset: kvlcc2-hsva, train: [[a]], held_out: [[b]], held_out_speed: 0.5", "as they were measured"),
        ("vessels: mariner, held_out_dataset: kvlcc2-marin", "needs a dataset"),
    ):
        with pytest.raises(BadInput, match=words):
            plan(suite_file(tmp_path, "  - {" + text + "}\n"), RunSelection("mine"))


def test_groups_of_methods_are_those_of_their_kind(tmp_path):
    specs = plan(suite_file(tmp_path, "  - {vessels: response-1, methods: [identification]}\n"), RunSelection("mine"))
    assert {methods()[spec.method].kind for spec in specs} == {"grey box"}
