"""A run that begins in a turn: what the record does not measure starts as it was, not as on a straight course."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.estimation.run.run import run_along
from helmbench.estimation.run.start import start_state
from helmbench.estimation.run.stretch import stretches_of
from helmbench.models.extend import extended
from helmbench.models.model import resolve
from helmbench.models.regimes import CLOCK

SHIPS = {"mariner": 110.0, "s175": 110.0, "kvlcc2-l7": 60.0}
"""Ship -> when her records are cut, s: in the middle of a turn."""


def both(record, cut_s):
    """The record from some time on: with all channels, and without sway and positions."""
    late = record.between(float(record.time_s[0]) + cut_s, None)
    return late, late.with_channels(sway_m_s=None, north_m=None, east_m=None)


def heading_error(model, record):
    run = run_along(model, record)
    return float(np.sqrt(np.nanmean((run.predicted["heading_rad"] - record.heading_unwrapped()) ** 2)))


@pytest.mark.parametrize("vessel", SHIPS)
def test_a_sway_that_is_not_measured_starts_as_it_was(vessel):
    """Of records of an independent simulator, long enough for a fit."""
    model = resolve(vessel)
    case = inject(FaultCase(vessel, ()), np.random.default_rng(3))
    v, moved, errors = model.states.index("v"), [], []
    for record in (
        r for r in (*case.train, *case.held_out) if np.ptp(r.time_s) > SHIPS[vessel] + 100.0 or "-l7" in vessel
    ):
        known, unknown = both(record, SHIPS[vessel])
        (measured,), (fitted,) = (stretches_of(model, r.turned(model.positive_rudder)) for r in (known, unknown))
        moved.append(abs(measured.state_at(0)[v]))
        errors.append(abs(measured.state_at(0)[v] - fitted.state_at(0)[v]))
        assert heading_error(model, unknown) < heading_error(model, known) + np.deg2rad(0.6)
    assert np.max(moved) > 0.05 * model.speed_m_s  # a straight course is none of these
    assert np.median(errors) < 0.01 * model.speed_m_s


@pytest.mark.parametrize("vessel", ["mariner", "s175"])
def test_a_ship_that_turns_has_lost_speed(vessel):
    model = resolve(vessel)
    case = inject(FaultCase(vessel, ()), np.random.default_rng(3))
    u, lost, off = model.states.index("u"), [], []
    for record in (*case.train, *case.held_out):
        known, unknown = both(record, 60.0)
        (start,) = stretches_of(model, unknown.with_channels(surge_m_s=None).turned(model.positive_rudder))
        lost.append(model.speed_m_s - known.column("surge_m_s")[:5].mean())
        off.append(abs(start.state_at(0)[u] - known.column("surge_m_s")[:5].mean()))
    print(lost, off)
    assert max(lost) > 0.08 * model.speed_m_s and np.sum(np.square(off)) < 0.7 * np.sum(np.square(lost))


def test_what_is_measured_stays_and_a_model_that_does_not_settle_starts_straight():
    model = resolve("mariner")
    case = inject(FaultCase("mariner", ()), np.random.default_rng(3))
    known, unknown = both(case.train[0], 110.0)
    (whole,), (part,) = (stretches_of(model, r.turned(model.positive_rudder)) for r in (known, unknown))
    at = [model.states.index(s) for s in ("u", "r", "psi")]
    assert part.state_at(0)[at] == pytest.approx(whole.state_at(0)[at])
    wild = replace(model, coefficients=1e3 * model.coefficients)
    series = part.series
    state = start_state(wild, series.start, part.known, series.inputs, series.dt)
    assert state[model.states.index("v")] == 0.0 and np.isfinite(state).all()


def test_the_time_of_the_record_goes_on_behind_a_gap():
    """A moment that begins 150 s after the start of the record does so in the stretch behind the gap."""
    model = extended(resolve("mariner"), "N_from", {"N_from_size": 3e7, "N_from_begin": 150.0})
    record = record_run(model, parse_manoeuvre("zigzag:20/20"), duration_s=300.0, dt_s=0.5, seed=1)
    time = record.time_s - record.time_s[0]
    gap = record.with_channels(rudder_rad=np.where((time > 40.0) & (time < 120.0), np.nan, record.column("rudder_rad")))
    first, second = stretches_of(model, gap)
    assert [s.state_at(0)[model.states.index(CLOCK)] for s in (first, second)] == pytest.approx([0.0, 120.0])
    assert second.state_at(10)[model.states.index(CLOCK)] == pytest.approx(120.0 + 10 * second.series.dt)
    late = replace(second, begin_s=0.0)
    heading = model.states.index("psi")
    errors = [np.abs(s.free_run().states[:, heading] - s.known[heading]).max() for s in (second, late)]
    assert errors[0] < 0.02 and errors[1] > 5.0 * errors[0]
