"""Lifted linear models: exact where lifted dynamics are linear, DMDc without products, gaps, and what a run does."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.rows import Signals
from helmbench.estimation.methods_only.black_box.state_space import SignalScales, Training, pasts
from helmbench.estimation.methods_only.black_box.terms import evaluate
from helmbench.estimation.records.series import MEASURED, series_of
from helmbench.methods import edmd as koopman
from helmbench.methods.registry import make
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

MODEL = resolve("cargo")


def closed(rng, n):
    """Signals of z1' = 0.9 z1, z2' = 0.7 z2 + 0.5 z1^2 + 0.3 w + 0.2, linear in (z1, z2, z1^2)."""
    w, z = rng.normal(size=(n, 1)), np.empty((n, 2))
    z[0] = rng.uniform(-2.0, 2.0, size=2)
    for t in range(n - 1):
        z[t + 1] = 0.9 * z[t, 0], 0.7 * z[t, 1] + 0.5 * z[t, 0] ** 2 + 0.3 * w[t, 0] + 0.2
    return Signals(1.0, z, w, np.ones(n, bool))


def lift(*arguments, bilinear=False):
    return koopman.lift(*arguments, bilinear)


def training(*parts, stride=1):
    k, nu = parts[0].outputs.shape[1], parts[0].inputs.shape[1]
    return Training(MODEL, stride, 1.0, SignalScales(np.zeros(k), np.ones(k), np.zeros(nu), np.ones(nu)), parts)


def free_run(system, part, lags, first, last, stride=1):
    """States (K, n) of a run from sample `first` on."""
    states = [system.begin(pasts(part, np.array([first]), stride, lags))]
    for t in range(first, last, stride):
        states.append(system.advance(states[-1], part.inputs[t : t + 1]))
    return np.vstack(states)


@pytest.mark.parametrize("degree", [2, 3])
def test_free_runs_are_exact_where_the_lifted_dynamics_are_linear(rng, degree):
    parts, held_out = [closed(rng, 40) for _ in range(20)], closed(rng, 60)
    system = lift(training(*parts), degree, 1, 0.0)
    found = free_run(system, held_out, 1, 0, 59)
    np.testing.assert_allclose(found[:, :2], held_out.outputs, rtol=0.0, atol=1e-10)
    square = system.terms.tolist().index([0] * (degree - 2) + [1, 1])
    np.testing.assert_allclose(found[:, square], held_out.outputs[:, 0] ** 2, rtol=0.0, atol=1e-10)
    lines = free_run(lift(training(*parts), 1, 1, 0.0), held_out, 1, 0, 59)
    assert np.abs(lines - held_out.outputs).max() > 1e-5


@pytest.mark.parametrize("output_lags", [1, 3])
def test_without_products_it_is_least_squares_of_dmdc(rng, output_lags):
    """The snapshots of each record, as Proctor, Brunton & Kutz stack them, and a row of ones for the offset."""
    parts, last = [closed(rng, 50) for _ in range(4)], output_lags - 1
    noisy = [part._replace(outputs=part.outputs + 0.1 * rng.normal(size=part.outputs.shape)) for part in parts]
    system = lift(training(*noisy), 1, output_lags, 0.0)
    rows, ahead = [], []
    for part in noisy:
        x = np.hstack([part.outputs[last - j : 50 - j] for j in range(output_lags)])  # z(t), z(t - 1), ...
        rows.append(np.hstack([x[:-1], part.inputs[last:-1], np.ones((len(x) - 1, 1))]))
        ahead.append(x[1:])
    g = (np.linalg.pinv(np.vstack(rows)) @ np.vstack(ahead)).T
    np.testing.assert_allclose(np.column_stack([system.a, system.b, system.c]), g, rtol=0.0, atol=1e-9)


def test_of_real_size_it_is_dmdc_of_the_record():
    """Stride one averages nothing: the matrices of the record's own columns, in SI units, give the same free run."""
    model = resolve("mariner")
    record = generate(Case("mariner", "zigzag:20/20", noise="none"))
    found = make("edmd,stride=1,degree=1,output_lags=1,alpha=1e-14,bilinear=false").fit(record, model).predictor
    series = series_of(record.turned(model.positive_rudder), model, MEASURED)
    z = np.column_stack([record.column(name) for name in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")])
    w = series.inputs[: len(z)]
    x = np.hstack([z, w, np.ones((len(z), 1))])
    matrices = np.linalg.lstsq(x[:-1], z[1:], rcond=None)[0]
    expected = [z[0]]
    for now in x[:-1, 3:]:
        expected.append(np.concatenate([expected[-1], now]) @ matrices)
    run = found.simulate(series.inputs, series.dt, series.start)[:, [model.states.index(s) for s in ("u", "v", "r")]]
    np.testing.assert_allclose((run - expected) / z.std(axis=0), 0.0, atol=1e-4)


def test_the_bilinear_form_is_exact_where_inputs_act_in_proportion_to_the_state(rng):
    """z1' = 0.8 z1 + (0.3 + 0.2 z1 + 0.1 z2) w, z2' = 0.6 z2 + 0.5 w: no product of outputs is needed."""

    def driven(n):
        w, z = rng.uniform(-1.0, 1.0, size=(n, 1)), np.zeros((n, 2))
        for t in range(n - 1):
            x, y = z[t]
            z[t + 1] = 0.8 * x + (0.3 + 0.2 * x + 0.1 * y) * w[t, 0], 0.6 * y + 0.5 * w[t, 0]
        return Signals(1.0, z, w, np.ones(n, bool))

    parts, held_out = [driven(60) for _ in range(5)], driven(60)
    found = free_run(lift(training(*parts), 1, 1, 0.0, bilinear=True), held_out, 1, 0, 59)
    np.testing.assert_allclose(found, held_out.outputs, rtol=0.0, atol=1e-10)
    linear = free_run(lift(training(*parts), 1, 1, 0.0), held_out, 1, 0, 59)
    assert np.abs(linear - held_out.outputs).max() > 1e-4


def test_products_are_not_computed_anew_in_a_free_run(rng):
    """On outputs whose products do not close, the lifted state leaves the products of its own outputs."""
    w, z = rng.normal(size=(400, 1)), np.zeros((400, 1))
    for t in range(399):
        z[t + 1] = 0.8 * z[t] - 0.2 * np.tanh(z[t]) ** 2 + 0.5 * w[t]
    part = Signals(1.0, z, w, np.ones(400, bool))
    system = lift(training(part), 2, 1, 1e-6)
    state = free_run(system, part, 1, 0, 20)
    power = np.vstack([np.hstack([system.a, system.b, system.c[:, None]]), np.eye(2, 4, 2)])
    expected = np.append(state[0], [0.0, 1.0])
    for now in w[:20, 0]:
        expected[2] = now
        expected[:2] = (power @ expected)[:2]
    np.testing.assert_allclose(state[-1], expected[:2], rtol=1e-12)
    np.testing.assert_array_equal(state[:1], evaluate(system.terms, z[:1]))
    assert np.abs(state[1:, 1] - state[1:, 0] ** 2).max() > 1e-3


@pytest.mark.parametrize("stride", [1, 3])
def test_gaps_carry_no_weight(rng, stride):
    parts = [closed(rng, 80) for _ in range(8)]
    spoilt, whole = parts[0].outputs.copy(), np.ones(80, bool)
    spoilt[30:40], whole[30:40] = 50.0, False
    broken = [parts[0]._replace(outputs=spoilt, whole=whole), *parts[1:]]
    kept = [*(Signals(1.0, *(v[part] for v in parts[0][1:])) for part in (slice(0, 30), slice(40, 80))), *parts[1:]]
    found, expected = (lift(training(*one, stride=stride), 2, 2, 1e-6) for one in (broken, kept))
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9)


def test_too_few_rows_are_refused(rng):
    with pytest.raises(CannotFit, match="11 usable rows for 11 unknowns"):
        lift(training(closed(rng, 12)), 3, 1, 1e-6)
    lift(training(closed(rng, 13)), 3, 1, 1e-6)
    with pytest.raises(CannotFit, match="no record is as long as 3 steps"):
        lift(training(closed(rng, 2)), 1, 2, 1e-6)


def test_records_shorter_than_a_step_are_left_out(rng):
    long, short = closed(rng, 60), closed(rng, 3)
    found, expected = (lift(training(*parts, stride=3), 1, 2, 1e-6) for parts in ((long, short), (long,)))
    np.testing.assert_array_equal(found.a, expected.a)
