"""Free runs fitted to several records, with effects of each record's own."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.estimation.diagnosis_only.mixed_effects.fit import Number, expansions_of, fit
from helmbench.estimation.diagnosis_only.mixed_effects.left_out import (
    jackknife,
    leave_one_out,
    predicted,
    score_difference,
)
from helmbench.estimation.diagnosis_only.mixed_effects.problem import LARGEST, THRUST, pooled, problem, squares
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve
from helmbench.models.time_scale import time_scale_s

MANOEUVRES = ("zigzag:10/10", "zigzag:20/20:port", "turn:20", "zigzag:25/5")
TRIM = np.deg2rad([0.2, -0.3, 0.1, -0.1])


def record(model, text, trim=0.0, rng=None):
    """A run whose rudder is recorded without its trim: the hull feels the recorded angle plus trim."""
    run = record_run(model, parse_manoeuvre(text), duration_s=80.0, dt_s=0.2)
    run = run.with_channels(rudder_rad=run.rudder() - trim)
    return run if rng is None else apply(run, parse_noise("low"), rng)


@pytest.fixture(scope="module")
def ship():
    return resolve("kvlcc2-l7")


def changed(model, **values):
    """The model with coefficients at other values."""
    new = model.coefficients.copy()
    for name, value in values.items():
        new[model.coordinates.index(name)] = value
    return model.with_coefficients(new)


def number(p, name, sd):
    names = [*p.model.coordinates, *p.model.constant_names]
    return Number(name, names.index(name), float(p.model.theta[names.index(name)]), sd)


def test_the_true_model_has_no_error(ship):
    p = problem(ship, [record(ship, text) for text in MANOEUVRES])
    errors = pooled([squares(p, ship.theta, run) for run in p.runs])
    assert p.channels == ("u", "v", "r", "psi")
    assert np.all(errors < 0.05 * p.floor)


def test_a_wrong_number_and_each_records_trim_are_found(ship):
    true = changed(ship, R_0=0.018, N_v=-0.15)
    p = problem(ship, [record(true, text, trim) for text, trim in zip(MANOEUVRES, TRIM, strict=True)])
    numbers = [number(p, "R_0", 0.004), number(p, "N_v", 0.03)]
    found = fit(p, numbers, ship.theta)
    assert found.values == pytest.approx([0.018, -0.15], rel=0.02)
    assert np.rad2deg(found.own[:, 0]) == pytest.approx(np.rad2deg(TRIM), abs=0.05)
    base = fit(p, [], ship.theta)
    assert found.criterion < base.criterion - 100.0


def test_leaving_a_record_out_agrees_with_a_fit_to_the_others(ship, rng):
    true = changed(ship, R_0=0.018, N_v=-0.15)
    records = [record(true, text, trim, rng) for text, trim in zip(MANOEUVRES, TRIM, strict=True)]
    p = problem(ship, records)
    numbers = [number(p, "R_0", 0.004), number(p, "N_v", 0.03)]
    parts = leave_one_out(fit(p, numbers, ship.theta))
    for i in range(len(records)):
        others = problem(ship, [r for j, r in enumerate(records) if j != i])
        exact = fit(others, numbers, ship.theta).values
        assert parts[i].values == pytest.approx(exact, abs=2e-3 * abs(exact[1]))


def test_what_a_fit_would_leave_is_predicted_without_a_run(ship, rng):
    true = changed(ship, R_0=0.0205)
    records = [record(true, text, trim, rng) for text, trim in zip(MANOEUVRES, TRIM, strict=True)]
    p = problem(ship, records)
    base = fit(p, [], ship.theta)
    numbers = [number(p, "R_0", 0.004), number(p, "N_v", 0.03)]
    expansions = expansions_of(p, numbers, base.theta, base.own)
    told = predicted(base, expansions, numbers, np.array([0]))
    made = leave_one_out(fit(p, numbers[:1], ship.theta))
    for one, other in zip(told, made, strict=True):
        assert one.values == pytest.approx(other.values, abs=1e-4)
    exact, quick = (score_difference(p, leave_one_out(base), parts).gain for parts in (made, told))
    assert quick == pytest.approx(exact, rel=0.2)


def test_a_score_falls_where_a_number_is_needed_and_not_where_it_is_not(ship, rng):
    true = changed(ship, R_0=0.018)
    records = [record(true, text, trim, rng) for text, trim in zip(MANOEUVRES, TRIM, strict=True)]
    p = problem(ship, records)
    base = leave_one_out(fit(p, [], ship.theta))
    needed = leave_one_out(fit(p, [number(p, "R_0", 0.004)], ship.theta))
    needless = leave_one_out(fit(p, [number(p, "R_0", 0.004), number(p, "X_vvvv", 0.3)], ship.theta))
    found = score_difference(p, base, needed)
    assert found.gain > 2.0 * found.error and found.free_gain > found.free_error
    found = score_difference(p, needed, needless)
    assert found.gain < max(0.03, 2.0 * found.error)


def test_a_run_that_leaves_the_record_counts_with_the_largest_residual(ship):
    p = problem(ship, [record(ship, "zigzag:10/10")])
    wild = ship.theta.copy()
    wild[ship.coordinates.index("N_r")] = 5.0
    error = p.residuals(wild, p.runs[0], np.zeros(p.own_sd.size))
    assert np.isfinite(error).all() and np.abs(error / p.unit).max() == pytest.approx(LARGEST)


def test_gaps_stay_gaps(ship):
    run = record(ship, "zigzag:10/10")
    surge = run.column("surge_m_s").copy()
    surge[100:150] = np.nan
    p = problem(ship, [run.with_channels(surge_m_s=surge)])
    error = p.residuals(ship.theta, p.runs[0], np.zeros(p.own_sd.size))
    assert np.isnan(error[:, 0]).sum() == np.isnan(p.runs[0].series.outputs[:, 0]).sum() > 0
    assert np.isfinite(error[:, 1:]).all()


def test_measured_thrust_is_a_channel(ship):
    """The thrust of a run at rest in the water: K_T at the advance ratio of the approach, by hand."""
    run = record(ship, "straight")
    c = dict(zip(ship.constant_names, ship.constants, strict=True))
    n, inflow = ship.n0_rps, run.column("surge_m_s") * (1.0 - c["w_P0"])
    j = inflow / (n * c["D_P"])
    thrust = c["rho"] * n**2 * c["D_P"] ** 4 * (c["k_0"] + c["k_1"] * j + c["k_2"] * j**2)
    p = problem(ship, [run.with_channels(propeller_thrust_N=thrust)])
    assert p.channels[-1] == THRUST
    error = p.residuals(ship.theta, p.runs[0], np.zeros(p.own_sd.size))[10:-10, -1]
    assert np.abs(error).max() < 2e-3 * thrust.mean()


def test_a_model_without_length_or_speed_is_refused(ship):
    with pytest.raises(CannotFit, match="no length and speed"):
        problem(replace(ship, speed_m_s=float("nan")), [record(ship, "straight")])
    with pytest.raises(CannotFit, match="no length and speed"):
        problem(resolve("nomoto-1"), [record(ship, "straight")])


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo"])
def test_a_response_model_scales_by_its_own_turning(vessel):
    """K' and T' of ships are near one."""
    assert 0.3 < time_scale_s(resolve(vessel)) / {"response-1": 5.8, "response-2": 5.8, "cargo": 21.0}[vessel] < 3.0


def test_the_jackknife_of_a_mean_is_its_standard_error(rng):
    values = rng.normal(size=12)
    means = np.array([np.delete(values, i).mean() for i in range(12)])
    assert jackknife(means) == pytest.approx(values.std(ddof=1) / np.sqrt(12.0))
