"""Tables 5 and 6: parameters behind the observer, and the predictions of the identified models."""

from __future__ import annotations

import re
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from ....estimation.information.bounds import cramer_rao
from ....estimation.methods_only.svr import LSSVR
from ....methods import eso_rw_lssvr as eso
from ....methods.base import Method
from ....methods.eso_rw_lssvr import EsoRwLssvr
from ....methods.filtered_ls import SvfLs
from ....models.errors import CannotFit, FitFailed
from ....models.linear_algebra import svd
from ....models.model import Model, resolve
from ...claims.files import published
from ..study import StudyResult
from . import vessels
from .vessels import DT, TRAINING, SineMotion, percent, rms

NOISE = (1e-4, 1e-3)
"""Heading noise [rad], for the paper prints none: another level in this range each run, spread logarithmically."""
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
PARAMETERS = ("T1", "T2", "T3", "K")
POINTS = 1.0
"""Percentage points within which all four errors of a column must agree to count as the same result."""
DRAWN = 600
PREDICTS = 0.9
"""R^2 that a model must have for its error to be compared with another's."""


WEIGHTED = {"rw": True, "ls": False}
"""Both methods behind the observer: with weights and without outliers, or plain."""


def tables_5_and_6(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Both methods on one noisy run of three sines, corrected and as printed."""
    return on_sines(vessel, "S3", noise_of(index), rng)


def noise_of(index: int) -> float:
    """Heading noise of a run, rad: evenly spread over the logarithm of `NOISE`."""
    low, high = np.log(NOISE)
    return float(np.exp(low + (index * GOLDEN + 0.5) % 1.0 * (high - low)))


def on_sines(vessel: str, sines: str, level: float, rng: np.random.Generator) -> StudyResult:
    """The same on any sines, with heading noise of standard deviation `level`, rad."""
    model, run = resolve(vessel), vessels.noisy(vessels.record(vessel, sines), level, rng)
    truth, values, series = _validation(vessel, sines), {}, {}
    errors: dict[tuple[str, str], np.ndarray] = {}
    for variant in ("corrected", "as_printed"):
        omega = None
        for method, weighted in WEIGHTED.items():
            own = EsoRwLssvr(omega0=omega, weighted=weighted, variant=variant)
            coefficients, omega = _fitted(own, run, model)
            errors[variant, method] = percent(model, coefficients)
            found = dict(zip(PARAMETERS, model.to_parameters(coefficients).tolist(), strict=True))
            values |= {f"{variant}_{method}_{name}": value for name, value in found.items()}
            near = np.abs(errors[variant, method] - percent(model, _printed(vessel, method))).max()
            values[f"{variant}_{method}_near"] = bool(near <= POINTS)
            predicted = _rows(truth) @ coefficients
            values |= _scores(f"{variant}_{method}", predicted, truth.psi_dddot)
            series[f"{variant}_{method}"] = _thinned(predicted)
        better = np.abs(errors[variant, "rw"]) < np.abs(errors[variant, "ls"])
        values[f"{variant}_rw_better"] = bool(better.all())
        ratio = values[f"{variant}_rw_rmse"] / values[f"{variant}_ls_rmse"]
        values[f"{variant}_rw_over_ls"] = ratio
        values[f"{variant}_rw_predicts_better"] = ratio < 1.0 and values[f"{variant}_rw_r2"] > PREDICTS
    series |= {"truth": _thinned(truth.psi_dddot), "time": _thinned(DT * np.arange(len(truth.psi)))}
    series["table_5"] = _thinned(_rows(truth) @ _printed(vessel, "rw"))
    return StudyResult(values, series)


def _fitted(method: Method, run: Any, model: Model) -> tuple[np.ndarray, float | None]:
    """Coefficients (4,), nan where the fit fails, and the observer's poles."""
    try:
        found = method.fit([run], model)
    except (CannotFit, FitFailed):
        return np.full(4, np.nan), None
    return found.coefficients, float(found.extra["omega0_rad_s"])


def table_5(vessel: str, method: str) -> np.ndarray:
    """T1, T2, T3, K (4,) as Table 5 prints them; method : rw, RW-LSSVR, or ls, LS-SVR."""
    return np.array([published("003")[f"t5-{vessel}-{method}-{name}"] for name in PARAMETERS])


def _printed(vessel: str, method: str) -> np.ndarray:
    """Coefficients (4,) of Table 5's identified parameters."""
    return resolve(vessel).from_parameters(table_5(vessel, method))


@lru_cache(maxsize=4)
def _validation(vessel: str, sines: str) -> SineMotion:
    """True states of the last 40 %."""
    whole = vessels.motion(vessel, sines)
    return SineMotion(*(values[int(TRAINING * len(values)) :] for values in whole))


def prediction_scores(vessel: str, sines: str, coefficients: np.ndarray) -> tuple[float, float]:
    """RMSE [rad/s^3] and R^2 (eq 32-33) of the third derivative on the true states of the last 40 %."""
    truth = _validation(vessel, sines)
    found = _scores("own", _rows(truth) @ coefficients, truth.psi_dddot)
    return found["own_rmse"], found["own_r2"]


def _rows(run: SineMotion) -> np.ndarray:
    """Regressors (N, 4) in the order of the coefficients."""
    return np.column_stack([run.psi_ddot, run.r, run.delta, run.delta_dot])


def _thinned(values: np.ndarray) -> np.ndarray:
    return values[:: max(1, len(values) // DRAWN)]


def _scores(prefix: str, predicted: np.ndarray, truth: np.ndarray) -> dict[str, float]:
    """RMSE and R^2 (eq 32-33)."""
    error = rms(predicted - truth)
    return {f"{prefix}_rmse": error, f"{prefix}_r2": 1.0 - (error / float(np.std(truth))) ** 2}


def arithmetic(rng: np.random.Generator, *, index: int) -> StudyResult:
    """What Tables 4 to 6 must be by their own numbers, without noise or fit."""
    values: dict[str, float] = {}
    for vessel, method in product(vessels.VESSELS, WEIGHTED):
        model = resolve(vessel)
        truth = np.array([model.parameters[name] for name in PARAMETERS])
        found = 100.0 * (table_5(vessel, method) / truth - 1.0)
        values |= {f"{vessel}_{method}_error_{name}": float(e) for name, e in zip(PARAMETERS, found, strict=True)}
    for vessel in vessels.VESSELS:
        errors = [np.abs([values[f"{vessel}_{m}_error_{p}"] for p in PARAMETERS]) for m in WEIGHTED]
        values[f"{vessel}_rw_better"] = bool((errors[0] < errors[1]).all())
        values |= of_motion(vessel, "S3")
    return StudyResult(values | _single_sines() | consistency())


def of_motion(vessel: str, sines: str) -> dict[str, float]:
    """What Tables 4 to 6 imply on a noise-free motion: R^2 of printed errors and parameters, standard deviations."""
    values, validation, run = {}, _validation(vessel, sines), vessels.motion(vessel, sines)
    for method in WEIGHTED:
        scores = _scores(f"{vessel}_{method}", _rows(validation) @ _printed(vessel, method), validation.psi_dddot)
        values[f"{vessel}_{method}_r2"] = scores[f"{vessel}_{method}_r2"]
    values[f"{vessel}_frequency"] = float(np.std(run.psi_ddot) / np.std(run.r))
    values[f"{vessel}_sd_psi_dddot"] = float(np.std(run.psi_dddot))
    values[f"{vessel}_sd_delta"] = float(np.std(run.delta))
    for name in ("psi", "r", "psi_ddot", "delta"):
        error = published("003")[f"t4-ekf-{vessel}-rmse-{name}"]
        values[f"{vessel}_ekf_r2_{name}"] = 1.0 - (error / float(np.std(getattr(run, name)))) ** 2
    return values


def consistency() -> dict[str, float]:
    """Whether the printed numbers agree with each other: text and Table 4, columns of Table 6, repeated digits."""
    printed = published("003")
    values: dict[str, float] = {
        "reversal": printed["t4-eso-cargo-r2-psi_ddot"] < printed["t4-eso-patrol-r2-psi_ddot"],
    }
    for vessel in vessels.VESSELS:
        implied = {m: _implied(printed[f"t6-{vessel}-{m}-rmse"], printed[f"t6-{vessel}-{m}-r2"]) for m in WEIGHTED}
        (low, high), (other_low, other_high) = implied["rw"], implied["ls"]
        values[f"{vessel}_same_sd"] = low <= other_high and other_low <= high
    digits = [f"{printed[name]:.4e}".split("e")[0] for name in printed if re.match(r"t4-e(so|kf)-.*-rmse-", name)]
    values["digits_differ"] = len(set(digits)) == len(digits)
    return values


def _implied(rmse: float, r2: float) -> tuple[float, float]:
    """Range of the standard deviation that belongs to a RMSE and an R^2 rounded to four digits (eq 32-33)."""
    return rmse / float(np.sqrt(1.0 - r2 + 5.0e-5)), rmse / float(np.sqrt(1.0 - r2 - 5.0e-5))


def _single_sines() -> dict[str, float]:
    """R^2 nearest to Table 6's that Table 5's parameters give in steady state under any single sine, by whose states.

    The states are the true ones, those of the corrected observer at 45 rad/s solved exactly, or by its Euler steps.
    """
    s = 1j * np.geomspace(1e-4, 30.0, 4000)
    a, b = eso.observer(eso.gains([-eso.PRINTED_OMEGA] * 4))
    stepped = eso.sampled_observer(eso.PRINTED_OMEGA, DT, "euler")
    observers = {"observed": _transfer(s, a, b), "stepped": _transfer(np.exp(s * DT), stepped.a, stepped.now)}
    found, printed = {}, published("003")
    for vessel, method in product(vessels.VESSELS, WEIGHTED):
        value = float(printed[f"t6-{vessel}-{method}-r2"])
        c = resolve(vessel).coefficients
        heading = (c[2] + c[3] * s) / (s**2 - c[0] * s - c[1]) / s
        wrong = _printed(vessel, method)
        nearest = []
        for states, gain in {"true": np.column_stack([s, s**2, s**3]), **observers}.items():
            r, r_dot, r_ddot = (gain * heading[:, None]).T
            prediction = wrong[0] * r_dot + wrong[1] * r + wrong[2] + wrong[3] * s
            r2 = 1.0 - np.abs(prediction / r_ddot - 1.0) ** 2
            nearest.append(float(r2[np.argmin(np.abs(r2 - value))]))
            found[f"{vessel}_{method}_sine_r2_{states}"] = nearest[-1]
        found[f"{vessel}_{method}_sine_r2"] = min(nearest, key=lambda own: abs(own - value))
    return found


def _transfer(points: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Yaw rate, its slope and second slope (N, 3) of a linear observer by a heading of 1, at complex points (N,)."""
    return np.linalg.solve(points[:, None, None] * np.eye(len(a)) - a, b[None, :, :1])[:, 1:, 0]


def noise_free(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Least squares behind the observers without noise, LS-SVR on the true states, and the Cramer-Rao bounds."""
    values: dict[str, float] = {}
    for vessel in vessels.VESSELS:
        model = resolve(vessel)
        for sines in ("S1", "S3"):
            for variant in ("corrected", "as_printed"):
                found = percent(model, behind_observer(vessel, sines, variant))
                values |= _named(f"{vessel}_{sines}_{variant}", found)
            record = vessels.record(vessel, sines).with_channels(yaw_rate_rad_s=None)
            first = record.slice(0, int(TRAINING * record.n))
            bound, _ = cramer_rao(model, [first], {"heading_rad": 1e-3}, initial_states=False)
            truth = model.to_parameters(model.coefficients)
            values |= _named(f"{vessel}_{sines}_bound", 100.0 * bound / np.abs(truth))
            values[f"{vessel}_{sines}_rank"] = float(_rank(vessels.motion(vessel, sines)))
    run = vessels.motion("cargo", "S3")
    n, model = int(TRAINING * len(run.psi)), resolve("cargo")
    for power in (8, 10):
        fitted = LSSVR(C=10.0**power).fit(_rows(run)[:n], run.psi_dddot[:n])
        values |= _named(f"cargo_lssvr_C{power}", np.abs(percent(model, fitted.coef_)))
    return StudyResult(values)


def _named(prefix: str, found: np.ndarray) -> dict[str, float]:
    return {f"{prefix}_{name}": value for name, value in zip(PARAMETERS, found.tolist(), strict=True)}


def behind_observer(
    vessel: str, sines: str, variant: str, noise: float = 0.0, rng: np.random.Generator | None = None
) -> np.ndarray:
    """Least squares (4,) on the first 60 % of the states that the observer gives at 45 rad/s, all stepped by Euler."""
    run = vessels.motion(vessel, sines, "euler")
    psi = run.psi if rng is None else run.psi + noise * rng.normal(size=len(run.psi))
    seen = vessels.seen(variant, psi, run, vessel)
    size = int(TRAINING * len(psi))
    rows = np.column_stack([seen.psi_ddot, seen.r, run.delta, run.delta_dot])[:size]
    return LSSVR(C=1e14, standardise=True, fit_intercept=False).fit(rows, seen.psi_dddot[:size]).coef_


def _rank(run: SineMotion) -> int:
    """Directions that the regressors span after the start-up transient (second half of a run)."""
    rows = _rows(run)[len(run.psi) // 2 :]
    sizes = svd(rows / np.linalg.norm(rows, axis=0), compute_uv=False)
    return int(np.sum(sizes > 1e-6 * sizes[0]))


def aligned(rng: np.random.Generator, *, index: int) -> StudyResult:
    """One lag for all channels (the correction): the worst parameter error of cargo S3 at 1e-4 and 1e-3 rad."""
    values, model = {}, resolve("cargo")
    for power in (4, 3):
        record = vessels.noisy(vessels.record("cargo", "S3"), 10.0**-power, rng)
        found = percent(model, SvfLs().fit([record], model).coefficients)
        values[f"worst_{power}"] = float(np.abs(found).max())
    return StudyResult(values)
