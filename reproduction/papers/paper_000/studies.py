"""The computations of paper 000: FW-RLS on the K-T equation of the REMUS vehicle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....bench.kinds.identification.problems import derived_parameters
from ....datasets.generator import Case, generate, record_run
from ....datasets.manoeuvres import parse_manoeuvre
from ....datasets.record import Record
from ....estimation.estimates.estimate import Estimate
from ....estimation.information.bounds import cramer_rao
from ....estimation.judgement.convergence import overshoot, parameter_paths, settling_time
from ....methods.base import Method
from ....methods.registry import make
from ....models.model import Model, resolve
from ...claims.files import published
from ..study import PaperStudy, StudyResult, settings_at
from . import records
from .records import ORDER, STEP_S, vehicle

PRIOR = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}
METHODS = {
    "rls": ("rls", PRIOR),
    "fw": ("fw-rls", {**PRIOR, "mu": 0.999, "weight": 20.0}),
    "printed": ("fw-rls", {**PRIOR, "mu": 0.999, "weight": 20.0, "variant": "as_printed"}),
    "wide": ("rls", {**PRIOR, "p0": 20.0 * PRIOR["p0"]}),
    "weighted": ("fw-rls", {**PRIOR, "mu": 1.0, "weight": 20.0}),
}
"""Recursions by the name their values bear: Table 2's settings, rls from 20 P(0), and the weight without forgetting."""
SEARCHED = ("rls", "fw", "printed", "wide")
"""Recursions that the search repeats."""
SETTINGS = {
    "dt": STEP_S,
    "P0": PRIOR["p0"],
    "q0": PRIOR["theta0"],
    "mu": METHODS["fw"][1]["mu"],
    "L": METHODS["fw"][1]["weight"],
}
BANDS = {"5": 0.05, "2": 0.02, "03": 0.003}
"""Settling bands by the name their values bear; at .3 % the published times of both methods come out."""

TABLE_1 = {
    "m": 29.9, "xG": 0.0, "u": 1.5, "Iz": 3.45, "Yvdot": -35.5, "Yrdot": 1.93, "Yuv": -28.6, "Yur": 5.22,
    "Yuud": -9.64, "Nvdot": 1.93, "Nrdot": -4.88, "Nuv": -24.0, "Nur": -2.0, "Nuud": 6.15,
}  # fmt: skip
"""As printed, by the names of vessel `remus`; I_z in kg m2 (printed kg/m2)."""
ANGLES = (10, 15, 20, 25)
"""Of the zigzags of Table 3, deg."""
MISPRINT = (20, "K", 2.2020)
SINES = [f"sine:{amplitude}deg/{period}s" for amplitude in (10, 15, 20, 25) for period in (3, 6, 10, 20)]
NOISE_DEG = {"0.001": 0.001, "0.01": 0.01, "0.1": 0.1, "0.5": 0.5}
RUNS = 100
ROUNDING = 1e-12
"""Errors below count as this: their digits depend on the machine."""


def recursion(name: str) -> Method:
    """The method of a name in `METHODS`, with its settings."""
    method, options = METHODS[name]
    return make(method, **options)


def table_1(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Parameters of eq 5 that Table 1 gives: exactly, and by eq 6 as printed."""
    remus = resolve("remus")
    derived = derived_parameters(remus, vehicle())
    values = {**derived, **{f"{name}_printed": value for name, value in equation_6(TABLE_1).items()}}
    known = remus.parameters | dict(zip(remus.constant_names, remus.constants, strict=True)) | {"u": remus.speed_m_s}
    values["entries"] = float(sum(known[name] == value for name, value in TABLE_1.items()))
    return StudyResult(values | {"pole_slow": np.roots([1.0, derived["T1"], derived["T2"]]).real.max()})


def equation_6(table: Mapping[str, float]) -> dict[str, float]:
    """Eq 6 as printed, its third line (a second T3, with a product as in T2) read as the continuation of T2.

    As printed: m x_G u instead of m u in sway, Y_r for Y_rdot (of Table 1), D not squared, and u^2 missing beside
    Y_uud in T3.
    """
    m, xg, u = table["m"], table["xG"], table["u"]
    a, b = m - table["Yvdot"], m * xg - table["Yrdot"]
    c, d = m * xg - table["Nvdot"], table["Iz"] - table["Nrdot"]
    det = a * d - b * c
    yv, yr, yd = table["Yuv"] * u, (table["Yur"] - m * xg) * u, table["Yuud"] * u**2
    nv, nr, nd = table["Nuv"] * u, (table["Nur"] - m * xg) * u, table["Nuud"] * u**2
    sway, yaw = nv * b - yv * d, nv * a - yv * c
    return {
        "T1": sway / det,
        "T2": (yaw * (nr * b - yr * d) - (nr * a - yr * c) * sway) / det,
        "K": ((nd * a - yd * c) * sway - yaw * (nd * b - yd * d)) / det,
        "T3": (nd * a - table["Yuud"] * c) / det,
    }


def protocol(rng: np.random.Generator, *, index: int) -> StudyResult:
    """The 20/20 zigzag of 20 s made by eq 8, and what every recursion makes of it."""
    model = vehicle()
    record = records.zigzag(records.difference_step(model))
    fits = {name: recursion(name).fit([record], model) for name in METHODS}
    values = _of_record(record) | SETTINGS | compared(fits, model)
    batch = make("ls", scheme="heading-difference").fit([record], model)
    values["ls_worst"] = max(_worst(batch.parameters, model), ROUNDING)
    values["fw_over_ls"] = values["fw_worst"] / values["ls_worst"]
    values["weight_gap"] = _gap(fits["weighted"], fits["wide"])
    return StudyResult(values, _series(record, fits))


def compared(fits: Mapping[str, Estimate], model: Model) -> dict[str, float]:
    """What every recursion ends with, and the ratios that the paper claims."""
    values: dict[str, float] = {}
    for name, fit in fits.items():
        values |= {f"{name}_{key}": value for key, value in _of_fit(fit, model).items()}
    for name in ("rls", "wide"):
        values[f"fw_over_{name}"] = values["fw_worst"] / max(values[f"{name}_worst"], ROUNDING)
    values["printed_over_rls"] = values["printed_worst"] / max(values["rls_worst"], ROUNDING)
    values["speed_ratio"] = values["rls_slowest_5"] / values["fw_slowest_5"]
    values["speed_ratio_printed"] = values["rls_slowest_5"] / values["printed_slowest_5"]
    overshoots = values["fw_T3_overshoot"], values["rls_T3_overshoot"]
    values["overshoot_ratio"] = overshoots[0] / overshoots[1] if overshoots[1] > 0.0 else float("nan")
    return values


def made_otherwise(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Run `index` of the search: how the record was made is not printed (steering gear, start, eq 8 or eq 5)."""
    chosen = settings_at("000", "made-otherwise", index)
    model = vehicle()
    steps = {"eq. 8": records.difference_step, "eq. 5": records.continuous_step}
    step = steps[chosen["record by"]](model)
    start = np.deg2rad(chosen["yaw rate at the start (deg/s)"])
    gear = records.Gear(np.deg2rad(chosen["rudder rate"]), chosen["rudder lag"], chosen["first order"], start)
    record = records.zigzag(step, gear=gear)
    values = compared({name: recursion(name).fit([record], model) for name in SEARCHED}, model)
    rows = {angle: records.zigzag(step, angle, gear) for angle in ANGLES}
    for angle, run in rows.items():
        for name in ("fw", "printed"):
            found = recursion(name).fit([run], model).parameters
            values |= {f"{name}_{angle}_{key}": value for key, value in found.items()}
    return StudyResult(values)


def _gap(one: Estimate, other: Estimate) -> float:
    """Largest difference of two trajectories, no less than rounding."""
    assert one.trajectory is not None and other.trajectory is not None
    return max(float(np.abs(one.trajectory - other.trajectory).max()), ROUNDING)


def _of_record(record: Record) -> dict[str, float]:
    heading, rudder = record.column("heading_rad"), record.rudder()
    return {
        "psi_max_deg": float(np.rad2deg(np.abs(heading).max())),
        "moves": float(np.count_nonzero(np.diff(rudder))),
        "duration_s": float(record.time_s[-1]),
        "samples": float(record.n - 1),
    }


def _of_fit(fit: Estimate, model: Model) -> dict[str, float]:
    """Final values, errors, settling times and overshoots of a recursion; row k of the path belongs to time k dt."""
    time, paths = _clock(fit), parameter_paths(fit)
    values = {"worst": _worst(fit.parameters, model), "largest": _largest(fit.parameters, model)}
    for name, value in model.parameters.items():
        values |= {name: fit.parameters[name], f"{name}_error": fit.parameters[name] - value}
        values[f"{name}_relative"] = fit.parameters[name] / value - 1.0
        values[f"{name}_overshoot"] = 100.0 * overshoot(paths[name], value)
        for band, width in BANDS.items():
            values[f"{name}_settled_{band}"] = settling_time(paths[name], time, value, width)
    for band in BANDS:
        values[f"slowest_{band}"] = max(values[f"{name}_settled_{band}"] for name in ORDER)
    return values


def _clock(fit: Estimate) -> np.ndarray:
    assert fit.trajectory_time_s is not None
    return fit.trajectory_time_s + STEP_S


def _worst(parameters: Mapping[str, float], model: Model) -> float:
    """Largest relative error."""
    return max(abs(parameters[name] / value - 1.0) for name, value in model.parameters.items())


def _largest(parameters: Mapping[str, float], model: Model) -> float:
    """Largest absolute error."""
    return max(abs(parameters[name] - value) for name, value in model.parameters.items())


def _series(record: Record, fits: Mapping[str, Estimate]) -> dict[str, np.ndarray]:
    series = {
        "time_s": record.time_s,
        "rudder_deg": np.rad2deg(record.rudder()),
        "heading_deg": np.rad2deg(record.column("heading_rad")),
        "path_time_s": _clock(fits["rls"]),
    }
    for name in ("rls", "fw", "printed"):
        series |= {f"{name}_{parameter}": path for parameter, path in parameter_paths(fits[name]).items()}
    return series


def angles(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Table 3: FW-RLS on zigzags of four rudder angles, and what the printed rows deviate by."""
    model = vehicle()
    values: dict[str, float] = {f"real_{name}": value for name, value in model.parameters.items()}
    found = {}
    for angle in ANGLES:
        record = records.zigzag(records.difference_step(model), angle)
        for name in ("fw", "printed"):
            fit = recursion(name).fit([record], model)
            values |= {f"{name}_{angle}_{key}": value for key, value in fit.parameters.items()}
            found[name, angle] = fit.parameters
    for name in ("fw", "printed"):
        values[f"{name}_largest"] = max(_largest(found[name, angle], model) for angle in ANGLES)
    values["rows_largest"] = max(_largest(row, model) for row in _misprint_mended().values())
    values["rows_largest_printed"] = max(_largest(row, model) for row in table_3().values())
    return StudyResult(values)


def table_3() -> dict[int, dict[str, float]]:
    """Rows as printed, the headings of K and T3 exchanged, as the row of real values and eq 23 demand."""
    return {angle: {name: published("000")[f"table-3-{angle}-{name}"] for name in ORDER} for angle in ANGLES}


def _misprint_mended() -> dict[int, dict[str, float]]:
    (angle, name, value), rows = MISPRINT, table_3()
    return {**rows, angle: {**rows[angle], name: value}}


def prediction(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Heading errors in sine manoeuvres of the models in Table 3 and of those that FW-RLS finds here."""
    model = vehicle()
    series: dict[str, np.ndarray] = {}
    errors: dict[str, list[float]] = {name: [] for name in ("rows", "rows_printed", "fw", "printed")}
    rows = _misprint_mended()
    headed = {angle: {**row, "K": row["T3"], "T3": row["K"]} for angle, row in table_3().items()}
    for angle in ANGLES:
        record = records.zigzag(records.difference_step(model), angle)
        models = {"rows": rows[angle], "rows_printed": headed[angle]}
        models |= {n: recursion(n).fit([record], model).parameters for n in ("fw", "printed")}
        for name, parameters in models.items():
            other = model.with_coefficients(model.from_parameters(parameters))
            for text in SINES:
                time, truth, error = _sine_error(model, other, text)
                errors[name].append(float(np.abs(error).max()))
                if text == "sine:20deg/6s":
                    series |= {"time_s": time, "heading_deg": truth, f"{name}_{angle}_deg": error}
    return StudyResult({name: max(found) for name, found in errors.items()}, series)


def _sine_error(model: Model, other: Model, text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time in s, the true heading and the other model's heading error (N+1,) in degrees, over 20 s."""
    runs = [record_run(m, parse_manoeuvre(text)) for m in (model, other)]
    truth, predicted = (np.rad2deg(run.column("heading_rad")) for run in runs)
    return runs[0].time_s, truth, predicted - truth


def continuous(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Eq 8 regression on a record of eq 5 itself, at the paper's step and smaller ones, and the integrated equation."""
    model = vehicle()
    values: dict[str, float] = {}
    series: dict[str, list[float]] = {"step_s": [0.1, 0.05, 0.02, 0.01]} | {name: [] for name in ORDER}
    for dt in series["step_s"]:
        record = records.zigzag(records.continuous_step(model, dt), dt=dt)
        found = make("ls", scheme="heading-difference").fit([record], model).parameters
        for name in ORDER:
            series[name].append(found[name])
            values[f"{name}_{dt:g}"] = found[name]
        if dt == STEP_S:
            held = records.held_ahead(record)
            integral = make("ls", scheme="triple-integral-rest").fit([held], model).parameters
            values |= {f"integral_{name}": integral[name] for name in ORDER}
            values["integral_worst"] = _worst(integral, model)
    return StudyResult(values, {name: np.array(entries) for name, entries in series.items()})


def noise(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Heading noise: median error and rms error over the Cramer-Rao bound, over 100 records at each level.

    rls and fw-rls on eq 8's own record; output error and the integrated equation on continuous ones.
    """
    model = vehicle()
    values: dict[str, float] = {}
    clean = records.zigzag(records.difference_step(model))
    for level, sd_deg in NOISE_DEG.items():
        sd = float(np.deg2rad(sd_deg))
        runs = [records.noisy(clean, sd, rng) for _ in range(RUNS)]
        bound = records.bound_at_rest(model, clean, sd)
        values |= {f"bound_{level}_{name}": value for name, value in bound.items()}
        for name in ("rls", "fw"):
            values |= _judged(f"{name}_{level}", [recursion(name).fit([run], model) for run in runs], model, bound)
        values[f"fw_over_rls_{level}"] = values[f"fw_{level}_ratio"] / values[f"rls_{level}_ratio"]
        values |= _continuous_noise(model, level, sd, rng)
    return StudyResult(values)


def _continuous_noise(model: Model, level: str, sd: float, rng: np.random.Generator) -> dict[str, float]:
    """Output error, start unknown, with a rudder linear between samples; integrated equation from rest, rudder held."""
    linear = generate(Case("remus-kt", "zigzag:20/20")).with_channels(yaw_rate_rad_s=None)
    spread, _ = cramer_rao(model, [linear], {"heading_rad": sd})
    own = records.zigzag(records.continuous_step(model))
    cases = {
        "oe": (make("output-error"), linear, dict(zip(model.parameter_names, spread.tolist(), strict=True))),
        "integral": (
            make("ls", scheme="triple-integral-rest"),
            records.held_ahead(own),
            records.bound_at_rest(model, own, sd, records.continuous_step),
        ),
    }
    values = {}
    for name, (method, clean, bound) in cases.items():
        fits = [method.fit([records.noisy(clean, sd, rng)], model) for _ in range(RUNS)]
        values |= _judged(f"{name}_{level}", fits, model, bound)
    return values | {f"bound_exact_{level}_{name}": value for name, value in cases["integral"][2].items()}


def _judged(name: str, fits: list[Estimate], model: Model, bound: Mapping[str, float]) -> dict[str, float]:
    """Median relative error and rms error over the bound, by parameter and for the worst one."""
    errors = {key: np.array([fit.parameters[key] for fit in fits]) - value for key, value in model.parameters.items()}
    ratios = {key: float(np.sqrt(np.mean(error**2)) / bound[key]) for key, error in errors.items()}
    medians = {key: float(np.median(error) / model.parameters[key]) for key, error in errors.items()}
    values = {f"{name}_{key}_median": value for key, value in medians.items()}
    values |= {f"{name}_{key}_ratio": value for key, value in ratios.items()}
    return values | {f"{name}_worst": max(abs(v) for v in medians.values()), f"{name}_ratio": max(ratios.values())}


STUDIES = {
    "table-1": PaperStudy(table_1),
    "protocol": PaperStudy(protocol),
    "angles": PaperStudy(angles),
    "prediction": PaperStudy(prediction),
    "continuous": PaperStudy(continuous),
    "noise": PaperStudy(noise),
    "made-otherwise": PaperStudy(made_otherwise, seeds=64),
}
