"""Tables 1 and 2 and section 3.2: what outliers and noise do to the methods."""

from __future__ import annotations

import numpy as np

from ....datasets.generator import Case, generate
from ....estimation.methods_only import svr
from ....estimation.methods_only.svr import LSSVR
from ....models.model import resolve
from ..study import StudyResult
from . import vessels
from .identification import behind_observer
from .vessels import percent

ROWS, STRIDE, SHARE = 3000, 100, 0.1
CORRECTED = LSSVR(C=1e12, standardise=True, weighting="corrected")
FORMS = {
    "ls": LSSVR(C=1e12, standardise=True),
    "printed": LSSVR(C=1e12, standardise=True, weighting="as_printed"),
    "weights": LSSVR(C=1e12, standardise=True, outliers=None, weighting="corrected"),
    "corrected": CORRECTED,
}
EFFICIENCY = {
    "converged": LSSVR(C=1e8, outliers=None, weighting="corrected"),
    "one_step": LSSVR(C=1e8, outliers=None, max_iter=1, weighting="corrected"),
    "printed": LSSVR(C=1e8, outliers=None, weighting="as_printed"),
}
FITS = 60


def outliers(rng: np.random.Generator, *, index: int) -> StudyResult:
    """10 % outliers of 10 to 20 standard deviations on psi_dddot (5 % noise): the worst parameter error in percent."""
    model, run = resolve("cargo"), vessels.motion("cargo", "S3")
    x = np.column_stack([run.psi_ddot, run.r, run.delta, run.delta_dot])[::STRIDE][:ROWS]
    y = x @ model.coefficients
    values: dict[str, float] = {}
    for kind in ("single", "burst"):
        dirty, hit = _contaminated(y, kind == "burst", rng)
        for name, regressor in FORMS.items():
            found = percent(model, regressor.fit(x, dirty).coef_)
            values[f"{name}_{kind}"] = float(np.abs(found).max())
        kept = svr.within_mad(dirty)
        values[f"removed_as_printed_{kind}"] = float(np.mean(~kept[hit]))
        values[f"removed_{kind}"] = float(np.mean(CORRECTED.weights_[hit] == 0.0))
    values["rw_over_ls_single"] = values["corrected_single"] / values["ls_single"]
    values["ls_suffers"] = values["ls_single"] > 2.0 * values["corrected_single"]
    for name in ("corrected", "printed"):
        values[f"{name}_better"] = values[f"{name}_single"] < values["ls_single"]
    return StudyResult(values)


def _contaminated(y: np.ndarray, burst: bool, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Noise and outliers on y (n,), in bursts of 30 samples or one by one; and which rows were hit."""
    n, sd = len(y), 0.05 * float(y.std())
    hit, sign = rng.random(n) < SHARE, rng.choice([-1.0, 1.0], n)
    if burst:
        hit = np.repeat(rng.permutation(n // 30) < round(SHARE * n / 30), 30)
        sign = np.repeat(rng.choice([-1.0, 1.0], n // 30), 30)
    return y + sd * rng.normal(size=n) + hit * sign * rng.uniform(10.0, 20.0, n) * sd, hit


def efficiency(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Gaussian errors: the variance of least squares over that of the weighted fits, from 60 problems."""
    squares = dict.fromkeys([*EFFICIENCY, "ls"], 0.0)
    for _ in range(FITS):
        x, y = rng.normal(size=(400, 3)), rng.normal(size=400)
        squares["ls"] += float(np.sum(LSSVR(C=1e8).fit(x, y).coef_ ** 2))
        for name, regressor in EFFICIENCY.items():
            squares[name] += float(np.sum(regressor.fit(x, y).coef_ ** 2))
    return StudyResult({name: squares["ls"] / squares[name] for name in EFFICIENCY})


def rule(rng: np.random.Generator, *, index: int) -> StudyResult:
    """The 3-MAD rule on a raw signal: rows of a clean zigzag that it drops by the slope of the rudder."""
    run = generate(Case("cargo", "zigzag:20/20", duration_s=3600.0, dt_s=1.0))
    slope = np.gradient(run.rudder(), run.dt)
    return StudyResult({"dropped_slope": float(np.mean(~svr.within_mad(slope)))})


def sensitivity(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Least squares behind the observer at 45 rad/s when the heading has noise of 1e-11 rad, corrected equations."""
    found = percent(resolve("cargo"), behind_observer("cargo", "S3", "corrected", 1e-11, rng))
    return StudyResult({"fails": not np.abs(found).max() < 50.0})
