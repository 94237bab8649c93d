"""Paper 003's own parts: its closed loop against the simulator, its printed equations, its Kalman filter."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from helmbench.methods.ls_svr import CYCLES, TUNERS, colony
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.reproduction import results
from helmbench.reproduction.claims.files import load
from helmbench.reproduction.pages import markdown
from helmbench.reproduction.papers.paper_003 import (
    identification,
    proposed,
    states,
    studies,
    vessels,
)
from helmbench.reproduction.papers.paper_003.vessels import DT, VESSELS
from helmbench.reproduction.papers.study import stream
from helmbench.reproduction.verdicts import spread

from .named import drawn

PUBLISHED = Path(__file__).parents[3] / "reports" / "reproduction"


@pytest.mark.parametrize(("vessel", "limit"), [("cargo", 1e-4), ("patrol", 2e-3)])
def test_the_closed_loop_is_the_simulated_vessel(vessel, limit):
    """Eq 6, corrected, against the vessel's own equations (there the rudder is held a sample later)."""
    run, record = vessels.motion(vessel, "S3"), vessels.record(vessel, "S3")
    heading = record.heading_unwrapped()
    assert np.abs(run.psi - heading).max() < limit * np.abs(heading).max() * 10.0
    assert np.abs(run.delta - record.rudder()).max() < limit * 10.0 * np.abs(run.delta).max()
    assert len(run.psi) == record.n == vessels.samples(vessel)


@pytest.mark.parametrize("vessel", VESSELS)
def test_the_third_derivative_obeys_equation_1(vessel):
    run = vessels.motion(vessel, "S3")
    rows = np.column_stack([run.psi_ddot, run.r, run.delta, run.delta_dot])
    assert rows @ resolve(vessel).coefficients == pytest.approx(run.psi_dddot, abs=1e-12)


def test_printed_equations_fail_where_the_errata_say(rng):
    values = studies.settings(rng, index=0).values
    for name in ("rudder_settles", "eq18_gives_eq19", "eq20_places_poles", "eq31", "weights_fall"):
        assert values[name] and not values[f"{name}_as_printed"], name
    positive = vessels.numbers("patrol")._replace(kp=0.7)
    assert values["patrol_stable"] and studies._growth(vessels.closed_loop(positive)[0]) > 0.0


def test_errors_of_table_5_follow_from_its_values(rng):
    values = identification.arithmetic(rng, index=0).values
    assert values["cargo_rw_error_T1"] == pytest.approx(2.689, abs=5e-4)
    assert values["cargo_rw_error_K"] == pytest.approx(5.556, abs=5e-4)  # 5.23 in print
    assert values["patrol_ls_error_T3"] == pytest.approx(4.973, abs=5e-4)


def test_the_kalman_filter_observes_a_cubic_heading(rng):
    t = DT * np.arange(60_000)
    c = rng.normal(size=3)
    found = states._kalman_states(c[0] + c[1] * t + c[2] * t**2 / 2.0, 1e-12)
    assert found[-1, 1] == pytest.approx(c[1] + c[2] * t[-1], rel=1e-5)
    assert found[-1, 2] == pytest.approx(c[2], rel=1e-4)


@pytest.mark.parametrize(
    ("wins", "expected"),
    [([1, 1, 0, 1], 2e-3), ([1, 1, 1, 1], 4e-3), ([0, 1, 1, 1], np.nan)],
)
def test_the_crossover_is_the_end_of_an_unbroken_row(wins, expected):
    levels = np.array([1e-3, 2e-3, 3e-3, 4e-3])
    assert states._up_to(np.array(wins, bool), levels) == pytest.approx(expected, nan_ok=True)


def test_the_observer_beats_a_filter_where_it_steps_as_the_vessel_does(rng):
    """At 1e-11 rad: by Euler steps in yaw rate and acceleration, not in the heading; solved exactly in nothing."""
    for hold, method, expected in (("euler", "euler", [False, True, True]), ("zero", "exact", [False] * 3)):
        run = vessels.motion("patrol", "S3", hold)
        psi = run.psi + 1e-11 * rng.normal(size=len(run.psi))
        assert (states._filter_over_observer(run, psi, method) > 1.0).tolist() == expected


def test_runs_are_spread_over_the_noise(monkeypatch, rng):
    """20 runs: in each fifth of the decades of the range there are 3 to 5 of them, whatever the seed."""
    levels = []
    monkeypatch.setattr(identification, "on_sines", lambda vessel, sines, level, rng: levels.append(level))
    for index in range(20):
        identification.tables_5_and_6("cargo", rng, index=index)
    low, high = np.log(identification.NOISE)
    counts, _ = np.histogram((np.log(levels) - low) / (high - low), 5, (0.0, 1.0))
    assert counts.sum() == 20 and counts.min() >= 3 and counts.max() <= 5


def test_equal_streams_give_equal_results():
    one, two = (states.table_4("patrol", stream("003", "states_patrol", 5), index=5).values for _ in range(2))
    assert one == two


@pytest.fixture
def short_runs(monkeypatch):
    """A tenth of the paper's durations, one cycle of the colony and two observers."""

    def clear():
        for cached in (vessels.record, vessels.motion, identification._validation):
            cached.cache_clear()

    clear()
    monkeypatch.setattr(vessels, "DURATION", {"cargo": 600.0, "patrol": 90.0})
    monkeypatch.setattr(proposed, "colony", partial(colony, cycles=1))
    monkeypatch.setattr(proposed, "AFTER", (0, 1))
    monkeypatch.setattr(proposed, "POLES", {"cargo": (0.5, 1.0), "patrol": (5.0, 10.0)})
    yield
    clear()


@pytest.mark.parametrize("weighted", [True, False])
def test_a_watched_proposal_is_the_proposed_variant(weighted, short_runs, monkeypatch, rng):
    monkeypatch.setitem(TUNERS, "abc", proposed.colony)
    model, run = resolve("patrol"), vessels.noisy(vessels.record("patrol", "S3"), 1e-4, rng)
    found, watched = proposed.fitted(run, model, weighted, proposed.colony)
    variant = make(f"eso-rw-lssvr,variant=proposed,weighted={str(weighted).lower()}").fit([run], model)
    assert found.coefficients.tobytes() == variant.coefficients.tobytes()
    assert found.extra["C"] == variant.extra["C"] and len(watched.errors) == variant.extra["evaluations"] == 90
    assert (np.diff(watched.best) <= 0.0).all() and watched.best[-1] == min(watched.errors)


@pytest.mark.nightly
def test_the_proposal_s_budget_and_convergence(short_runs, rng):
    result = proposed.proposed(rng, index=0)
    keys = {key for table in load("003").shown for key in table.keys}
    assert {key for key in keys if not key.endswith(("_3", "_10"))} <= set(result.values)  # cycles that are not run
    for vessel in vessels.VESSELS:
        assert result.values[f"{vessel}_best_ls_omega0"] in proposed.POLES[vessel]
        for name in (f"{vessel}_chosen_rw", f"{vessel}_best_ls"):
            best = result.series[name]
            assert len(best) == 2 and best[1] <= best[0]
            assert result.values[f"{name}_excess_0"] == pytest.approx(100.0 * (best[0] / best[1] - 1.0))
            assert result.values[f"{name}_excess_1"] == 0.0 and result.values[f"{name}_evaluations"] == 90
            assert result.values[f"{name}_cpu_s"] > 0.0
    assert drawn("003", {"proposed": result})["convergence"] > 1000


def test_the_cycles_that_are_told_are_the_colony_s(rng):
    """30 sources, and 60 moves in each of 30 cycles, as Table 3 has them."""
    seen = proposed.Watched(colony)
    seen(lambda c: float(np.log(c) ** 2) + 1.0, 1e-2, 1e10)
    assert (proposed.SOURCES, proposed.MOVES) == (30, 60)
    assert len(seen.errors) == 30 + 30 * 60 == proposed.SOURCES + CYCLES * proposed.MOVES
    assert max(proposed.AFTER) < CYCLES


def test_values_without_claims_are_tables_of_the_page():
    paper, stored = load("003"), results.read("003", PUBLISHED)

    def page(values):
        return markdown.page(paper, replace(stored, values={**stored.values, "proposed": values}))

    values = {key: spread([1.0, 2.0, 4.0]) for table in paper.shown for key in table.keys}
    text, empty = page(values), page({})
    assert text.count("2 [1, 4]") == sum(len(table.keys) for table in paper.shown) == 4 * 21
    for table in paper.shown:
        assert f"## {table.title}" in text and table.title not in empty
    assert text.count("no finite value |") == empty.count("no finite value |")
    lacking = page(values | {"cargo_best_rw_r2": spread([np.nan, np.nan, 0.5])})
    assert lacking.count("no finite value |") == empty.count("no finite value |") + 1
