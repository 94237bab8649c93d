"""The truth simulator against the project's kernels: two codes that share only the vessel files."""

import re
from pathlib import Path

import numpy as np
import pytest

from helmbench.bench import faults
from helmbench.bench.faults import VESSELS
from helmbench.bench.faults.equations import NO_TERMS
from helmbench.bench.faults.integrate import Chain, at_hull, gear
from helmbench.bench.faults.ships import ship
from helmbench.bench.faults.simulator import Gusts, RunPlan, gust_forces, gust_sd, simulate
from helmbench.models.model import resolve
from helmbench.models.simulate import ClosedLoop, RudderGear, closed_loop, initial_state, inputs_of
from helmbench.models.simulate import simulate as project_simulate

THREE_DOF = VESSELS[:3]


def half_steps(series: np.ndarray) -> np.ndarray:
    """A series linear between its samples, on half steps."""
    out = np.empty(2 * series.size - 1)
    out[::2] = series
    out[1::2] = 0.5 * (series[1:] + series[:-1])
    return out


def rudder_series(vessel: str, rng: np.random.Generator) -> tuple[float, np.ndarray]:
    """Step and a rudder of three random sines, up to some 25 deg, at the steps of half a record."""
    one = ship(vessel)
    n = round((300.0 if one.clock > 0.5 else 80.0) / one.step_s)
    t = one.step_s * np.arange(n + 1) / one.clock
    waves = [
        np.deg2rad(a) * np.sin(w * t + p)
        for a, w, p in zip((14, 7, 4), (0.05, 0.13, 0.4), rng.uniform(0, 6, 3), strict=True)
    ]
    return one.step_s, np.sum(waves, axis=0)


@pytest.mark.parametrize("vessel", VESSELS)
def test_truth_and_kernels_agree(vessel: str, rng: np.random.Generator) -> None:
    step, rudder = rudder_series(vessel, rng)
    model = resolve(vessel)
    x0 = initial_state(model)
    if not model.is_3dof and "w" in model.states:  # w = r_dot - K T3/h delta is the project's hidden state too
        x0[model.states.index("w")] = 0.0
    expected = project_simulate(model, inputs_of(model, rudder), step, x0)
    run = simulate(RunPlan(ship(vessel)), "straight", step * (rudder.size - 1), rng, prescribed=half_steps(rudder))
    columns = {"u": 0, "v": 1, "r": 2, "x": 3, "y": 4, "psi": 5}
    for i, name in enumerate(model.states):
        if name in columns:
            found = run.states[:, columns[name]]
            assert np.abs(found - expected[:, i]).max() < 1e-6 * max(np.abs(expected[:, i]).max(), 1e-3), name
    assert np.ptp(run.states[:, 5]) > 0.1


@pytest.mark.parametrize("vessel", THREE_DOF)
def test_current_wind_and_forces_agree(vessel: str, rng: np.random.Generator) -> None:
    step, rudder = rudder_series(vessel, rng)
    model, one = resolve(vessel), ship(vessel)
    current, wind = 0.1 * one.clock * rng.standard_normal(2), 6.0 * one.clock * rng.standard_normal(2)
    wind *= model.windage is not None  # the project has no windage for the tank model
    forces = 2e-4 * one.mass[0, 0] * one.speed_m_s * np.array([1.0, -1.0, 0.1 * one.length_m])
    environment = np.tile(np.concatenate([current, wind, forces]), (rudder.size, 1))
    control = ClosedLoop("series", rudder, RudderGear())
    x0 = initial_state(model)
    x0[:2] += current
    project = closed_loop(model, step, control, environment, x0=x0)
    names = ("current_north", "current_east", "wind_north", "wind_east", "X", "Y", "N")
    plan = RunPlan(one, NO_TERMS._replace(**dict(zip(names, map(float, environment[0]), strict=True))))
    run = simulate(plan, "straight", step * (rudder.size - 1), rng, prescribed=half_steps(project.rudder_rad))
    scale = np.abs(project.states).max(axis=0)
    assert np.all(np.abs(run.states[:, :6] - project.states).max(axis=0) < 1e-6 * scale)


def test_gear_is_the_exact_solution(rng: np.random.Generator) -> None:
    lag, rate, angle, order = 1.0, 0.1, -0.2, 0.25
    fine, dt = angle, 1e-5
    for _ in range(round(4.0 / dt)):
        fine += dt * np.clip((order - fine) / lag, -rate, rate)
    assert gear(angle, order, 4.0, lag, rate) == pytest.approx(fine, abs=1e-5)
    halves = gear(gear(angle, order, 1.7, lag, rate), order, 2.3, lag, rate)
    assert halves == pytest.approx(gear(angle, order, 4.0, lag, rate), abs=1e-12)


def hull(recorded: np.ndarray, half: float, **values: float) -> np.ndarray:
    chain = Chain(**values)
    limited, played = np.zeros(recorded.size), np.zeros(recorded.size)
    return np.array([at_hull(chain, half, j, recorded, limited, played) for j in range(recorded.size)])


def test_rudder_chain() -> None:
    half = 0.01
    t = half * np.arange(2000)
    rudder = 0.3 * np.sin(t)
    late = np.where(t > 0.37, 0.3 * np.sin(t - 0.37), 0.0)
    assert np.abs(hull(rudder, half, delay=0.37) - late).max() < 1e-4
    assert np.abs(hull(rudder, half, effectiveness=-0.2, offset=0.01) - (0.8 * rudder + 0.01)).max() < 1e-12
    faulty = hull(rudder, half, fault=-0.5, fault_time=10.0)
    assert np.allclose(faulty, np.where(t >= 10.0 - 1e-9, 0.5, 1.0) * rudder)
    played = hull(rudder, half, play=0.02)
    assert np.abs(played - rudder).max() < 0.02 + 1e-12
    assert played.max() == pytest.approx(0.28, abs=1e-4)
    assert np.abs(np.diff(hull(rudder, half, rate_limit=0.1))).max() < 0.1 * half + 1e-12
    assert hull(rudder, half, saturation=0.2).max() == pytest.approx(0.2)


def test_gusts_have_their_variance_and_correlation(rng: np.random.Generator) -> None:
    one, gusts = ship("mariner"), Gusts(0.01, 5.0, True)
    found = gust_forces(one, gusts, 0.5, 100_000, rng)
    assert found.std(axis=0) == pytest.approx(gust_sd(one, gusts), rel=0.1)
    lagged = np.mean(found[10:, 2] * found[:-10, 2]) / np.mean(found[:, 2] ** 2)
    assert lagged == pytest.approx(np.exp(-1.0), abs=0.08)


def test_step_size_does_not_matter(rng: np.random.Generator) -> None:
    """Half the step changes an injected run by less than a hundredth of the sensors' noise."""
    one = ship("mariner")
    plan = RunPlan(one, NO_TERMS._replace(current_north=0.3, Nrr=-1e-4), Chain(delay=0.33, play=0.01))
    coarse = simulate(plan, "sine:20deg/80s", 300.0, rng)
    fine = simulate(plan, "sine:20deg/80s", 300.0, rng, prescribed=None, step_s=0.5 * one.step_s)
    assert np.abs(coarse.states[:, 5] - fine.states[::2, 5]).max() < np.deg2rad(0.01)
    assert np.abs(coarse.states[:, 3:5] - fine.states[::2, 3:5]).max() < 0.05


def test_the_truth_shares_no_code_with_the_kernels() -> None:
    """Of the models and datasets only errors, vessel files, records, texts of manoeuvres, the search for a folder's
    classes and the compiler's decorator are used."""
    folder = Path(faults.__file__).parent
    text = "\n".join(path.read_text() for path in folder.rglob("*.py"))
    rooms = set(re.findall(r"^\s*from \.{3,4}((?:models|datasets|checks|estimation|diagnosis)\S*)", text, re.MULTILINE))
    plain = {"models.errors", "models.vessel", "datasets.record", "datasets.manoeuvres"}
    assert rooms == plain | {"models.compilation", "models.discovery"}
    assert set(re.findall(r"models\.compilation import (.+)", text)) == {"njit", "callback"}
