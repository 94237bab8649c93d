"""Diagnoser `sparse-regression`: sparse regression of the residual accelerations on candidate terms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.geometry import body_velocities
from ...models.linear_algebra import lstsq
from ..causes.registry import testable
from .naive import fit_cause
from .output_error import Chosen, OfFreeRuns

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from .output_error import FilterRuns

WIDTH_S = 3.0
"""Standard deviation of the Gaussian low-pass filter on a full-scale ship, s."""
MOST = 4
LEAST = 0.02
"""Share of an equation's residual variance that a surviving term must explain on folds that it was not fitted on."""
FOLDS = 5
FORCES = {
    "1": ("constant_force", "constant_force", "rudder_offset"),
    "rudder": (None, "rudder_effectiveness", "rudder_effectiveness"),
    "rudder rate": (None, "rudder_delay", "rudder_delay"),
    "r|r|": (None, None, "yaw_damping_quadratic"),
    "r^3": (None, None, "yaw_damping_cubic"),
    "v|v|": (None, "sway_damping_quadratic", "crossflow_coupling"),
    "r|v|": (None, "crossflow_coupling", "crossflow_coupling"),
    "v|r|": (None, "crossflow_coupling", "crossflow_coupling"),
    "acceleration": ("loading_change",) * 3,
    "v": ("coefficient_shift",) * 3,
    "r": ("coefficient_shift",) * 3,
    "cos heading": ("current", "wind", "wind"),
    "sin heading": ("current", "wind", "wind"),
    "cos 2 heading": ("wave_drift",) * 3,
    "sin 2 heading": ("wave_drift",) * 3,
    "time": (None, None, None),
}
"""Term of a force equation -> cause that it stands for in surge, sway and yaw (None: no cause of the bank)."""
RATES = {"1": "yaw_rate_bias", "r": "yaw_rate_scale", "acceleration": "heading_delay", "time": None}
"""Term of d heading/dt - r -> cause."""
TRACK = {
    "surge: surge": "speed_scale",
    "sway: 1": "sway_offset",
    "sway: surge": "axis_misalignment",
    "surge: surge rate": "velocity_delay",
    "sway: sway rate": "velocity_delay",
}
"""Term of the track's velocity in body axes less the log's -> cause."""


class SparseRegression(OfFreeRuns):
    """Sparse regression of low-passed accelerations (and of the track and heading rate) less what the model says.

    Every equation's residual is regressed on a library of terms by orthogonal matching pursuit (Pati et al. 1993),
    terms entering while they predict folds of the records that they were not fitted on (a sparse regression as in
    Brunton et al. 2016); the largest term of all equations names the cause, or is unexplained where it stands for
    none.  Residuals and terms pass the same low-pass filter, so that it does not bias them.
    """

    name = "sparse-regression"
    title = "naive: matching pursuit of residual accelerations in a library of terms"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Name the cause of the largest term; its size is then fitted by output error."""
        terms = sorted((t for eq in equations(model, train) for t in survivors(*eq)), reverse=True, key=lambda t: t[0])
        share, label, cause = terms[0] if terms else (0.0, "", None)
        bank, _ = testable(runs.est)
        entry = next((c for c in bank if c.id == cause), None)
        verdict = "adequate" if not terms else "unexplained" if entry is None else "named"
        chosen = [] if entry is None else [Chosen(entry, *fit_cause(runs, runs.base(), entry, bank[entry]))]
        reason = f"{label} explains {share:.1%} of a residual" if terms else "no term explains a residual"
        return chosen, verdict, reason


def survivors(y: np.ndarray, library: dict[str, np.ndarray], causes: dict[str, str | None]) -> list[tuple]:
    """(share of variance, term, cause) of the terms that matching pursuit adds to one equation."""
    names = list(library)
    x = np.column_stack([library[name] for name in names])
    x = x / (np.linalg.norm(x, axis=0) + 1e-300)
    chosen: list[int] = []
    out, explained, left = [], 0.0, y
    for _ in range(MOST):
        j = int(np.argmax(np.abs(x.T @ left)))
        gained = _predicted(x[:, [*chosen, j]], y) - explained
        if j in chosen or gained < LEAST:
            break
        chosen.append(j)
        out.append((gained, names[j], causes[names[j]]))
        explained += gained
        left = y - x[:, chosen] @ lstsq(x[:, chosen], y)
    return out


def _predicted(x: np.ndarray, y: np.ndarray) -> float:
    """Share of the mean square of y that least squares predicts on folds in time that it did not see."""
    folds = np.array_split(np.arange(y.size), FOLDS)
    left = 0.0
    for fold in folds:
        seen = np.setdiff1d(np.arange(y.size), fold)
        left += float(np.sum((y[fold] - x[fold] @ lstsq(x[seen], y[seen])) ** 2))
    return 1.0 - left / float(np.sum(y**2) + 1e-300)


def equations(model: Model, records: Sequence[Record]) -> list[tuple]:
    """Residual, library and causes of every equation, all records in turn."""
    parts = [_record_equations(model, record) for record in records]
    return [
        (
            np.concatenate([p[i][0] for p in parts]),
            {k: np.concatenate([p[i][1][k] for p in parts]) for k in own},
            causes,
        )
        for i, (_, own, causes) in enumerate(parts[0])
    ]


def _record_equations(model: Model, record: Record) -> list[tuple]:
    from ...datasets.signals import bridged
    from ...estimation.records.series import samples

    columns = {s: samples(record, s) for s in ("psi", "r", "u", "v", "x", "y")} | {"d": record.rudder()}
    series = {s: bridged(values, record.time_s) for s, values in columns.items() if values is not None}
    series.setdefault("r", np.gradient(series["psi"], record.time_s) if "psi" in series else np.zeros(record.n))
    pairs = {s: (values, np.gradient(values, record.time_s)) for s, values in series.items()}
    terms = _library(pairs, record.time_s)
    own = _force_equations(model, record, pairs, terms)
    if "psi" in pairs and columns["r"] is not None:
        own.append((pairs["psi"][1] - pairs["r"][0], {k: terms[k] for k in RATES if k in terms}, RATES))
    if model.is_3dof and {"x", "y", "u", "v", "psi"} <= pairs.keys():
        own += _track_equations(pairs)
    return [(_low(y, model, record), {k: _low(v, model, record) for k, v in x.items()}, causes) for y, x, causes in own]


def _low(values: np.ndarray, model: Model, record: Record) -> np.ndarray:
    """Low-passed series without the filter's ends."""
    from scipy.ndimage import gaussian_filter1d

    width = WIDTH_S * np.sqrt(model.particulars.get("L", 160.0) / 160.0) / record.dt
    cut = int(4.0 * width)
    return gaussian_filter1d(values, width)[cut : values.size - cut]


def _library(pairs: dict, time_s: np.ndarray) -> dict[str, np.ndarray]:
    """Candidate terms (N,)."""
    r, r_dot = pairs["r"]
    v = pairs["v"][0] if "v" in pairs else np.zeros_like(r)
    d, d_dot = pairs["d"]
    terms = {"1": np.ones_like(r), "rudder": d, "rudder rate": d_dot, "r|r|": r * abs(r), "r^3": r**3, "r": r}
    if v.any():
        terms |= {"v": v, "v|v|": v * abs(v), "r|v|": r * abs(v), "v|r|": v * abs(r)}
    if "psi" in pairs:
        psi = pairs["psi"][0]
        terms |= {"cos heading": np.cos(psi), "sin heading": np.sin(psi)}
        terms |= {"cos 2 heading": np.cos(2 * psi), "sin 2 heading": np.sin(2 * psi)}
    return terms | {"acceleration": r_dot, "time": time_s - time_s[0]}


def _force_equations(model: Model, record: Record, pairs: dict, terms: dict) -> list[tuple]:
    """What is left of the model's own equations, from its regression form."""
    from ...estimation.records.series import inputs_of
    from ...models.simulate import regression

    inputs = inputs_of(record, model)
    rate = {"q": pairs["r"][1], "delta_rate": pairs["d"][1], "delta": pairs["d"][0]}
    states = [s for s in model.regression_states]
    if any(s not in pairs and s != "q" and s not in ("psi", "x", "y") for s in states):
        return []
    zero = np.zeros_like(pairs["r"][0])
    x = np.column_stack([rate[s] if s == "q" else pairs[s][0] if s in pairs else zero for s in states])
    u = np.column_stack([rate[s] if s in rate else inputs[s] for s in model.regression_inputs])
    moving = ["u", "v", "r"] if model.is_3dof else ["q"] if "q" in states else ["r"]
    a = np.column_stack([np.gradient(rate["q"], record.dt) if s == "q" else pairs[s][1] for s in moving])
    y, phi = regression(model, x, a, u)
    left = y - phi @ model.coefficients
    rows = range(3) if model.is_3dof else [2]
    out = []
    for column, row in enumerate(rows):
        library = {**terms, "acceleration": a[:, column]}
        out.append((left[:, column], library, {name: FORCES[name][row] for name in library}))
    return out


def _track_equations(pairs: dict) -> list[tuple]:
    """Velocity of the track in body axes, less that of the log."""
    (psi, _), (_, north), (_, east) = pairs["psi"], pairs["x"], pairs["y"]
    along, across = body_velocities(north, east, psi)
    (u, u_dot), (v, v_dot) = pairs["u"], pairs["v"]
    surge = {"surge: surge": u, "surge: surge rate": u_dot}
    sway = {"sway: 1": np.ones_like(v), "sway: surge": u, "sway: sway rate": v_dot}
    return [(along - u, surge, TRACK), (across - v, sway, TRACK)]
