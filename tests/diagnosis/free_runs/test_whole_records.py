"""Free runs of whole records, with effects of each record's own, as the problem of a fit."""

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.free_runs.problem import LIMIT
from helmbench.diagnosis.free_runs.units import THRUST, Lane
from helmbench.estimation.selection.minimiser import minimise
from helmbench.estimation.selection.number import Number
from helmbench.estimation.selection.selection import fall_between
from helmbench.models.model import resolve

from ...support.free_runs import blind_errors
from ...support.free_runs import whole_runs as runs_of

MANOEUVRES = ("zigzag:10/10", "zigzag:20/20:port", "turn:20", "zigzag:25/5")
TRIM = np.deg2rad([0.2, -0.3, 0.1, -0.1])
RESISTANCE, BOTH = {"R_0": 0.004}, {"R_0": 0.004, "N_v": 0.03}
"""Numbers of groups with their prior standard deviations."""


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


def fitted(runs, sds):
    """The fit of numbers with these prior standard deviations."""
    return minimise(runs, [Number(name, sd) for name, sd in sds.items()], {}, runs.no_own)


def noisy(true, rng):
    return [record(true, text, trim, rng) for text, trim in zip(MANOEUVRES, TRIM, strict=True)]


def test_the_true_model_has_no_error(ship):
    runs = runs_of(ship, [record(ship, text) for text in MANOEUVRES])
    assert runs.channels == ["surge_m_s", "sway_m_s", "yaw_rate_rad_s", "heading_rad"]
    assert np.all(blind_errors(runs) < 0.05 * runs.floor)


def test_wrong_numbers_and_each_records_trim_are_estimated(ship):
    true = changed(ship, R_0=0.018, N_v=-0.15)
    runs = runs_of(ship, [record(true, text, trim) for text, trim in zip(MANOEUVRES, TRIM, strict=True)])
    fit = fitted(runs, BOTH)
    values = [runs.bank.values[name] + fit.value(name) for name in BOTH]
    assert values == pytest.approx([0.018, -0.15], rel=0.02)
    assert np.rad2deg(fit.point.own[:, 0]) == pytest.approx(np.rad2deg(TRIM), abs=0.05)
    assert fit.point.cost < fitted(runs, {}).point.cost - 100.0


def test_leaving_a_record_out_agrees_with_a_fit_to_the_others(ship, rng):
    records = noisy(changed(ship, R_0=0.018, N_v=-0.15), rng)
    without = fitted(runs_of(ship, records), BOTH).without
    for i in range(len(records)):
        others = runs_of(ship, [r for j, r in enumerate(records) if j != i])
        exact = fitted(others, BOTH)
        assert [without[i][n] for n in BOTH] == pytest.approx([exact.value(n) for n in BOTH], abs=5e-4)


def test_a_score_falls_where_a_number_is_needed_and_not_where_it_is_not(ship, rng):
    runs = runs_of(ship, noisy(changed(ship, R_0=0.018), rng))
    base, needed = fitted(runs, {}), fitted(runs, RESISTANCE)
    needless = fitted(runs, RESISTANCE | {"X_vvvv": 0.3})
    by = fall_between(runs, base, needed)
    assert by.gain > 2.0 * by.error
    by = fall_between(runs, needed, needless)
    assert by.gain < max(0.03, 2.0 * by.error)


def test_a_run_that_leaves_the_record_counts_with_the_largest_error(ship):
    runs = runs_of(ship, [record(ship, text) for text in MANOEUVRES[:3]])
    (error,) = runs.errors([Lane(0, {"N_r": 5.0}, runs.no_own[0])])
    assert np.isfinite(error).all()
    assert np.max(np.abs(error[:, 0]) / runs.floor[:, None]) == pytest.approx(LIMIT)


def test_nothing_is_counted_in_gaps(ship):
    records = [record(ship, text) for text in MANOEUVRES[:3]]
    surge = records[0].column("surge_m_s").copy()
    surge[100:150] = np.nan
    runs = runs_of(changed(ship, R_0=0.018), [records[0].with_channels(surge_m_s=surge), *records[1:]])
    (error,) = runs.errors([Lane(0, {}, runs.no_own[0])])
    gap = np.isnan(runs.measured[0][:, 0])
    assert 0 < gap.sum() == len(gap) - runs.counts[0, 0]
    assert not error[0, 0, gap].any() and error[0, 0, ~gap].any()


def test_measured_thrust_is_a_channel_that_no_fit_gives_up(ship):
    """The thrust of a straight run: K_T at the advance ratio of the approach, by hand; a fit that could take off a
    false surge by another thrust does not."""
    c = dict(zip(ship.constant_names, ship.constants, strict=True))
    n = ship.n0_rps

    def measured(run):
        inflow = run.column("surge_m_s") * (1.0 - c["w_P0"])
        j = inflow / (n * c["D_P"])
        thrust = c["rho"] * n**2 * c["D_P"] ** 4 * (c["k_0"] + c["k_1"] * j + c["k_2"] * j**2)
        return run.with_channels(propeller_thrust_N=thrust)

    straight = runs_of(ship, [measured(record(ship, "straight"))] * 3)
    assert straight.channels[-1] == THRUST
    (error,) = straight.errors([Lane(0, {}, straight.no_own[0])])
    assert np.max(np.abs(error[-1, 0, 10:-10])) < 2e-3 * np.nanmean(straight.measured[0][:, -1])
    fast = [record(changed(ship, R_0=0.01), text) for text in MANOEUVRES]
    without, thrust = (fitted(runs_of(ship, r), {"k_0": 0.1}) for r in (fast, [measured(run) for run in fast]))
    assert abs(thrust.value("k_0")) < 0.3 * abs(without.value("k_0"))
