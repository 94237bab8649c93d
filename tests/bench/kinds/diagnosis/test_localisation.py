"""Where an effect acts, as a diagnosis says it, and numbers that it moves although they are right."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject, kind_of, names_of
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.execute import injected_of, right_names
from helmbench.bench.kinds.diagnosis.judge import healthy_bias, regime_scores
from helmbench.bench.kinds.diagnosis.plan import REGIME, plan
from helmbench.bench.suites import load_suite
from helmbench.models.model import resolve

ANGLE = 0.24


@pytest.fixture(scope="module")
def case():
    """A rudder that loses half its force beyond an angle."""
    effect = Effect("rudder_force_loss", {"loss": 0.5, "angle": ANGLE})
    facts = {"duration_s": 80.0, "train": ("zigzag:20/20", "steps:30deg/8s"), "held_out": ("turn:20",)}
    return inject(FaultCase("kvlcc2-l7", effects=(effect,), **facts), np.random.default_rng(1))


def told(diagnosis_of, *regimes):
    """A diagnosis that states regimes, one in each finding."""
    found = diagnosis_of(*["rudder_force"] * len(regimes))
    causes = [replace(f, details={"regime": one}) for f, one in zip(found.causes, regimes, strict=True)]
    return replace(found, causes=tuple(causes))


def of(variable, side, threshold):
    return {"variable": variable, "side": side, "threshold": threshold, "low": threshold, "high": threshold}


def test_the_right_regime_scores_one_a_near_one_less_and_none_nothing(diagnosis_of, case):
    above = [of("rudder", "above", angle) for angle in (ANGLE, ANGLE + 0.05)]
    right, near = (regime_scores(told(diagnosis_of, one), case)["regime_f1"] for one in above)
    assert right == 1.0 and 0.5 < near < 1.0
    silent = regime_scores(diagnosis_of("rudder_force"), case)
    assert (silent["regime_f1"], silent["regime_named"]) == (0.0, "")
    assert silent["regime_true"] == "rudder above 0.24"


def test_one_side_of_a_rudder_that_stalls_on_both_is_half_right(diagnosis_of, case):
    one = regime_scores(told(diagnosis_of, of("rudder", "port", ANGLE)), case)["regime_f1"]
    both = [of("rudder", side, ANGLE) for side in ("port", "starboard")]
    assert 0.4 < one < 0.9
    assert regime_scores(told(diagnosis_of, *both), case)["regime_f1"] == 1.0


def test_a_case_without_a_regime_has_no_score(diagnosis_of):
    clean = inject(FaultCase("cargo", duration_s=60.0), np.random.default_rng(0))
    scores = regime_scores(told(diagnosis_of, of("speed", "below", 3.0)), clean)
    assert scores == {"regime_true": "", "regime_named": "speed below 3", "regime_f1": None}


def test_numbers_that_are_right_and_move_count_in_prior_standard_deviations(diagnosis_of):
    true = resolve("kvlcc2-l7")
    values = true.coefficients.copy()
    values[true.coordinates.index("N_r")] *= 1.2  # one prior standard deviation
    moved = replace(diagnosis_of(), extended=true.with_coefficients(values))
    assert healthy_bias(replace(moved, extended=true), true, frozenset()) == 0.0
    assert 0.1 < healthy_bias(moved, true, frozenset()) < 0.3
    assert (
        healthy_bias(moved, true, frozenset({"N_r"}))
        == 0.0
        == healthy_bias(moved, true, frozenset({"hull_yaw_linear"}))
    )


def test_the_suite_draws_sixty_faults_in_regimes(seed):
    specs = plan(load_suite("regimes"), RunSelection("regimes", seed=seed))
    assert len(specs) >= 60 and {spec.injected[0] for spec in specs} == set(names_of(REGIME))
    assert all(kind_of(spec.injected[0]).regime for spec in specs)
    right, wrong = right_names(specs[0])
    assert "rudder_force" in right and not wrong
    first = injected_of(specs[0])
    assert len(first.train) == 5 and first.effects == injected_of(specs[0]).effects
