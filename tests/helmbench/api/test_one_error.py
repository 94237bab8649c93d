"""The same model and record have the same free-run error by every command."""

import numpy as np
import pytest

from helmbench import build_model
from helmbench.bench.kinds.identification.problems import FitTask, Truth
from helmbench.bench.scores.base import Outcome
from helmbench.bench.scores.prediction_error import prediction_error
from helmbench.bench.traces import free_run_trace
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.measured import data_dir, load
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.diagnosis.craft.result import BUILT
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.diagnosis.registry import find
from helmbench.estimation.estimates.assessment import assess, scores
from helmbench.estimation.estimates.estimate import Estimate
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.estimation.validation.validate import validate
from helmbench.models.model import resolve

from ...nightly_marks import nightly_but

CLOSE = 1e-9
SHIPS = {
    "response-1": ("response-1", 1.0, 300.0),
    "mariner": ("mariner", 2.0, 300.0),
    "kvlcc2-l7": ("kvlcc2-l7", 0.4, 120.0),
}
"""Simulated, with noise: name -> vessel, step and duration, s."""
MEASURED = {
    "hsva": ("kvlcc2-l7", "kvlcc2-hsva", ("Z_15_05", "Z_20_05"), 40, "kvlcc2/hsva"),
    "esso-osaka": (
        "esso-osaka-l3", "esso-osaka", ("zigzag_31-Jul-2020_13_42_53", "zigzag_31-Jul-2020_14_10_05"), 10, "esso_osaka",
    ),
}  # fmt: skip
"""Measured: name -> base model, set, training and held-out record, every which sample, folder."""


@pytest.fixture(scope="module", params=[*SHIPS, *MEASURED])
def case(request):
    """Base model, training record and held-out record."""
    if request.param in MEASURED:
        vessel, name, stems, every, folder = MEASURED[request.param]
        if not (data_dir() / folder).is_dir():
            pytest.skip(f"no measured data in {data_dir() / folder}: set HELMBENCH_DATA")
        return resolve(vessel), *(load(name, stem).thinned(every) for stem in stems)
    vessel, step, duration = SHIPS[request.param]
    own = {"duration_s": duration, "dt_s": step}
    wrong = resolve(vessel)
    wrong = wrong.with_coefficients(wrong.coefficients * 1.05)
    return wrong, *(generate(Case(vessel, f"zigzag:{a}/{a}", "low", seed=a, **own)) for a in (20, 10))


@pytest.fixture(scope="module")
def expected(case):
    """Channel -> error by `validate`."""
    model, _, held_out = case
    found = validate({"base": model}, {held_out.name: held_out}, ahead=False)
    return {c: found.score(c).rmse for c in found.runs[0].predicted}


def same(found, expected):
    """Whether errors are those expected, of two channels at least."""
    assert len(found) >= 2 and set(found) <= set(expected)
    assert found == pytest.approx({channel: expected[channel] for channel in found}, rel=CLOSE)


def estimate_of(model):
    """A known model in the place of an estimate."""
    return Estimate("known", "", model, model.coefficients, None, {}, {})


def free(told):
    """The free-run errors among scores."""
    return {name.removeprefix("rmse_free_"): value for name, value in told.items() if name.startswith("rmse_free_")}


def test_identify_and_estimates(case, expected):
    model, train, held_out = case
    estimate = estimate_of(model)
    same(free(scores(assess(estimate, [train], [held_out]).held_out)), expected)
    same(free(estimate.score(held_out)), expected)
    drawn = estimate.simulate(held_out)
    for channel in expected:
        error = drawn.continuous(channel) - held_out.turned(model.positive_rudder).continuous(channel)
        assert np.sqrt(np.nanmean(error**2)) == pytest.approx(expected[channel], rel=CLOSE)


def test_the_board(case, expected):
    model, train, held_out = case
    problem = FitTask(model.blanked(), (train,), (held_out,), Truth())
    prediction = prediction_scores(model, problem.held_out)
    same(free(prediction_error.compute(Outcome(problem, estimate_of(model), [], prediction))), expected)
    drawn = free_run_trace(estimate_of(model), held_out.slice(0, 60))["channels"]  # not thinned
    short = validate({"base": model}, {"short": held_out.slice(0, 60)}, ahead=False)
    for channel, curves in drawn.items():
        error = np.subtract(*(np.array(curves[side], float) for side in ("measured", "predicted")))
        assert np.sqrt(np.nanmean(error**2)) == pytest.approx(short.score(channel).rmse, rel=1e-2)  # of five digits


@pytest.mark.parametrize("case", nightly_but([*SHIPS, *MEASURED], "response-1", "mariner", "hsva"), indirect=True)
def test_diagnose_and_its_baselines(case, expected):
    model, train, held_out = case
    options = Options(coefficient_sd=0.0, max_effects=1, only=("rudder_offset",))
    diagnosers = (lambda *given: diagnose(*given), lambda *given: find("nothing")().diagnose(*given))
    for one in diagnosers:
        found = one(model, [train], [held_out], options)
        same({channel: gain.rmse_before for channel, gain in found.gain.items()}, expected)
        extended = validate({"extended": found.extended}, {"": held_out}, ahead=False)
        same({c: g.rmse_after for c, g in found.gain.items()}, {c: extended.score(c).rmse for c in expected})


@pytest.mark.parametrize("case", nightly_but([*SHIPS, *MEASURED], "response-1"), indirect=True)
def test_calibrate(case, expected):
    model, train, held_out = case
    found = calibrate(model, [train], [held_out])
    same({channel: pair[1] for channel, pair in found.before.items() if channel in expected}, expected)
    for moved, told in ((found.extended, found.after), (found.calibrated, found.predicted)):
        errors = validate({"moved": moved}, {"": held_out}, ahead=False)
        for channel in (c for c in told if c in expected):
            assert told[channel][1] == pytest.approx(errors.score(channel).rmse, rel=1e-6)


def test_a_model_that_is_built_from_records():
    step = {"duration_s": 300.0, "dt_s": 1.0}
    train, held_out = (generate(Case("response-1", f"zigzag:{a}/{a}", "low", seed=a, **step)) for a in (20, 10))
    found = build_model(train, held_out)
    errors = free(prediction_scores(found.model, [held_out]))
    same({c: found.ahead.score(c, BUILT).rmse for c in errors}, errors)
