"""Paper 002: fast convergent iterative learning least squares (FCI-LS) on nonlinear response models, and a tank test.

"Gaussian white noise of variance 0.05 was added into the model" is read as (deg/s)^2 on the right side of the
differential equation, new at each sample: on the measured yaw rate every method of the paper fails.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from ....datasets import measured
from ....datasets.record import Record
from ....estimation.estimates.estimate import Estimate
from ....estimation.judgement.convergence import convergence, parameter_paths
from ....estimation.records.series import MEASURED, series_of
from ....estimation.results.predictor import ModelPredictor
from ....estimation.run.squares import squares
from ....models.model import CHANNELS, Model, resolve
from ....models.simulate import initial_state, simulate
from ...claims.files import published
from ..study import PaperStudy, StudyResult, fitted, settings_at

STEP_S, DURATION_S = 0.1, 200.0
NOISE_SD = float(np.deg2rad(np.sqrt(0.05)))
BAND = 0.05
NEVER = float("nan")
"""Settling time of a parameter that does not settle: no number, neither above nor below any."""
SETTINGS = {
    "gamma": 1e6, "beta": 0.005, "sigma": 0.001, "N_max": 200.0, "dt": STEP_S, "tank.gamma": 1e3, "rudder": 5.0,
    "heading": 10.0,
}  # fmt: skip
"""Settings of Section IV and V in use."""
BASIC = "rls,scheme=forward,p0=1e6"
FCI = "fci-ls,scheme=forward,p0=1e6,beta=0.005,most=200,tolerance=0.001"
PRINTED = FCI + ",variant=as_printed,degrees=true"
WITHOUT_BETA = FCI.replace("beta=0.005", "beta=0")


def zigzag(name: str, noise: np.ndarray | None = None, rate: float = np.inf, lag: float = 0.0) -> Record:
    """5/10 zigzag of a vessel, the rudder held and one RK4 step a sample; `noise` (N,) on the right side, rad/s.

    rate, lag : of the steering gear, rad/s and s; the recorded rudder is the true one.
    """
    model = replace(resolve(name), max_step_s=STEP_S)
    psi, n = model.states.index("psi"), round(DURATION_S / STEP_S)
    extra = _as_rudder(model, np.zeros(n) if noise is None else noise)
    follow = 1.0 if lag <= 0.0 else 1.0 - np.exp(-STEP_S / lag)
    states, rudder, side = [initial_state(model)], np.zeros(n + 1), 1.0
    for k in range(n):
        if side * states[k][psi] >= np.deg2rad(10.0):
            side = -side
        if k:
            move = (side * np.deg2rad(5.0) - rudder[k - 1]) * follow
            rudder[k] = rudder[k - 1] + np.clip(move, -rate * STEP_S, rate * STEP_S)
        states.append(simulate(model, [[rudder[k] + extra[k]]] * 2, STEP_S, states[k], hold="zero")[1])
    seen = {CHANNELS[s]: np.array(states)[:, model.states.index(s)] for s in ("r", "psi")}
    return Record(STEP_S * np.arange(n + 1), {"rudder_rad": rudder, **seen}, name=f"{name} 5/10")


def _as_rudder(model: Model, noise: np.ndarray) -> np.ndarray:
    """The unseen rudder angle, held over each step, that forces the model as `noise` (N,) on the right side does.

    With a lead T3 the impulse of each of its steps counts too: T3 (d(k) - d(k-1)) + dt d(k) = dt noise(k)/K.
    """
    gain, lead = model.parameters["K"], model.parameters.get("T3", 0.0)
    angle, last = np.zeros(noise.size), 0.0
    for k in range(1, noise.size):
        last = angle[k] = (lead * last + STEP_S * noise[k] / gain) / (lead + STEP_S)
    return angle


def found(estimate: Estimate | None, model: Model) -> dict[str, float]:
    """Published parameters, nan of a failed fit."""
    return dict.fromkeys(model.parameters, np.nan) if estimate is None else estimate.parameters


# ------------------------------------------------------------------------------------------------ Tables I and II


Map = Callable[[Mapping[str, float]], dict[str, float]]


def printed_first(p: Mapping[str, float]) -> dict[str, float]:
    """Eq 4 as printed: T = (1 - a1)/dt is 1/T, and alpha = -a2 T/dt, K = b1 T/dt take it over."""
    return {"T": 1.0 / p["T"], "K": p["K"] / p["T"] ** 2, "alpha": p["alpha"] / p["T"] ** 2}


def printed_second(p: Mapping[str, float]) -> dict[str, float]:
    """Eq 6 as printed: alpha = -a3 h, without dt^2."""
    return {**p, "alpha": p["alpha"] * STEP_S**2}


FORMS = {"first_order": ("response-1", printed_first), "second_order": ("response-2", printed_second)}
"""Table I with Figure 1, and Table II with Figure 2."""


def in_noise(order: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """The table of an order."""
    name, printed = FORMS[order]
    return table(name, printed, zigzag(name, NOISE_SD * rng.normal(size=round(DURATION_S / STEP_S))))


def table(name: str, printed: Map, record: Record, as_printed: str = PRINTED) -> StudyResult:
    """What every method finds in a record, its ratio of errors to the basic method's, and when it settles."""
    model = resolve(name)
    specs = {"basic": BASIC, "fci": FCI, "fci.printed": as_printed, "fci.without": WITHOUT_BETA}
    fits = {key: fitted(spec, [record], model) for key, spec in specs.items()}
    values, series = {}, {}
    for key, fit in fits.items():
        values |= {f"{key}.{p}": value for p, value in found(fit, model).items()}
        values |= {f"{key}.time.{p}": seconds for p, seconds in _settling(fit, model).items()}
        series |= {f"{key}.{p}": path for p, path in _paths(fit, model).items()}
    values |= {f"basic.printed.{p}": value for p, value in printed(found(fits["basic"], model)).items()}
    for key in ("fci", "fci.printed", "fci.without"):
        errors = _errors(fits[key], model), _errors(fits["basic"], model)
        ratios = {p: errors[0][p] / errors[1][p] for p in model.parameters}
        values |= {f"{key}.ratio.{p}": ratio for p, ratio in ratios.items()}
        values[f"{key}.ratio"] = float(np.median([*ratios.values()]))
        values[f"{key}.better"] = all(ratio < 1.0 for ratio in ratios.values())
    return StudyResult(values, series)


def _errors(fit: Estimate | None, model: Model) -> dict[str, float]:
    return {p: abs(value - model.parameters[p]) for p, value in found(fit, model).items()}


def _settling(fit: Estimate | None, model: Model) -> dict[str, float]:
    """Seconds until a parameter stays within 5 % of the set value; `NEVER` where it does not within the record."""
    if fit is None:
        return dict.fromkeys(model.parameters, NEVER)
    times = {p: settled[BAND] for p, (settled, _) in convergence(fit, model.parameters, [BAND]).items()}
    return {p: seconds if seconds <= DURATION_S else NEVER for p, seconds in times.items()}


def _paths(fit: Estimate | None, model: Model) -> dict[str, np.ndarray]:
    """Relative errors of the parameters along the recursion, every second."""
    if fit is None:
        return {}
    return {p: path[::10] / model.parameters[p] - 1.0 for p, path in parameter_paths(fit).items()}


def noise_free(rng: np.random.Generator, *, index: int) -> StudyResult:
    """The same without noise: what the difference equation and the maps (4) and (6) leave."""
    specs = {
        "ls": "ls-forward",
        "zoh": "ls,scheme=zoh",
        "radians": "fci-ls,variant=as_printed,beta=0,most=1,p0=1e6",
    }
    values = {}
    for name in ("response-1", "response-2"):
        model, record = resolve(name), zigzag(name)
        for key, spec in specs.items():
            estimate = fitted(spec, [record], model)
            values |= {f"{name}.{key}.{p}": value for p, value in found(estimate, model).items()}
    return StudyResult(values)


def noise(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Error of K against the size of the noise on the right side, of the basic and the iterated method."""
    model = resolve("response-1")
    size = np.deg2rad(np.geomspace(1e-3, 0.3, 7))
    draw = rng.normal(size=round(DURATION_S / STEP_S))
    series: dict[str, list[float]] = {"basic": [], "without": [], "fci": [], "fci.printed": []}
    for sd in size:
        record = zigzag("response-1", sd * draw)
        for key, spec in zip(series, (BASIC, WITHOUT_BETA, FCI, PRINTED), strict=True):
            series[key].append(_errors(fitted(spec, [record], model), model)["K"] / model.parameters["K"])
    lines = {key: np.array(line) for key, line in series.items()}
    return StudyResult({}, lines | {"sd_deg_s": np.rad2deg(size)})


def arithmetic(rng: np.random.Generator, *, index: int) -> StudyResult:
    """The error columns of both tables from their other columns: I is identified - set, II set - identified."""
    printed, values = published("002"), {}
    for table, name, sign in (("table1", "response-1", 1.0), ("table2", "response-2", -1.0)):
        for p, truth in resolve(name).parameters.items():
            values |= {f"{table}.{c}.{p}": sign * (printed[f"{table}-{c}-{p}"] - truth) for c in ("basic", "fci")}
    return StudyResult(values | SETTINGS | _set_values())


def _set_values() -> dict[str, float]:
    """Set values of both vessels, initial values of the recursion, and 1 - dt/T at the printed initial T = 0."""
    values = {f"{name}.{p}": v for name in ("response-1", "response-2") for p, v in resolve(name).parameters.items()}
    with np.errstate(divide="ignore"):
        values["a1 at T = 0"] = bool(np.isfinite(1.0 - np.divide(STEP_S, 0.0)))
    return values


# ------------------------------------------------------------------------------------------------ the step beta


def beta(rng: np.random.Generator, *, index: int) -> StudyResult:
    """How large the P-type step may be: the printed bound 2 gamma against 2/|phi|^2."""
    model, record = resolve("response-1"), zigzag("response-1")
    shares = np.array([0.001, 0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2])
    values, series = {}, {"share": shares}
    for unit, degrees in (("rad", False), ("deg", True)):
        bound = 2.0 / _largest_row(record, degrees)
        errors = [_iterated(record, model, share * bound, degrees) for share in shares]
        values[f"{unit}.bound"] = bound
        values[f"{unit}.limit"] = bound * float(shares[np.isfinite(errors)].max())
        series[unit] = np.array(errors)
    values["rad.300"] = not np.isfinite(_iterated(record, model, 300.0, False))
    values["deg.0.08"] = not np.isfinite(_iterated(record, model, 0.08, True))
    values["rad.2gamma"] = bool(np.isfinite(_iterated(record, model, 2e6, False)))
    safe = fitted("fci-ls,scheme=forward,beta=2e6,p0=1e6", [record], model)
    values["corrected.2gamma"] = bool(safe is not None and np.isfinite(safe.coefficients).all())
    series["corrected"] = np.array([_corrected(record, model, share) for share in shares])
    return StudyResult(values, series)


def _largest_row(record: Record, degrees: bool) -> float:
    """Largest |phi|^2 of the rows [r, r^3, delta]."""
    unit = np.rad2deg(1.0) if degrees else 1.0
    r, delta = unit * record.column("yaw_rate_rad_s"), unit * record.rudder()
    return float((r**2 + r**6 + delta**2).max())


def _iterated(record: Record, model: Model, step: float, degrees: bool) -> float:
    """Relative error of K after FCI-LS as printed with all 200 repeats; nan where it diverges."""
    spec = f"fci-ls,variant=as_printed,degrees={str(degrees).lower()},tolerance=0,most=200,beta={float(step)!r}"
    return _errors(fitted(spec, [record], model), model)["K"] / model.parameters["K"]


def _corrected(record: Record, model: Model, share: float) -> float:
    """As `_iterated`, of the corrected form, whose columns have unit root mean square."""
    spec = f"fci-ls,scheme=forward,tolerance=0,most=200,p0=1e6,beta={float(share) * 2.0 / len(model.coordinates)!r}"
    return _errors(fitted(spec, [record], model), model)["K"] / model.parameters["K"]


# ---------------------------------------------------------------------------------------- over what is not printed


def over_range(order: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Run `index` of the search of an order; its noise belongs to the point, not to the seed."""
    chosen = settings_at("002", f"{order}_searched", index)
    name, printed = FORMS[order]
    draw = np.random.default_rng(index).normal(size=round(DURATION_S / STEP_S))
    noise = np.deg2rad(chosen["noise on the right side"]) * draw
    record = zigzag(name, noise, np.deg2rad(chosen["rudder rate"]), chosen["rudder lag"])
    form = PRINTED if chosen["angles in"] == "degrees" else PRINTED.replace("degrees=true", "degrees=false")
    return StudyResult(table(name, printed, record, form).values)


# ------------------------------------------------------------------------------------------------ the tank test

DATASET, TRAINING = "kvlcc2-hsva", "Z_15_05"
HELD_OUT = {"25/5": "Z_25_05", "10/10 P": "Z_10_10_P", "10/10 S": "Z_10_10_S"}
TANK = "fci-ls,scheme=forward,p0=1e3,beta=0.005,most=200,tolerance=0.001"
FITS = {
    "integrator": ("output-error", "integrator", 1),
    "ls": ("ls-forward", "nomoto-1-cubic", 1),
    "ls .5 s": ("ls-forward", "nomoto-1-cubic", 10),
    "oe": ("output-error", "nomoto-1-cubic", 1),
    "oe-2": ("output-error", "nomoto-2", 1),
    "oe-2-speed": ("output-error", "nomoto-2-quadratic-speed", 1),
    "fci": (TANK, "nomoto-1-cubic", 1),
    "fci.radians": (TANK + ",variant=as_printed", "nomoto-1-cubic", 1),
    "fci.degrees": (TANK + ",variant=as_printed,degrees=true", "nomoto-1-cubic", 1),
}
"""Name -> method, model, and every how many samples (0.05 s) of the record."""


def tank(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Fitted to the 15/5 zigzag, predicting others from their measured rudder.  Statistics only, no measured series.

    Raises `BadInput` where the measured set is not there, with how to get it.
    """
    training = measured.load(DATASET, TRAINING)
    runs = {run: measured.load(DATASET, stem) for run, stem in HELD_OUT.items()}
    values, series = {}, {}
    for name, (spec, family, stride) in FITS.items():
        model = resolve(family)
        estimate = fitted(spec, [training.thinned(stride)], model)
        values |= {f"{name}.{p}": value for p, value in found(estimate, model).items()}
        scores = dict(_scores(estimate, runs | {"15/5": training}))
        values |= {f"{name}.{key}": value for key, value in scores.items()}
        series[f"r2.{name}"] = np.array([scores[f"{run}.r2"] for run in runs])
        if name == "fci.radians" and estimate is not None:
            series |= _course(estimate)
    values |= _approach(training)
    values["fci.good"] = bool(values["fci.25/5.r2"] > values["integrator.25/5.r2"])
    values["fci.radians.good"] = bool(values["fci.radians.25/5.r2"] > values["integrator.25/5.r2"])
    return StudyResult(values, series)


def _approach(record: Record) -> dict[str, float]:
    """Speed (m/s) and propeller in the first second, and the rate (deg/s, 99 % quantile) at which the rudder moves."""
    begin = record.time_s <= record.time_s[0] + 1.0
    rate = np.abs(np.gradient(np.rad2deg(record.rudder()), record.time_s))
    speed = np.hypot(record.column("surge_m_s"), record.column("sway_m_s"))
    return {
        "approach.speed": float(np.mean(speed[begin])),
        "approach.propeller_rps": float(np.mean(record.column("propeller_rps")[begin])),
        "approach.rudder_rate": float(np.quantile(rate, 0.99)),
    }


def _scores(estimate: Estimate | None, runs: Mapping[str, Record]) -> Iterator[tuple[str, float]]:
    """R^2 and RMSE (deg/s) of the yaw rate and RMSE of the heading (deg) of each run, which begins with the first
    sample as it was measured, as the paper's do."""
    for run, record in runs.items():
        rmse, r2 = {"r": np.nan, "psi": np.nan}, np.nan
        if estimate is not None:
            errors = {state: squares(*pair) for state, pair in _from_the_first_sample(estimate.model, record).items()}
            rmse, r2 = {state: error.scores()[0] for state, error in errors.items()}, errors["r"].scores()[1]
        yield f"{run}.r2", r2
        yield f"{run}.r", float(np.rad2deg(rmse["r"]))
        yield f"{run}.psi", float(np.rad2deg(rmse["psi"]))


def _from_the_first_sample(model: Model, record: Record) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """State -> samples (N,) of yaw rate and heading, measured and of the free run."""
    series = series_of(record.turned(model.positive_rudder), model, MEASURED)
    states = series.observe(ModelPredictor(model).simulate(series.inputs, series.dt, series.start))
    measured = {model.states[state]: series.outputs[:, place] for place, state in enumerate(series.columns)}
    return {state: (measured[state], states[:, model.states.index(state)]) for state in ("r", "psi")}


def _course(estimate: Estimate) -> dict[str, np.ndarray]:
    """Parameters along the recursion, every second."""
    time = estimate.trajectory_time_s
    assert time is not None
    return {"time_s": time[::20]} | {f"course.{p}": path[::20] for p, path in parameter_paths(estimate).items()}


STUDIES = {
    **{order: PaperStudy(partial(in_noise, order), seeds=120) for order in FORMS},
    "noise_free": PaperStudy(noise_free),
    "noise": PaperStudy(noise, seeds=8, drawn=8),
    "arithmetic": PaperStudy(arithmetic),
    "beta": PaperStudy(beta),
    "tank": PaperStudy(tank, measured=DATASET),
    **{f"{order}_searched": PaperStudy(partial(over_range, order), seeds=48) for order in FORMS},
}
