"""Table 4: what the observers make of the heading, and which noise the table can have been made with."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ....estimation.observers.linear import Discrete, discretised, respond
from ....estimation.observers.smoothing import SmoothedTrack, Walk, random_walk, smoothed
from ....methods import eso_rw_lssvr as eso
from ...claims.files import published
from ..study import StudyResult
from . import vessels
from .vessels import DT, SineMotion, rms

STATES = ("psi", "r", "psi_ddot", "delta")
LEVELS = (0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4)
"""Standard deviations [rad] of the heading's noise that are tried, for the paper prints none."""
POWERS = np.arange(-22.0, 1.0, 1.0)
"""Powers of ten of the Kalman filter's process noise, in samples and in units of the heading's noise."""
OMEGAS = np.geomspace(0.05, 20.0, 27)
WIDE_POWERS, WIDE_OMEGAS = np.arange(-22.0, 9.0, 2.0), np.append(np.geomspace(0.05, 30.0, 16), 45.0)
"""The same where all levels of noise are compared; 45 rad/s is the paper's."""
DRAWN = 600
COMPARED = 1e-4
LOST = 0.5
"""A state is not estimated where the error is larger than this share of its standard deviation."""
CLOSE = 0.5
"""Relative difference up to which an RMSE counts as the published one."""
CROSSED = np.power(10.0, np.arange(-14.0, -2.0))
"""Heading noise [rad] at which observer and Kalman filter are compared."""


def table_4_rmse(vessel: str) -> np.ndarray:
    """The ESO column of Table 4 (4,), rad, rad/s, rad/s2 and rad."""
    return np.array([published("003")[f"t4-eso-{vessel}-rmse-{name}"] for name in STATES])


def table_4(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """RMSE and R^2 of the observer at the noise and excitation that come closest to the table's ESO columns."""
    noise = rng.normal(size=vessels.samples(vessel))
    values: dict[str, float] = {}
    for variant in ("corrected", "as_printed"):
        sines, level = _closest(vessel, variant, noise)
        truth = vessels.motion(vessel, sines, "euler")
        seen = observed(variant, truth.psi + level * noise, truth, vessel)
        values |= scores(f"{variant}_eso", seen, truth, vessel)
    return StudyResult(values, _series(vessel))


def observed(variant: str, psi: np.ndarray, run: SineMotion, vessel: str) -> tuple[np.ndarray, ...]:
    """Estimates (N,) of psi, r, psi_ddot and rudder by `vessels.seen`."""
    seen = vessels.seen(variant, psi, run, vessel)
    return seen.psi, seen.r, seen.psi_ddot, _rudder(seen.psi, run, vessel) if seen.delta is None else seen.delta


def _rudder(psi: np.ndarray, run: SineMotion, vessel: str) -> np.ndarray:
    """Rudder (N,) behind its lag when the helmsman steers by headings psi (N,)."""
    n = vessels.numbers(vessel)
    lag = discretised([[-1.0 / n.lag]], [[n.kp / n.lag]], DT, "euler")
    return respond(lag, (run.reference - psi)[:, None], [0.0])[:, 0]


def _truth(run: SineMotion) -> tuple[np.ndarray, ...]:
    return run.psi, run.r, run.psi_ddot, run.delta


def _closest(vessel: str, variant: str, noise: np.ndarray) -> tuple[str, float]:
    """Excitation and noise at which the four RMSE are closest to the table's, in logarithms."""
    best = ("S1", 0.0, np.inf)
    for sines in ("S1", "S3"):
        truth = vessels.motion(vessel, sines, "euler")
        for level in LEVELS:
            seen = observed(variant, truth.psi + level * noise, truth, vessel)
            found = np.array([rms(a - b) for a, b in zip(seen, _truth(truth), strict=True)])
            misfit = float(np.sum(np.log(np.maximum(found, 1e-17) / table_4_rmse(vessel)) ** 2))
            best = min(best, (sines, level, misfit), key=lambda entry: entry[2])
    return best[:2]


def scores(prefix: str, seen: tuple[np.ndarray, ...], run: SineMotion, vessel: str) -> dict[str, float]:
    """RMSE and R^2 of every state, and whether all four RMSE are within `CLOSE` of the table's ESO column."""
    found: dict[str, float] = {}
    for name, estimate, truth in zip(STATES, seen, _truth(run), strict=True):
        error = rms(estimate - truth)
        found |= {f"{prefix}_rmse_{name}": error, f"{prefix}_r2_{name}": 1.0 - (error / float(np.std(truth))) ** 2}
    errors = np.array([found[f"{prefix}_rmse_{name}"] for name in STATES])
    return found | {f"{prefix}_all": bool((np.abs(errors / table_4_rmse(vessel) - 1.0) <= CLOSE).all())}


@lru_cache(maxsize=64)
def kalman(level: float) -> Discrete:
    """Steady-state Kalman filter of the chain psi, r, psi_ddot, psi_dddot driven by white noise, in samples.

    level : intensity of that noise in units of the heading's; the heading's samples are the input.
    """
    from scipy.linalg import solve_discrete_are

    f, q = random_walk(4, level)
    h = np.array([[1.0, 0.0, 0.0, 0.0]])
    scale = np.array([level ** (k / 8.0) for k in range(4)])  # states of like size: a well conditioned equation
    ahead = np.asarray(
        solve_discrete_are((f / scale[:, None] * scale).T, h.T, q / np.outer(scale, scale), np.eye(1)), float
    )
    gain = (ahead @ h.T / (1.0 + ahead[0, 0])) * scale[:, None]
    return Discrete((np.eye(4) - gain @ h) @ f, np.zeros((4, 1)), gain)


def _kalman_states(psi: np.ndarray, level: float) -> np.ndarray:
    start = np.array([psi[0], 0.0, 0.0, 0.0])
    return respond(kalman(level), psi[:, None], start)[:, :3] / DT ** np.arange(3.0)


def _series(vessel: str) -> dict[str, np.ndarray]:
    """Three sines without noise, thinned: the truth and what both forms of the observer make of it."""
    run = vessels.motion(vessel, "S3", "euler")
    step = max(1, len(run.psi) // DRAWN)
    found = {f"true_{name}": values[::step] for name, values in zip(STATES, _truth(run), strict=True)}
    for variant in ("corrected", "as_printed"):
        seen = observed(variant, run.psi, run, vessel)
        found |= {f"{variant}_{name}": values[::step] for name, values in zip(STATES, seen, strict=True)}
    return found | {"time": DT * step * np.arange(len(run.psi[::step]))}


def observers(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Equal knowledge and 1e-4 rad of noise: the best ESO, Kalman filter and smoother for each state, by the truth."""
    run = vessels.motion(vessel, "S3")
    psi = run.psi + COMPARED * rng.normal(size=len(run.psi))
    settled = len(psi) // 10
    errors = {"eso": _best_eso(psi, run, settled)[0], "kf": np.full(3, np.inf), "rts": np.full(3, np.inf)}
    for power in POWERS:
        states = _kalman_states(psi, 10.0**power)
        errors["kf"] = np.minimum(errors["kf"], _errors(states, run, settled))
    for power in POWERS[::2]:
        whole = smoothed(SmoothedTrack(psi[:, None], (0,)), Walk(4, 10.0**power, np.array([1.0]), 0.0))
        errors["rts"] = np.minimum(errors["rts"], _errors(whole[:, :3] / DT ** np.arange(3.0), run, settled))
    values = {}
    for k, name in enumerate(STATES[:3]):
        values[f"rts_{name}"] = errors["eso"][k] / errors["rts"][k]
    ratios = errors["kf"] / errors["eso"]
    values["eso_over_kf_r"] = 1.0 / ratios[1]
    spread = np.array([np.std(motion[settled:]) for motion in (run.psi, run.r, run.psi_ddot)])
    values["kf_loses_a_state"] = bool((errors["kf"] > LOST * spread).any())
    values |= {"eso_beats_kf": bool((ratios > 1.0).all()), "kf_worst": float(ratios.max())}
    return StudyResult(values | {"kf_best": float(ratios.min())} | _optimal(run, rng, settled))


def crossover(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """The best ESO against the best Kalman filter, by the truth, at one heading noise after the other.

    In a simulation by Euler steps (eq 11), by which the observer steps as well, and, at some levels, solved exactly.

    crossover : the largest noise [rad] up to which the observer has the smaller error in yaw rate and yaw acceleration,
        the states that are not measured, under Euler steps; nan where it is worse at the smallest;  eso_beats_kf :
        whether there is one, there or where all is solved exactly.
    """
    draw = rng.normal(size=vessels.samples(vessel))
    found: dict[str, float] = {}
    for hold, method, levels in (("euler", "euler", CROSSED), ("zero", "exact", CROSSED[::3])):
        run = vessels.motion(vessel, "S3", hold)
        wins = [_filter_over_observer(run, run.psi + level * draw, method)[1:] > 1.0 for level in levels]
        found[method] = _up_to(np.all(wins, axis=1), levels)
    return StudyResult({"crossover": found["euler"], "eso_beats_kf": bool(np.isfinite([*found.values()]).any())})


def _filter_over_observer(run: SineMotion, psi: np.ndarray, method: str) -> np.ndarray:
    """Errors (3,) of the best Kalman filter over those of the best observer, state by state."""
    settled = len(psi) // 10
    filtered = np.min([_errors(_kalman_states(psi, 10.0**p), run, settled) for p in WIDE_POWERS], axis=0)
    return filtered / _best_eso(psi, run, settled, WIDE_OMEGAS, method)[0]


def _up_to(wins: np.ndarray, levels: np.ndarray) -> float:
    """The largest of ascending levels up to which every one is won; nan where the first is not."""
    lost = np.flatnonzero(~wins)
    n = int(lost[0]) if lost.size else len(wins)
    return float(levels[n - 1]) if n else float("nan")


def _errors(states: np.ndarray, run: SineMotion, settled: int) -> np.ndarray:
    """RMSE (3,) of states (N, 3) without the start."""
    truth = np.column_stack([run.psi, run.r, run.psi_ddot])
    return np.sqrt(np.mean((states - truth)[settled:] ** 2, axis=0))


def _best_eso(
    psi: np.ndarray, run: SineMotion, settled: int, omegas: np.ndarray = OMEGAS, method: str = "exact"
) -> tuple[np.ndarray, np.ndarray]:
    """Smallest RMSE (3,) over omega0, and the omega0 (3,) where each is."""
    table = []
    for omega in omegas:
        seen = eso.observe(psi, DT, float(omega), method)
        table.append(_errors(np.column_stack([seen.psi, seen.r, seen.psi_ddot]), run, settled))
    found = np.array(table)
    return found.min(axis=0), omegas[found.argmin(axis=0)]


def _optimal(run: SineMotion, rng: np.random.Generator, settled: int) -> dict[str, float]:
    """The observer's best omega0 for the yaw rate at 1e-6 .. 1e-2 rad of noise."""
    found = {}
    for power in range(-6, -1):
        psi = run.psi + 10.0**power * rng.normal(size=len(run.psi))
        found[f"omega_r_{-power}"] = float(_best_eso(psi, run, settled)[1][1])
    return found
