"""A1 and A2 over the settings that paper 001 does not print, and with primes by a constant speed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.linear_algebra import lstsq
from ...claims.files import load
from ..study import StudyResult, point
from .studies import METHODS, Setting, backward, fitted, median_error, sailed, vessel

if TYPE_CHECKING:
    from ....datasets.record import Record
    from ....models.model import Model

CONSTANT = "constant"
MOST_SAMPLES = 30_000
"""A record with more samples is cut: at steps of a millisecond half a minute is enough."""


def wide_settings(rng: np.random.Generator, *, index: int) -> StudyResult:
    """Run `index` of the search: A1 and A2, corrected and as printed, at one point of the range in the claims file."""
    chosen = point(load("001").search("wide-settings"), index)
    found = at(chosen)
    half = at(chosen | {"length": min(chosen["length"], MOST_SAMPLES * chosen["step"]) / 2.0})
    values: dict[str, float] = {"more data": median_error(found["A1"]) < median_error(half["A1"])}
    values |= {"A1 beats A2": median_error(found["A1"]) < median_error(found["A2"])}
    values |= {"A1p beats A2p": not median_error(found["A1p"]) >= median_error(found["A2p"])}
    values |= {f"{name}.median": median_error(c) for name, c in found.items()}
    for name, c in found.items():
        values |= {f"{name}.{symbol}": float(v) for symbol, v in zip(vessel().coordinates, c, strict=True)}
    return StudyResult(values)


def at(chosen: dict[str, Any]) -> dict[str, np.ndarray]:
    """Coefficients (60,) that each form finds with the settings of a point; nan where it finds none."""
    setting = Setting(
        speed=chosen["speed"],
        rate=np.deg2rad(chosen["rudder rate"]),
        lag=chosen["rudder lag"],
        dt=chosen["step"],
        duration=min(chosen["length"], MOST_SAMPLES * chosen["step"]),
    )
    record, model = sailed(setting), vessel(setting)
    if chosen["speed in the primes"] == CONSTANT:
        return constant_speed(record, model)
    found = {name: fitted(METHODS[name], record, model) for name in ("A1", "A2", "A2p")}
    return found | {"A1p": backward(record, model)}


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
