"""Paper 001: Euler-difference least squares (A1, A2) for the 60 coefficients of a Mariner model.

The paper states neither speed, time step, duration nor steering gear of its 15 deg zigzag.  `settings` tries 40 points
of a range of them and gives the interval of what A1 and A2 find; the other studies use one setting, `SETTING`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ....datasets.generator import record_run
from ....datasets.manoeuvres import parse_manoeuvre
from ....datasets.record import Record
from ....estimation.regression.schemes import regression_samples
from ....estimation.run.run import run_along
from ....models.linear_algebra import condition_number, lstsq
from ....models.model import Model, RudderGear, resolve
from ...claims import files
from ..study import PaperStudy, StudyResult, fitted, settings_at

VESSEL = "mariner-model"
SCALE = 25.0
TRAINING = "zigzag:15/15"
MANOEUVRES = {
    "Figure 2": "zigzag:15/15",
    "Figure 3": "sine:15deg/20s",
    "Figure 4": "turn:15",
    "Figure 5": "zigzag:30/30",
    "Figure 6": "sine:30deg/20s",
    "Figure 7": "turn:30",
}
METHODS = {
    "A1": "euler-ls",
    "A2": "euler-ls,algorithm=A2",
    "A2p": "euler-ls,algorithm=A2,variant=as_printed",
}
SOURCE = {
    "Xudot": -42.0e-5, "m": 798.0e-5, "xG": -0.023, "Yvdot": -748.0e-5, "Yrdot": -9.354e-5, "Izz": 39.2e-5,
    "Nvdot": 4.646e-5, "Nrdot": -43.8e-5,
}  # fmt: skip
"""Inertia of the Mariner ship in primes (Chislett & Stroem-Tejsen 1965, as in the MSS toolbox)."""
DURATIONS_S = (40, 50, 60, 80, 100, 150, 200, 300, 400)


class ZigzagSetting(NamedTuple):
    """What the paper leaves unsaid: speed m/s, rudder rate rad/s and lag s, time step s, duration s."""

    speed: float
    rate: float
    lag: float
    dt: float
    duration: float


SETTING = ZigzagSetting(1.5435, np.deg2rad(25.0), 0.2, 0.02, 60.0)
"""15 kn at the ship's scale, the ship's steering gear (both 1:25), and a zigzag of 60 s."""
FINE = ZigzagSetting(1.5435, np.deg2rad(25.0), 0.0, 0.003, 100.0)
"""A small step: what difference schemes leave is proportional to it."""


def vessel(setting: ZigzagSetting = SETTING) -> Model:
    """The Mariner model with the speed and the steering gear of a setting."""
    model = resolve(VESSEL)
    constants = model.constants.copy()
    constants[model.constant_names.index("U0")] = setting.speed
    gear = RudderGear(model.rudder.max_rad, setting.rate, setting.lag)
    return replace(model, constants=constants, speed_m_s=setting.speed, rudder=gear)


def sailed(setting: ZigzagSetting, manoeuvre: str = TRAINING) -> Record:
    """A noise-free record of the vessel; '@euler' behind the manoeuvre: of its difference equation."""
    parsed = parse_manoeuvre(manoeuvre)
    return record_run(vessel(setting), parsed, duration_s=setting.duration, dt_s=setting.dt)


def found_by(method: str, record: Record, model: Model) -> np.ndarray:
    """Coefficients (60,) that a method finds; nan where it finds none."""
    found = fitted(method, [record], model)
    return np.full(len(model.coordinates), np.nan) if found is None else found.coefficients


def backward(record: Record, model: Model) -> np.ndarray:
    """A1 with backward differences: what it finds in the record played backwards, with the other sign."""
    played = {name: values[::-1] for name, values in record.channels.items()}
    return -found_by("euler-ls", replace(record, channels=played), model)


def published(column: str) -> np.ndarray:
    """A column (60,) of Table 2 as printed."""
    return np.array([files.published("001")[f"table2-{column}-{name}"] for name in resolve(VESSEL).coordinates], float)


def median_error(coefficients: np.ndarray) -> float:
    """Median relative error of the 40 coefficients that are not zero, %."""
    true = resolve(VESSEL).coefficients
    used = true != 0.0
    return float(100.0 * np.median(np.abs(coefficients[used] / true[used] - 1.0)))


# ------------------------------------------------------------------------------------------------ studies


def particulars(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Table 1 against the ship it is a model of: its particulars 1:25, and the inertia that its source gives."""
    ship, model = resolve("mariner"), resolve(VESSEL)
    values = {name: ship.particulars[name] / SCALE for name in ("L", "B", "d")}
    values["nabla"] = ship.particulars["nabla"] / SCALE**3
    values |= {
        name: value for name, value in zip(model.constant_names, model.constants.tolist(), strict=True) if name != "L"
    }
    values |= dict(zip(model.coordinates, model.coefficients.tolist(), strict=True))
    # of A1 over those of A2, N n^2 for the products of n columns: A2 has the state as one more column
    sizes = [sum(name[0] == letter for name in model.coordinates) for letter in "XYN"]
    operations = sum(n**2 for n in sizes) / sum((n + 1) ** 2 for n in sizes)
    return StudyResult(values | SOURCE | {"operations": operations})


def settings(rng: np.random.Generator, *, index: int) -> StudyResult:
    """A1 and A2 at one point of what the paper leaves unsaid; as printed: A1 backward, A2 by normal equations."""
    chosen = settings_at("001", "settings", index)
    rate = np.deg2rad(chosen["rudder rate"])
    setting = ZigzagSetting(chosen["speed"], rate, 0.0, chosen["step"], chosen["length"])
    values = compared(forms(sailed(setting), vessel(setting)))
    values["A1 over A2"] = values["A1.median"] / values["A2.median"]
    return StudyResult(values)


def forms(record: Record, model: Model) -> dict[str, np.ndarray]:
    """Coefficients (60,) that each form finds."""
    found = {name: found_by(METHODS[name], record, model) for name in ("A1", "A2", "A2p")}
    return found | {"A1p": backward(record, model)}


def compared(found: Mapping[str, np.ndarray]) -> dict[str, float]:
    """Median errors and coefficients (60,) of every form, and whether A1 has the smaller error."""
    values = {f"{name}.median": median_error(c) for name, c in found.items()}
    for name, c in found.items():
        values |= {f"{name}.{symbol}": float(v) for symbol, v in zip(vessel().coordinates, c, strict=True)}
    values["A1 beats A2"] = values["A1.median"] < values["A2.median"]
    values["A1p beats A2p"] = not values["A1p.median"] >= values["A2p.median"]
    return values


def accuracy(rng: np.random.Generator, *, index: int) -> StudyResult:
    """A1 and A2 on records of the difference equation and of the differential equation, and the other pairings."""
    model, true = vessel(), vessel().coefficients
    euler = sailed(SETTING, TRAINING + "@euler")
    found = {name: found_by(spec, euler, model) for name, spec in METHODS.items()}
    values = {f"euler.{name}": float(np.abs(c - true).max()) for name, c in found.items()}
    values["condition"] = _condition(euler, model)
    table = {duration: _pairings(SETTING._replace(duration=duration)) for duration in DURATIONS_S}
    values |= {f"rk4.{name}": error for name, error in table[round(SETTING.duration)].items()}
    values["rk4.A1.100s"], values["rk4.A2.100s"] = table[100]["A1"], table[100]["A2"]
    names = tuple(table[DURATIONS_S[0]])
    series = {name: np.array([table[d][name] for d in DURATIONS_S]) for name in names}
    values["A1 over midpoint"] = values["rk4.A1"] / values["rk4.midpoint"]
    values["A1 column"] = median_error(published("A1"))
    values["more data"] = bool(np.all(np.diff(series["A1"]) < 0.0))
    return StudyResult(values, series | {"duration_s": np.array(DURATIONS_S, float)})


def _condition(record: Record, model: Model) -> float:
    """Condition of A2's regression of the surge (eq 9) with columns of unit length."""
    part = regression_samples([record], model, "forward")[0]
    terms = np.concatenate([phi[:, 0] for _, phi in part.blocks(model)])
    columns = np.column_stack([part.states[:, 0], terms[:, np.any(terms != 0.0, axis=0)]])
    return condition_number(columns / np.linalg.norm(columns, axis=0))


def _pairings(setting: ZigzagSetting) -> dict[str, float]:
    """Median errors of the difference schemes on one record, %."""
    record, model = sailed(setting), vessel(setting)
    found = {name: found_by(METHODS[name], record, model) for name in ("A1", "A2")}
    found |= {"backward": backward(record, model), "midpoint": found_by("ls,scheme=midpoint", record, model)}
    return {name: median_error(c) for name, c in found.items()}


def explanation(rng: np.random.Generator, *, index: int) -> StudyResult:
    """The A1 column from difference schemes and an inertia matrix that was not the simulator's."""
    target = published("A1")
    record, model = sailed(FINE), vessel(FINE)
    alone = backward(record, model)
    mixed = mix(alone, target, model)
    series = {"published": target, "backward": mixed, "backward.alone": alone}
    return StudyResult({"backward": _typical(mixed, target)}, series)


def mix(c: np.ndarray, target: np.ndarray, model: Model) -> np.ndarray:
    """Coefficients (60,) as a regression with another inertia matrix M' finds them, closest to `target` (60,).

    Both equations, sway and yaw, have the same columns, so least squares with M' gives M' M^-1 times what it gives
    with M; the four numbers of that matrix are those with the smallest sum of absolute relative deviations.
    """
    sway, yaw = (np.array([name[0] == letter for name in model.coordinates]) for letter in "YN")
    columns = np.column_stack([c[sway], c[yaw]])
    mixed = c.copy()
    for rows in (sway, yaw):
        mixed[rows] = columns @ _least_absolute(columns / target[rows, None])
    return mixed


def _least_absolute(columns: np.ndarray) -> np.ndarray:
    """Factors (m,) for which columns (n, m) add up to one, least in absolute deviations: weights, again and again."""
    weight = np.ones(len(columns))
    factors = np.zeros(columns.shape[1])
    for _ in range(50):
        factors = lstsq(columns * weight[:, None], weight)
        weight = 1.0 / np.sqrt(np.maximum(np.abs(columns @ factors - 1.0), 1e-2))
    return factors


def _typical(found: np.ndarray, target: np.ndarray) -> float:
    """Median relative deviation of the 40 coefficients whose original is not zero, %."""
    used = published("original") != 0.0
    return float(100.0 * np.median(np.abs(found[used] / target[used] - 1.0)))


def predictions(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Figures 1 to 7: free runs of the coefficient sets with the rudder of the original."""
    model, training = vessel(), sailed(SETTING)
    sets = {"A1p": published("A1"), "A2p": published("A2")}
    sets |= {name: found_by(METHODS[name], training, model) for name in ("A1", "A2")}
    sets["midpoint"] = found_by("ls,scheme=midpoint", training, model)
    values, series = {}, _drawn("Figure 1", sailed(SETTING._replace(dt=0.1, duration=80.0)))
    for figure, manoeuvre in MANOEUVRES.items():
        record = sailed(SETTING._replace(dt=0.1, duration=80.0), manoeuvre)
        series |= _drawn(figure, record)
        for name, c in sets.items():
            errors, lines = _free_run(model.with_coefficients(c), record)
            values |= {f"{figure}.{name}.{key}": value for key, value in errors.items()}
            series |= {f"{figure}.{name}.{key}": line for key, line in lines.items()}
    for letter in ("", "p"):
        values[f"A1{letter} beats A2{letter}"] = all(
            not values[f"{figure}.A1{letter}.heading"] >= values[f"{figure}.A2{letter}.heading"]
            for figure in MANOEUVRES
        )
        lost = [not np.isfinite(values[f"{figure}.A2{letter}.heading"]) for figure in MANOEUVRES]
        values[f"A2{letter}.diverged"] = float(np.sum(lost))
    return StudyResult(values, series)


CHANNELS = {"heading": "heading_rad", "north": "north_m", "east": "east_m"}


def _drawn(figure: str, record: Record) -> dict[str, np.ndarray]:
    """The samples of a record that figures show, each half second."""
    names = ("surge_m_s", "sway_m_s", "yaw_rate_rad_s", "heading_rad", "rudder_rad", "north_m", "east_m")
    chosen = {f"{figure}.{name}": record.column(name)[::5] for name in names}
    return {f"{figure}.time_s": record.time_s[::5]} | chosen


def _free_run(model: Model, record: Record) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """Errors in % of the observed range (and of the heading in deg), and the predicted lines; nan once diverged."""
    run = run_along(model, record)
    found = run.squares()
    rms = {key: np.nan if run.diverged else found[channel].scores()[0] for key, channel in CHANNELS.items()}
    extent = {key: float(np.ptp(run.measured.channels[channel])) for key, channel in CHANNELS.items()}
    errors = {
        "heading": 100.0 * rms["heading"] / extent["heading"],
        "heading_deg": float(np.rad2deg(rms["heading"])),
        "track": 100.0 * float(np.hypot(rms["north"], rms["east"]) / np.hypot(extent["north"], extent["east"])),
    }
    drawn = {key: (run.predicted[channel], run.measured.channels[channel]) for key, channel in CHANNELS.items()}
    return errors, {key: _while_near(*pair)[::5] for key, pair in drawn.items()}


def _while_near(free: np.ndarray, observed: np.ndarray) -> np.ndarray:
    """A free run (N,) up to where it leaves twice the observed range for good; nan from there on."""
    middle, extent = (observed.max() + observed.min()) / 2.0, max(float(np.ptp(observed)), 1e-9)
    with np.errstate(all="ignore"):
        gone = ~(np.abs(free - middle) < 2.0 * extent)
    return np.where(np.cumsum(gone) > 0, np.nan, free)


# ---- the settings that are not printed, over a wide range

CONSTANT = "constant"
MOST_SAMPLES = 30_000
"""A record with more samples is cut: at steps of a millisecond half a minute is enough."""


def wide_settings(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Run `index` of the search: A1 and A2, corrected and as printed, at one point of the range in the claims file."""
    chosen = settings_at("001", "wide-settings", index)
    found = at(chosen)
    half = at(chosen | {"length": min(chosen["length"], MOST_SAMPLES * chosen["step"]) / 2.0})
    return StudyResult(compared(found) | {"more data": median_error(found["A1"]) < median_error(half["A1"])})


def at(chosen: dict[str, Any]) -> dict[str, np.ndarray]:
    """Coefficients (60,) that each form finds with the settings of a point; nan where it finds none."""
    setting = ZigzagSetting(
        speed=chosen["speed"],
        rate=np.deg2rad(chosen["rudder rate"]),
        lag=chosen["rudder lag"],
        dt=chosen["step"],
        duration=min(chosen["length"], MOST_SAMPLES * chosen["step"]),
    )
    record, model = sailed(setting), vessel(setting)
    return (constant_speed if chosen["speed in the primes"] == CONSTANT else forms)(record, model)


def constant_speed(record: Record, model: Model) -> dict[str, np.ndarray]:
    """A1 and A2 with V = U0 in eq 9-11 and 20-26; in A2 u(t) = V + (u - V) is then a sum of two other columns."""
    dt = float(np.median(np.diff(record.time_s)))
    states = np.column_stack([record.column(c) for c in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")])
    terms = _terms(record, model)
    step = np.diff(states, axis=0) / dt
    found = {"A1": _separated(model, terms[:-1], step), "A1p": _separated(model, terms[1:], step)}
    for name, inverse in (("A2", False), ("A2p", True)):
        found[name] = _separated(model, terms[:-1] * dt, states[1:], states[:-1], inverse)
    return found


def _terms(record: Record, model: Model) -> np.ndarray:
    """Columns (N, 60) of eq 9-11: products of u - V, v, r L and V delta in m2/s2, by the letters of their names."""
    constants = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    speed, length = constants["U0"], constants["L"]
    letters = {
        "u": record.column("surge_m_s") - speed,
        "v": record.column("sway_m_s"),
        "r": record.column("yaw_rate_rad_s") * length,
        "d": record.rudder() * speed,
    }
    columns = []
    for name in model.coordinates:
        factors = [letters[letter] / speed for letter in name[1:] if letter in letters]
        columns.append(speed**2 * np.prod(factors, axis=0) if factors else np.full(record.n, speed**2))
    return np.column_stack(columns)


def _separated(
    model: Model, terms: np.ndarray, left: np.ndarray, state: np.ndarray | None = None, normal: bool = False
) -> np.ndarray:
    """Coefficients (60,) of regressions of u, v, r (N, 3), A2 with the state itself as a column, then M' [b; c]."""
    c = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    own = {letter: np.array([name[0] == letter for name in model.coordinates]) for letter in "XYN"}
    accelerations = []
    for j, letter in enumerate("XYY"):  # sway and yaw share their columns
        columns = terms[:, own[letter]]
        columns = columns if state is None else np.column_stack([state[:, j], columns])
        accelerations.append(_solved(columns, left[:, j], normal)[0 if state is None else 1 :])
    surge, sway, yaw = (a * c["L"] ** power for a, power in zip(accelerations, (1, 1, 2), strict=True))
    parts = (c["m11"] * surge, c["m22"] * sway + c["m23"] * yaw, c["m32"] * sway + c["m33"] * yaw)
    return np.concatenate(parts)


def _solved(columns: np.ndarray, left: np.ndarray, normal: bool) -> np.ndarray:
    """Least squares: by (H'H)^-1 H'Y on unscaled columns, or by orthogonal decomposition of scaled ones."""
    if not normal:
        lengths = np.linalg.norm(columns, axis=0)
        lengths[lengths == 0.0] = 1.0
        return lstsq(columns / lengths, left) / lengths
    try:
        return np.linalg.inv(columns.T @ columns) @ (columns.T @ left)
    except np.linalg.LinAlgError:
        return np.full(columns.shape[1], np.nan)


STUDIES = {
    "particulars": PaperStudy(particulars),
    "settings": PaperStudy(settings, seeds=40),
    "accuracy": PaperStudy(accuracy),
    "explanation": PaperStudy(explanation),
    "predictions": PaperStudy(predictions),
    "wide-settings": PaperStudy(wide_settings, seeds=32),
}
