"""Numbers that are wrong in a part of the runs only, planted by the truth simulator."""

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.bench.kinds.diagnosis.execute import RECORDS
from helmbench.bench.kinds.diagnosis.judge import healthy_bias, regime_scores
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.model import model_to_json, resolve
from helmbench.models.simulate import initial_state, simulate
from helmbench.reporting.diagnosis.words import verdict

from ..expectations.injections import passes

TRAIN = {"train": RECORDS["five-steps"]["train"][:4], "held_out": ("turn:20",), "duration_s": 400.0, "dt_s": 1.0}


def diagnosed(vessel, effect, rng, base=None, **facts):
    case = inject(FaultCase(vessel, effects=(effect,) if effect else (), **(TRAIN | facts)), rng)
    return case, diagnose(base or resolve(vessel), case.train, case.held_out)


def stated(found):
    """The regime that a diagnosis states, and the finding that does."""
    ((finding, regime),) = [(f, f.details["regime"]) for f in found.causes if "regime" in f.details]
    return finding, regime


def test_a_rudder_that_loses_force_beyond_an_angle_is_located(rng, tmp_path):
    """Gusts hide it now and then: by a rudder that loses force at a time, and by all numbers together."""
    effect, outcomes = Effect("rudder_force_loss", {"loss": 0.2, "angle": 0.23}), []

    def located():
        case, found = diagnosed("cargo", effect, rng)
        regimes = [f for f in found.causes if "regime" in f.details]
        if len(regimes) != 1 or len(regimes[0].sizes) != 1:
            return False
        regime, (size,) = regimes[0].details["regime"], regimes[0].sizes
        where = regime["variable"], regime["side"], regime["group"]
        right = (
            where == ("rudder", "above", "turning_gain")
            and regime["low"] < regime["threshold"] < regime["high"]
            and abs(regime["threshold"] - 0.23) < 0.06  # the rudder moves .04 rad a sample
            and abs(size.value + 0.2) < 0.06
            and size.low < size.value < size.high
            and regime_scores(found, case)["regime_f1"] > 0.8
            and found.gain["heading_rad"].rmse_after < 0.5 * found.gain["heading_rad"].rmse_before
            and healthy_bias(found, resolve("cargo"), frozenset({"turning_gain"})) < 0.1
        )
        outcomes.extend([(found, regime, size)] if right else [])
        return right

    assert passes(located, 0.6)
    found, regime, size = outcomes[-1]
    assert f"{100 * size.value:+.0f} % beyond {np.rad2deg(regime['threshold']):.3g} deg of rudder" in verdict(found)
    model_to_json(found.extended, tmp_path / "extended.json")
    inputs, start = np.full((100, 1), 0.3), initial_state(found.extended)
    runs = [simulate(m, inputs, 1.0, start) for m in (found.extended, resolve(tmp_path / "extended.json"))]
    assert np.array_equal(*runs)


@pytest.mark.nightly
def test_a_wake_that_is_wrong_in_turns_goes_before_numbers_that_are_all_a_little_off(rng):
    def located():
        _, found = diagnosed("s175", Effect("wake_loss", {"loss": 0.25, "drift": 0.1}), rng)
        print(found.verdict, found.causes)
        return {f.details["regime"]["variable"] for f in found.causes if "regime" in f.details} == {"drift"}

    assert passes(located, 0.7)


@pytest.mark.nightly
def test_a_number_that_is_wrong_everywhere_has_no_regime(rng):
    base = resolve("cargo")
    wrong = base.with_coefficients(base.coefficients * np.array([1.0, 1.0, 0.85, 1.0]))
    _, found = diagnosed("cargo", None, rng, base=wrong)
    assert found.causes and not any("regime" in f.details for f in found.causes)


@pytest.mark.nightly
def test_a_sensor_that_is_cut_off_is_told_and_its_samples_left_out(rng):
    effect = Effect("yaw_rate_saturation", {"limit": 0.008})
    case, found = diagnosed("cargo", effect, rng)
    finding, regime = stated(found)
    assert finding.cause == "yaw_rate_saturation" and regime["threshold"] == 0.008
    assert regime_scores(found, case)["regime_f1"] == 1.0
    assert found.checks[0].cause == "yaw_rate_saturation" and found.checks[0].corrected
