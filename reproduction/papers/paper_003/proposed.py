"""The paper's proposal as a whole, in corrected equations: the observer's own states, C by the bee colony of Table 3.

`eso-rw-lssvr,variant=proposed` against the same with LS-SVR, and what the colony costs: evaluations, CPU time and the
least validation error after each of its cycles, beside a grid of 25 values of C.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from ....datasets.record import Record
from ....estimation.estimates.estimate import Estimate
from ....estimation.methods_only.tuning.abc import PAPER_003
from ....methods.eso_rw_lssvr import EsoRwLssvr
from ....methods.ls_svr import TunedConstant, Tuner, colony, grid
from ....models.model import Model, resolve
from ..study import StudyResult
from . import vessels
from .identification import PARAMETERS, WEIGHTED, noise_of, prediction_scores
from .vessels import percent

SOURCES = PAPER_003["n_sources"]
MOVES = SOURCES + PAPER_003["n_onlookers"]
"""Neighbours tried in a cycle."""
POLES = {"cargo": (0.1, 0.2, 0.5, 1.0, 2.0), "patrol": (1.0, 2.0, 5.0, 10.0, 20.0)}
"""Of the observer, rad/s, of which the truth picks the best."""
AFTER = (0, 1, 3, 10)
"""Cycles after which the least error is told; 0: of the first sources alone."""


class Watched:
    """A tuner that keeps the errors of its evaluations, in order."""

    def __init__(self, tuner: Tuner) -> None:
        self.tuner = tuner
        self.errors: list[float] = []

    def __call__(self, objective: Callable[[float], float], low: float, high: float) -> TunedConstant:
        def watched(c: float) -> float:
            self.errors.append(objective(c))
            return self.errors[-1]

        return self.tuner(watched, low, high)

    @property
    def best(self) -> np.ndarray:
        """Least error after every evaluation (n,)."""
        return np.minimum.accumulate(self.errors)


def proposed(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Both regressions on a noisy run of three sines of each vessel; keys VESSEL_POLES_METHOD_QUANTITY.

    POLES are 'chosen' by the method from the record, or the 'best' of `POLES`, whose model predicts best by the truth.
    """
    values, series = {}, {}
    for vessel in vessels.VESSELS:
        run = vessels.noisy(vessels.record(vessel, "S3"), noise_of(index), rng)
        for poles, omega0 in {"chosen": None, "best": _best_poles(run, vessel)}.items():
            key = f"{vessel}_{poles}"
            for method, weighted in WEIGHTED.items():
                found, best = _told(run, vessel, weighted, omega0)
                values |= {f"{key}_{method}_{name}": value for name, value in found.items()}
                series[f"{key}_{method}"] = best[SOURCES - 1 :: MOVES]
    return StudyResult(values, series)


def fitted(
    run: Record, model: Model, weighted: bool, tuner: Tuner, omega0: float | None = None
) -> tuple[Estimate, Watched]:
    """`eso-rw-lssvr,variant=proposed` with a tuner in place of its colony, and the tuner's evaluations."""
    watched = Watched(tuner)
    return EsoRwLssvr(omega0=omega0, aligned=False, weighted=weighted, tuner=watched).fit([run], model), watched


def _best_poles(run: Record, vessel: str) -> float:
    """Poles [rad/s] behind which plain LS-SVR predicts the true third derivative best."""

    def error(omega0: float) -> float:
        found, _ = fitted(run, resolve(vessel), False, grid, omega0)
        return prediction_scores(vessel, "S3", found.coefficients)[0]

    return min(POLES[vessel], key=error)


def _told(run: Record, vessel: str, weighted: bool, omega0: float | None) -> tuple[dict[str, float], np.ndarray]:
    """Errors and cost of the fit, and the colony's least error after every evaluation."""
    model, begin = resolve(vessel), time.process_time()
    found, watched = fitted(run, model, weighted, colony, omega0)
    seconds = time.process_time() - begin
    best = watched.best
    _, spaced = fitted(run, model, weighted, grid, found.extra["omega0_rad_s"])
    r2 = prediction_scores(vessel, "S3", found.coefficients)[1]
    errors = zip(PARAMETERS, np.abs(percent(model, found.coefficients)).tolist(), strict=True)
    values = {f"error_{name}": error for name, error in errors}
    values |= {"r2": r2, "C": found.extra["C"], "omega0": found.extra["omega0_rad_s"]}
    values |= {"evaluations": float(best.size), "cpu_s": seconds, "excess_grid": _excess(float(spaced.best[-1]), best)}
    values |= {f"excess_{cycle}": _excess(float(best[SOURCES + cycle * MOVES - 1]), best) for cycle in AFTER}
    return values, best


def _excess(error: float, best: np.ndarray) -> float:
    """How far an error is above the colony's last, in percent."""
    return float(100.0 * (error / best[-1] - 1.0))
