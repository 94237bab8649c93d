"""The measured suite against the figures of an independent evaluation (train on HSVA 15/5, predict the others)."""

import pytest

from helmbench.bench.kinds.identification.problems import Task, problem
from helmbench.datasets.measured import data_dir
from helmbench.estimation.records.series import series_of
from helmbench.estimation.results.predictor import ModelPredictor
from helmbench.estimation.run.squares import squares
from helmbench.methods.registry import make

HELD_OUT = ("Z_25_05", "Z_10_10_P", "Z_10_10_S")
# method, model: R^2 of the yaw rate, RMSE of the yaw rate (deg/s) and of the heading (deg) in free run
PUBLISHED = {
    ("ls-forward", "nomoto-1-cubic"): [(0.963, 0.38, 3.2), (0.822, 0.51, 6.5), (0.749, 0.61, 9.6)],
    ("output-error", "integrator"): [(0.680, 1.12, 20.5), (0.890, 0.40, 3.6), (0.864, 0.45, 9.2)],
    ("output-error", "nomoto-1-cubic"): [(0.953, 0.43, 2.9), (0.891, 0.40, 5.0), (0.837, 0.49, 8.0)],
    ("output-error", "nomoto-2"): [(0.977, 0.30, 12.0), (0.964, 0.23, 5.0), (0.937, 0.31, 10.7)],
}


@pytest.fixture(autouse=True)
def data():
    folder = data_dir() / "kvlcc2" / "hsva"
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")


def fitted(method, model):
    known = problem(Task("kvlcc2-hsva", model, model, ("Z_15_05",), HELD_OUT, measured=True))
    return make(method).fit(list(known.train), known.model), known.held_out


def from_the_first_sample(model, record):
    """R^2 and error of the yaw rate, error of the heading: started as in that evaluation, in the first sample."""
    series = series_of(record.turned(model.positive_rudder), model)
    states = series.observe(ModelPredictor(model).simulate(series.inputs, series.dt, series.start))
    found = {
        model.states[state]: squares(series.outputs[:, place], states[:, state]).scores()
        for place, state in enumerate(series.columns)
    }
    return found["r"][1], found["r"][0], found["psi"][0]


@pytest.mark.parametrize(("method", "model"), PUBLISHED)
def test_free_runs_score_as_published(method, model):
    estimate, held_out = fitted(method, model)
    for record, (r2, rate, heading) in zip(held_out, PUBLISHED[method, model], strict=True):
        found = from_the_first_sample(estimate.model, record)
        assert found[0] == pytest.approx(r2, abs=0.01)
        assert found[1] * 57.29578 == pytest.approx(rate, abs=0.02)
        assert found[2] * 57.29578 == pytest.approx(heading, abs=0.3)


def test_first_order_least_squares_gives_the_published_parameters():
    estimate, _ = fitted("ls-forward", "nomoto-1-cubic")
    assert estimate.parameters == pytest.approx({"K": 0.3239, "T": 20.12, "alpha": 213.0}, rel=0.01)
