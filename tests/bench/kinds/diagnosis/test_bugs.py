"""Base models with one wrong number, and what counts as naming it."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import VESSELS
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.bases import BUGS, base_model, bug_of
from helmbench.bench.kinds.diagnosis.execute import base_of, injected_of
from helmbench.bench.kinds.diagnosis.judge import OUTCOMES, judge_names
from helmbench.bench.kinds.diagnosis.plan import ONE_BUG, plan
from helmbench.bench.suites import load_suite
from helmbench.diagnosis.causes.registry import all_causes
from helmbench.models.coefficient_groups import groups_of
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

NAMES = [f"{bug.vessel}-{bug.id}" for bug in BUGS]


def test_there_are_bugs_of_several_ships_and_each_has_a_name_of_its_own():
    assert len(BUGS) >= 16 and len({bug.vessel for bug in BUGS} & set(VESSELS)) >= 4
    assert len(set(NAMES)) == len(BUGS)


@pytest.mark.parametrize("bug", BUGS, ids=NAMES)
def test_a_base_has_its_own_mistake_only_and_the_right_names_exist(bug, rng):
    true, base = resolve(bug.vessel), base_model(bug.id, bug.vessel, rng)
    known = {g.id for g in groups_of(true)} | set(all_causes())
    assert set(bug.right) <= known
    changed = {n for n, value in base.parameters.items() if value != pytest.approx(true.parameters[n], abs=1e-12)}
    changed |= {
        n for n, a, b in zip(true.constant_names, true.constants, base.constants, strict=True) if a != pytest.approx(b)
    }
    assert changed == bug.numbers


def free_run(model, true):
    """Surge, sway and yaw rate (N, k) of a run under two sines and a constant angle."""
    dt = 10.0 * true.max_step_s if true.is_3dof else 1.0
    t = dt * np.arange(400)
    rudder = 0.2 * np.sin(t / (20.0 * dt)) + 0.1 * np.sin(t / (7.0 * dt)) + 0.2 * (t > 200.0 * dt)
    columns = [true.states.index(name) for name in "uvr" if name in true.states]
    return simulate(model, inputs_of(model, rudder), dt, initial_state(true))[:, columns]


@pytest.mark.parametrize("bug", BUGS, ids=NAMES)
def test_a_mistake_shows_in_free_runs(bug):
    true = resolve(bug.vessel)
    right, wrong = (free_run(model, true) for model in (true, bug.base()))
    assert np.max(np.std(wrong - right, axis=0) / np.std(right, axis=0)) > 0.02


@pytest.mark.parametrize(
    ("findings", "outcome", "extra", "tie"),
    [
        (["inertia"], "alone", 0, 1),
        (["J_z"], "alone", 0, 1),
        (["inertia/hull_yaw_linear"], "tie", 0, 2),
        (["hull_yaw_linear", "inertia"], "among", 1, 1),
        (["wind/inertia", "wind"], "among", 1, 2),
        (["hull_yaw_linear"], "wrong_first", 1, None),
        (["base_coefficients"], "wrong_first", 1, None),
        ([], "missed", 0, None),
    ],
)
def test_a_wrong_number_is_named_alone_tied_or_among_others(diagnosis_of, findings, outcome, extra, tie):
    bug = bug_of("s175", "yaw-inertia")
    scored = judge_names(replace(diagnosis_of(*findings), model=bug.base()), frozenset(bug.right))
    assert scored["outcome"] == outcome in OUTCOMES
    assert (scored["extra_names"], scored["tie_size"]) == (extra, tie)
    assert scored["confident_wrong"] == any("/" not in name and name not in ("inertia", "J_z") for name in findings)


@pytest.mark.parametrize(
    ("details", "outcome"),
    [
        ({"groups": ["mass, added masses and yaw inertia"]}, "alone"),
        ({"groups": ["inertia"]}, "alone"),
        ({"groups": ["inertia", "resistance"]}, "among"),
        ({"groups": ["mass, added masses and yaw inertia"], "would do as well": ["hull yaw linear"]}, "tie"),
        ({"groups": ["mass, added masses and yaw inertia"], "would do as well": "inertia.J z"}, "alone"),
        ({}, "wrong_first"),
    ],
)
def test_groups_of_the_base_are_read_from_the_details(diagnosis_of, details, outcome):
    bug = bug_of("s175", "yaw-inertia")
    found = diagnosis_of("base_coefficients")
    told = replace(found, model=bug.base(), causes=(replace(found.causes[0], details=details),))
    assert judge_names(told, frozenset(bug.right))["outcome"] == outcome


def test_the_suite_has_every_bug_once_and_correct_bases(seed):
    specs = plan(load_suite("one-bug"), RunSelection("one-bug", seed=seed))
    bugs = [(spec.vessel, spec.base) for spec in specs if spec.group == ONE_BUG]
    assert bugs == [(bug.vessel, bug.id) for bug in BUGS]
    assert {spec.base for spec in specs if spec.group != ONE_BUG} == {"unstated"}
    case, base = injected_of(specs[0]), base_of(specs[0])
    assert (len(case.train), len(case.held_out), case.effects) == (5, 3, ())
    assert base.parameters == BUGS[0].base().parameters
