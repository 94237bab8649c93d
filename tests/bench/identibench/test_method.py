"""identibench runs helmbench's methods: on its ship set, with its own tasks and scores."""

from dataclasses import replace

import identibench
import numpy as np
import pytest
from identibench.metrics import rmse

import helmbench
from helmbench.bench.identibench.columns import SHIP_INPUTS, SHIP_OUTPUTS
from helmbench.models.errors import BadInput

from .ship_files import columns_of, write_ship

MOTION = ["u", "v", "r"]
WINDOW = 100


@pytest.fixture(scope="module", params=[1.0, -1.0])
def sign(request):
    """How the wind's angle is counted."""
    return request.param


@pytest.fixture(scope="module")
def root(tmp_path_factory, sign):
    return write_ship(tmp_path_factory.mktemp("data"), sign)


@pytest.fixture(scope="module")
def run(tmp_path_factory, sign):
    """A run of the ship that is not among the files: inputs and outputs."""
    columns = columns_of(helmbench.simulate("mariner", "zigzag:25/15", dt_s=1.0, duration_s=400.0), sign=sign)
    return [np.column_stack([columns[name] for name in names]) for names in (SHIP_INPUTS, SHIP_OUTPUTS)]


def fitted(root, method, model, y_cols=SHIP_OUTPUTS, **hyperparameters):
    spec = replace(identibench.BenchmarkShip_Simulation, y_cols=list(y_cols))
    with identibench.data_root(root):
        context = identibench.TrainingContext(spec, hyperparameters, seed=3)
        return helmbench.identibench_model(method, model)(context)


def spread(root, part):
    """Standard deviation of each column of motion over the files of a part, mean over the columns."""
    spec = replace(identibench.BenchmarkShip_Simulation, y_cols=MOTION)
    with identibench.data_root(root):
        files = spec.resolve([(spec.datasets[0], f"{part}/*.hdf5")])
        context = identibench.TrainingContext(replace(spec, train=[(spec.datasets[0], f"{part}/*.hdf5")]), {})
        return len(files), np.mean([sequence.y.std(axis=0) for sequence in context.get_train_sequences()])


@pytest.mark.parametrize("task", ["Simulation", "Prediction"])
def test_identibench_scores_a_method_that_knows_the_equations(root, task):
    spec = replace(getattr(identibench, f"BenchmarkShip_{task}"), y_cols=MOTION)
    with identibench.data_root(root):
        found = identibench.run_benchmark(spec, helmbench.identibench_model("output-error", "mariner"), seed=1)
    assert found["benchmark_type"] == task and found["metric_name"] == "rmse"
    for name, part in (("test", "test"), ("ood", "test_ood")):
        assert found["test_sets"][name]["rmse"] < 0.01 * spread(root, part)[1]


@pytest.mark.nightly
def test_every_kind_of_method_predicts_all_columns(root, run):
    u, y = run
    for method in ("ls", "arx", "straight-line", "grey-residual"):
        model = fitted(root, method, "nomoto-1-cubic")
        predicted = model(u, y[:WINDOW], {})
        assert predicted.shape == y.shape and np.isfinite(predicted).all(), method
        assert set(model.held) == {"u", "v", "p", "phi"}
        held = [SHIP_OUTPUTS.index(name) for name in model.held]
        assert np.allclose(predicted[:, held], y[:WINDOW, held].mean(axis=0))


def test_a_run_starts_from_the_end_of_the_window(root, run):
    """A model that is wrong is still right one sample after the window, and not later; within it nothing is copied."""
    u, y = run
    r = SHIP_OUTPUTS.index("r")
    window = 150
    predicted = fitted(root, "ls", "nomoto-1-cubic")(u, y[:window], {})
    error = np.abs(predicted[:, r] - y[:, r]) / y[:, r].std()
    assert error[window] < 0.05 and error[window:].max() > 0.1
    assert error[1:window].max() > 0.05
    short = fitted(root, "ls", "nomoto-1-cubic")(u, y[:1], {})
    assert np.isfinite(short).all() and short[0, r] == pytest.approx(y[0, r], abs=1e-9)


def test_no_sample_after_the_window_is_used(root, run, rng):
    u, y = run
    model = fitted(root, "ls", "mariner")
    known = model(u, y[:WINDOW], {})
    assert np.array_equal(model(u[:200], y[:WINDOW], {}), known[:200])
    noisy = y[:WINDOW] + 0.01 * y[:WINDOW].std(axis=0) * rng.standard_normal((WINDOW, y.shape[1]))
    assert not np.isclose(model(u, noisy, {})[1:WINDOW, 2:5], noisy[1:, 2:5], rtol=1e-9, atol=0.0).all(axis=1).any()


def test_the_angle_of_the_wind_turns_with_the_ship(root, run, sign):
    u, y = run
    model = fitted(root, "output-error", "mariner")
    assert model.turn == -sign and set(model.held) == {"p", "phi"}
    wind = model(u, y[:WINDOW], {})[:, :2]
    assert np.abs(y[WINDOW:, :2] - y[WINDOW - 1, :2]).max() > 0.2
    assert np.abs(wind - y[:, :2]).max() < 0.02


def test_hyperparameters_are_options_and_the_seed_is_the_benchmarks(root):
    forest = helmbench.make_method("random-forest")
    estimate = fitted(root, forest, "nomoto-1", ["r"], min_samples_leaf=7).estimate
    own = helmbench.make_method("random-forest", min_samples_leaf=7, seed=3)
    with identibench.data_root(root):
        spec = replace(identibench.BenchmarkShip_Simulation, y_cols=["r"])
        again = helmbench.identibench_model(own, "nomoto-1")(identibench.TrainingContext(spec, {}, seed=3)).estimate
    inputs = np.linspace(-0.3, 0.3, 50)[:, None]
    runs = [one.predictor.simulate(inputs, 1.0, np.zeros(2)) for one in (estimate, again)]
    assert np.array_equal(*runs) and forest.get_params() == helmbench.make_method("random-forest").get_params()
    with pytest.raises(BadInput, match="has no option 'nothing'"):
        fitted(root, "ls", "nomoto-1", nothing=1)


def test_what_cannot_be_read_is_told(root, run):
    u, y = run
    with pytest.raises(BadInput, match="initial window is empty"):
        fitted(root, "ls", "nomoto-1")(u, y[:0], {})
    with pytest.raises(BadInput, match="helmbench cannot read"):
        fitted(root, "ls", "nomoto-1", ["r", "time"])
    with pytest.raises(BadInput):
        helmbench.identibench_model("no-such-method", "nomoto-1")
    with pytest.raises(BadInput):
        helmbench.identibench_model("ls", "no-such-model")


def test_the_score_is_the_rmse_of_the_free_run(root):
    """identibench's number, computed again from the callable."""
    spec = replace(identibench.BenchmarkShip_Simulation, y_cols=MOTION)
    build = helmbench.identibench_model("ls", "nomoto-1-cubic")
    with identibench.data_root(root):
        found = identibench.run_benchmark(spec, build, seed=1)["test_sets"]["ood"]["rmse"]
        context = identibench.TrainingContext(replace(spec, train=spec.test_sets["ood"]), {}, 1)
        (sequence,) = context.get_train_sequences()
        model = build(identibench.TrainingContext(spec, {}, 1))
    predicted = model(sequence.u, sequence.y[:WINDOW], sequence.attrs)
    assert found == pytest.approx(rmse(predicted[WINDOW:], sequence.y[WINDOW:]).mean(), rel=1e-6)
