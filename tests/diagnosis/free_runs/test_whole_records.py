"""Free runs of whole records, with effects of each record's own, as the problem of a fit."""

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.calibration.group_fits import blind_errors, fit_groups, score_fall
from helmbench.diagnosis.free_runs.bank import of_numbers
from helmbench.diagnosis.free_runs.problem import LIMIT, FreeRuns
from helmbench.diagnosis.free_runs.units import THRUST, Lane, names_of_units, units_of
from helmbench.models.coefficient_groups import Group
from helmbench.models.model import resolve
from helmbench.models.time_scale import time_scale_s

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


def runs_of(model, records):
    length_s = time_scale_s(model)
    return FreeRuns(of_numbers(model), units_of(model, records, length_s, whole=True), length_s, whole=True)


def group(sd):
    return Group("wrong", "numbers that are wrong", None, sd)


def noisy(true, rng):
    return [record(true, text, trim, rng) for text, trim in zip(MANOEUVRES, TRIM, strict=True)]


def test_the_true_model_has_no_error(ship):
    runs = runs_of(ship, [record(ship, text) for text in MANOEUVRES])
    assert runs.channels == ["surge_m_s", "sway_m_s", "yaw_rate_rad_s", "heading_rad"]
    assert np.all(np.array([*blind_errors(runs, {}).values()]) < 0.05 * runs.floor)


def test_wrong_numbers_and_each_records_trim_are_estimated(ship):
    true = changed(ship, R_0=0.018, N_v=-0.15)
    runs = runs_of(ship, [record(true, text, trim) for text, trim in zip(MANOEUVRES, TRIM, strict=True)])
    fitted = fit_groups(runs, [group(BOTH)]).fitted
    values = [runs.bank.values[name] + fitted.value(name) for name in BOTH]
    assert values == pytest.approx([0.018, -0.15], rel=0.02)
    assert np.rad2deg(fitted.point.own[:, 0]) == pytest.approx(np.rad2deg(TRIM), abs=0.05)
    assert fitted.point.cost < fit_groups(runs, []).fitted.point.cost - 100.0


def test_leaving_a_record_out_agrees_with_a_fit_to_the_others(ship, rng):
    records = noisy(changed(ship, R_0=0.018, N_v=-0.15), rng)
    without = fit_groups(runs_of(ship, records), [group(BOTH)]).fitted.without
    for i in range(len(records)):
        others = runs_of(ship, [r for j, r in enumerate(records) if j != i])
        exact = fit_groups(others, [group(BOTH)]).fitted
        assert [without[i][n] for n in BOTH] == pytest.approx([exact.value(n) for n in BOTH], abs=5e-4)


def test_a_score_falls_where_a_number_is_needed_and_not_where_it_is_not(ship, rng):
    runs = runs_of(ship, noisy(changed(ship, R_0=0.018), rng))
    base, needed = fit_groups(runs, []), fit_groups(runs, [group(RESISTANCE)])
    needless = fit_groups(runs, [group(RESISTANCE | {"X_vvvv": 0.3})])
    by = score_fall(runs, base, needed)
    assert by.gain > 2.0 * by.error
    by = score_fall(runs, needed, needless)
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
    by = {k: fit_groups(runs_of(ship, r), [group({"k_0": 0.1})]) for k, r in
          {"without": fast, "with": [measured(r) for r in fast]}.items()}  # fmt: skip
    assert abs(by["with"].fitted.value("k_0")) < 0.3 * abs(by["without"].fitted.value("k_0"))


def test_few_records_are_cut_and_parts_have_names(ship):
    one = record(ship, "zigzag:10/10")
    cut = units_of(ship, [one], time_scale_s(ship), whole=True)
    whole = units_of(ship, [one] * 3, time_scale_s(ship), whole=True)
    assert len(cut) == 3 == len(whole)
    assert names_of_units(cut) == [f"{one.name}, part {k}" for k in (1, 2, 3)]
    assert names_of_units(whole) == [one.name] * 3
