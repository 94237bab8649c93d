"""Free runs of the filter, and fits to them."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.gain import free_runs
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.settings import Parameter
from helmbench.models.model import resolve
from helmbench.models.simulate import inputs_of, simulate


@pytest.fixture(scope="module")
def est():
    """Mariner's filter on two records without noise."""
    records = [generate(Case("mariner", text, duration_s=200.0)) for text in ("zigzag:20/20", "turn:25")]
    return estimator(resolve("mariner"), records)


def test_the_exact_model_runs_freely_along_its_own_records(est):
    for i, d in enumerate(est.segments):
        assert np.nanmax(np.abs(free_runs.free_run(est, est.start(), i) - d.measured)[:, :4]) < 1e-4


def test_no_random_force_is_left_after_release(est):
    """The filter holds large gusts at release; from there on the run is a plain simulation."""
    s, free = est.start(), 40
    gusts = replace(s.noise, force_sd=np.full(est.n_forces, 0.05), correlation_time_s=20.0)
    pushed = replace(s, noise=gusts, vectors=s.vectors.copy())
    pushed.vectors[:, est.index["rudder_effectiveness"]] = -0.3
    run, rudder = est.free_run(pushed, 0, free), 0.7 * est.segments[0].rudder
    model, order = est.model, [("psi", "r", "u", "v", "x", "y").index(name) for name in est.model.states]
    alone = simulate(model, inputs_of(model, rudder[free:]), est.segments[0].step_s, run[free][order])
    assert np.abs(alone[:, :4] - run[free:][:, order][:, :4]).max() < 1e-9


def test_what_belongs_to_a_record_is_estimated_anew(est):
    """A current in the held-out records comes out of their first part."""
    current = cause_of("current").variants(est)[-1]
    drifting = est.with_entries(est.start(), {"current_towards_north": 0.5, "current_towards_east": -0.3})
    moved = [r.with_channels(**_moved(r, 0.5, -0.3)) for r in _records()]
    held = estimator(resolve("mariner"), moved)
    found = free_runs.adapted(held, free_runs.transferred(held, est.start(), current), current)
    index = [held.index["current_towards_north"], held.index["current_towards_east"]]
    assert found.vectors[:, index] == pytest.approx(drifting.vectors[:, index], abs=0.05)


def _records():
    return [generate(Case("mariner", text, "low", seed=3, duration_s=300.0)) for text in ("zigzag:20/20", "turn:25")]


def _moved(record, north, east):
    """Channels of the record in a steady current: velocities over ground and positions."""
    psi, t = record.heading_unwrapped(), record.time_s - record.time_s[0]
    return {
        "surge_m_s": record.column("surge_m_s") + north * np.cos(psi) + east * np.sin(psi),
        "sway_m_s": record.column("sway_m_s") - north * np.sin(psi) + east * np.cos(psi),
        "north_m": record.column("north_m") + north * t,
        "east_m": record.column("east_m") + east * t,
    }


def test_output_error_finds_what_simulates_best():
    truth = resolve("mariner")
    records = [generate(Case("mariner", "zigzag:20/20", "low", seed=5, duration_s=300.0))]
    est = estimator(truth, records)
    entry = est.index["Nd"]
    shift = Parameter("Nd", "", ((entry, abs(est.base[entry])),))
    off = est.at(est.start(), shift, 0.2)
    found = free_runs.fitted_to_simulate(est, [off], [shift])
    assert abs(est.value(found, shift)) < 0.02
