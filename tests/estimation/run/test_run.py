"""The one free run: its start, its stretches, its errors, and the record's own neutral angle and start."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.run.run import run_along, squares_of
from helmbench.estimation.run.stretch import stretches_of
from helmbench.models.coefficient_groups import with_values
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

from ...made_up.records import errors_of, long_zigzag


@pytest.fixture(scope="module")
def ship():
    return resolve("mariner")


@pytest.fixture(scope="module")
def record():
    return long_zigzag()


def test_the_noise_of_the_first_sample_moves_no_run(ship):
    """The state at the start is smoothed: a run from the first sample turns away with its error."""
    smoothed, first = [], []
    for seed in range(6):
        record = generate(Case("mariner", "zigzag:20/20", "medium", seed=seed, duration_s=200.0, dt_s=1.0))
        smoothed.append(errors_of(run_along(ship, record))["heading_rad"])
        (stretch,) = stretches_of(ship, record)
        run = stretch.run(stretch.series.start, stretch.series.inputs)
        heading = run.states[:, ship.states.index("psi")]
        first.append(np.sqrt(np.mean((heading - record.continuous("heading_rad")) ** 2)))
    assert np.linalg.norm(smoothed) < 0.8 * np.linalg.norm(first)


def test_every_sample_counts_and_a_run_starts_anew_behind_a_long_gap(ship, record):
    kept = np.ones(record.n, bool)
    kept[150:200] = False
    cut = replace(record, time_s=record.time_s[kept], channels={c: v[kept] for c, v in record.channels.items()})
    run = run_along(ship, cut)
    assert run.starts_s == (0.0, 200.0)
    assert run.squares()["heading_rad"].n == cut.n and np.isfinite(run.predicted["heading_rad"]).all()
    assert [place.stop - place.start for place in run.places] == [150, record.n - 200]


def test_errors_of_records_are_pooled_sample_by_sample_and_spread_about_their_own_means(ship, record):
    other = generate(Case("mariner", "turn:20", "low", seed=8, duration_s=200.0, dt_s=1.0))
    runs = [run_along(ship, one) for one in (record, other)]
    pooled = squares_of(runs)
    for channel, sums in pooled.items():
        each = [run.squares()[channel] for run in runs]
        assert sums == tuple(map(sum, zip(*each, strict=True)))
        assert each[0].spread == pytest.approx(record.n * np.var(record.continuous(channel)), rel=1e-6)


def test_the_record_is_what_the_instruments_show(ship, record):
    """A bias that the model knows of its gyro is no error."""
    biased = record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + 0.01)
    known = replace(ship, instruments={"yaw_rate_bias": 0.01})
    assert errors_of(run_along(known, biased)) == pytest.approx(errors_of(run_along(ship, record)), rel=1e-6)
    assert errors_of(run_along(ship, biased))["yaw_rate_rad_s"] > 0.009


def test_a_small_craft_that_spins_is_integrated_in_steps_short_enough():
    """Steps that suit a ship diverge at once: 0.1 s times 3 c r^2 = 96 / s."""
    numbers = {"a": -0.4, "b": -1.6, "c": -50.0}
    craft = with_values(resolve("nomoto-1-cubic"), numbers)
    time_s = 0.1 * np.arange(60)

    def rates(_, state):
        return [-0.4 * state[0] - 50.0 * state[0] ** 3 - 1.6 * -0.5, state[0]]

    r, psi = solve_ivp(rates, (0.0, time_s[-1]), [0.8, 0.0], method="LSODA", t_eval=time_s, rtol=1e-9, atol=1e-12).y
    channels = {"rudder_rad": np.full(time_s.size, -0.5), "yaw_rate_rad_s": r, "heading_rad": psi}
    (stretch,) = stretches_of(craft, Record(time_s, channels, name="spin"))
    run = stretch.run(np.array([0.8, 0.0]), stretch.series.inputs)
    assert run.states[1:60, 0] == pytest.approx(r[1:], abs=2e-3)


def test_a_record_without_a_rudder_cannot_be_run(ship, record):
    with pytest.raises(CannotFit):
        stretches_of(ship, record.with_channels(rudder_rad=np.full(record.n, np.nan), rudder_command_rad=None))
