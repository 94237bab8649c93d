"""Ranks, medians and efficiencies of methods from stored results.

A cell is one set of conditions under which methods are compared: one vessel, fitted model, training and held-out
manoeuvres, noise, disturbance and sampling of the training records; seeds are repetitions inside it.  Two criteria are
ranked in every cell with at least two methods:

* parameters: `rel_error_median`, where the vessel's own coefficients are the truth (`true_kind` is `given`),
* prediction: the normalised free-run error on held-out records, the mean over channels of sqrt(1 - R^2).

A failed run has an infinite error and so ranks last; a diverged one has an infinite prediction error.  A run that is
not applicable is not ranked but counted.  Errors that agree to `DIGITS` digits, or are below `FLOOR`, are equal:
rounding decides no rank.  Medians are taken over seeds, then over cells; their intervals are percentile bootstraps
over cells from a fixed seed.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

Frame: TypeAlias = Any
Series: TypeAlias = Any
"""pandas frames and series, which are imported only where they are made."""

CELL = ["vessel", "model", "train", "held_out", "noise", "disturbance", "thinning", "length"]
CASES = ("equations known", "equations unknown", "measured ships")
"""What is known of the ship: its own equations are fitted, others are, or its records are measured."""
CRITERIA = {"rank_parameters": "rel_error", "rank_prediction": "nrmse"}
MEDIANS = {
    "rel_error": "parameter_error",
    "nrmse": "prediction_error",
    "crb_z": "crb_z_rms",
    "rmse_yaw_rate_rad_s": "rmse_free_yaw_rate_rad_s",
    "r2_yaw_rate": "r2_free_yaw_rate_rad_s",
    "rmse_heading_rad": "rmse_free_heading_rad",
    "r2_heading": "r2_free_heading_rad",
    "wall_s": "wall_s",
    "cpu_s": "cpu_s",
    "peak_memory_mib": "peak_memory_mib",
}
"""Aggregated figure -> column of the judged runs."""
STATUSES = ("ok", "failed", "not_applicable")
PREDICTED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")
FLOOR, DIGITS = 1e-6, 5
BOOTSTRAP_SEED, BOOTSTRAP_DRAWS, LEVEL = 20240, 2000, 0.95
COVERAGE = 0.9
"""Methods compared in a smaller share of the problems than this stand below the others."""
EFFICIENCY_SEEDS = 3
"""Least number of seeds from which an efficiency is estimated."""

STANDING_COLUMNS = [
    *("method", "mean_rank", *CRITERIA, "cells"),
    *(f"{name}{end}" for name in CRITERIA.values() for end in ("", "_low", "_high")),
    *("rmse_yaw_rate_rad_s", "r2_yaw_rate", "rmse_heading_rad", "r2_heading", "efficiency"),
    *("diverged", "failed", "not_applicable", "ok", "runs", "wall_s", "cpu_s", "peak_memory_mib"),
]


def judged(results: Frame, parameters: Frame) -> Frame:
    """Runs with `label`, `case`, `parameter_error` and `prediction_error`; nan where a criterion does not apply."""
    runs = results.copy()
    runs["label"] = labels(runs)
    has_truth = of_own_models(runs, parameters)
    measured = runs["measured"].eq(True).to_numpy(dtype=bool)
    runs["case"] = np.array(CASES)[np.where(measured, 2, np.where(has_truth, 0, 1))]
    failed, absent = (runs["status"] == "failed").to_numpy(), (runs["status"] == "not_applicable").to_numpy()
    error = runs["rel_error_median"].to_numpy(dtype=float, na_value=np.nan)
    runs["parameter_error"] = np.where(has_truth & ~absent, np.where(failed, np.inf, error), np.nan)
    lost = failed | runs["diverged"].eq(True).to_numpy(dtype=bool)
    runs["prediction_error"] = np.where(absent, np.nan, np.where(lost, np.inf, normalised_error(runs)))
    return runs.assign(**_worst_where(lost, runs))


def _worst_where(lost: np.ndarray, runs: Frame) -> dict[str, Series]:
    """The free-run columns of `MEDIANS`, an infinite error where a run is lost and its cell has the channel scored.

    Without it the median of a method that diverges in half of its problems were that of the other half.
    """
    found = {}
    for name in MEDIANS.values():
        if name.startswith(("rmse_free_", "r2_free_")):
            scored = runs[name].notna().groupby([runs[key] for key in CELL], observed=True).transform("any")
            worst = np.inf if name.startswith("rmse") else -np.inf
            found[name] = runs[name].astype(float).mask(scored & lost, worst)
    return found


def of_own_models(rows: Frame, parameters: Frame) -> np.ndarray:
    """Whether the `model` fitted in each row (n,) is the `vessel`'s own, its coefficients known and judged."""
    import pandas as pd

    known = parameters[(parameters["true_kind"] == "given") & parameters["rel_error"].notna()]
    own, fitted = (pd.MultiIndex.from_frame(frame[["vessel", "model"]]) for frame in (known, rows))
    return np.asarray(fitted.isin(own), dtype=bool)


def normalised_error(runs: Frame) -> np.ndarray:
    """Mean over channels of sqrt(1 - R^2) of the free run, (n,); nan where no channel was scored."""
    r2 = np.column_stack([runs[f"r2_free_{channel}"].to_numpy(dtype=float, na_value=np.nan) for channel in PREDICTED])
    known = np.isfinite(r2)
    total = np.sqrt(np.maximum(0.0, 1.0 - np.where(known, r2, 1.0))).sum(axis=1)
    return np.where(known.any(axis=1), total / np.maximum(1, known.sum(axis=1)), np.nan)


def cell_table(runs: Frame) -> Frame:
    """Every cell and method: `CELL`, label, medians over seeds (`MEDIANS`), ranks and counts.

    `rank_parameters` and `rank_prediction` are nan where fewer than two methods compete, `rank` is the mean of those
    that there are.  Ranks of equal errors are averaged.
    """
    flags = {name: runs["status"] == name for name in STATUSES} | {"diverged": runs["diverged"].eq(True)}
    figures = {column: runs[column].astype(float) for column in MEDIANS.values()}
    groups = runs.assign(**flags, **figures).groupby([*CELL, "label"], sort=True, observed=True)
    medians = {name: (column, "median") for name, column in MEDIANS.items()}
    counts = {name: (name, "sum") for name in flags}
    table = groups.agg(**medians, **counts, runs=("seed", "size"), case=("case", "first")).reset_index()
    for name, column in CRITERIA.items():
        competing = _comparable(table[column]).groupby([table[key] for key in CELL], observed=True)
        table[name] = competing.rank(method="average").where(competing.transform("count") > 1)
    table["rank"] = table[list(CRITERIA)].mean(axis=1)
    return table


def standings(cells: Frame, efficiencies: Frame) -> Frame:
    """One row a method by the mean rank in prediction, equal ones by name, as `contest.Contest.order` has them; without
    predictions by the mean rank.

    Methods that were compared in less than `COVERAGE` of the cells stand below the others.
    """
    import pandas as pd

    known = {label: own.to_numpy() for label, own in efficiencies.groupby("label", observed=True)["efficiency"]}
    groups = cells.groupby("label", sort=True, observed=True)
    rows = [{"method": label} | _standing(own, known.get(label, [])) for label, own in groups]
    table = pd.DataFrame(rows, columns=STANDING_COLUMNS)
    keys = {
        "_partial": table["cells"] < COVERAGE * table["cells"].max(),
        "_rank": table["rank_prediction"].round(9),
        "_other": table["mean_rank"].where(table["rank_prediction"].isna(), 0.0),
    }
    return table.assign(**keys).sort_values([*keys, "method"], ignore_index=True).drop(columns=list(keys))


def efficiency(parameters: Frame) -> Frame:
    """Efficiency of every method on every parameter of a calm cell, crb_sd^2 / mean squared error over seeds.

    Only parameters with a given truth that are identifiable in a run, of at least `EFFICIENCY_SEEDS` seeds; 1 is the
    Cramer-Rao bound.  Columns `CELL`, label, parameter, seeds, efficiency.
    """
    calm = (parameters["true_kind"] == "given") & (parameters["disturbance"] == "none")
    own = parameters[calm & (parameters["crb_sd"] > 0.0) & parameters["estimate"].notna()]
    error = own["estimate"] - own["true"]
    own = own.assign(label=labels(own), bound=own["crb_sd"] ** 2, square=error**2, told=own["identifiable"].eq(True))
    means = {name: (name, "mean") for name in ("bound", "square")}
    groups = own.groupby([*CELL, "label", "parameter"], sort=True, observed=True)
    found = groups.agg(**means, seeds=("seed", "size"), told=("told", "any")).reset_index()
    found = found[found["told"] & (found["seeds"] >= EFFICIENCY_SEEDS)]
    found = found.assign(efficiency=found["bound"] / found["square"].where(found["square"] > 0))
    return found[[*CELL, "label", "parameter", "seeds", "efficiency"]].reset_index(drop=True)


def failures(runs: Frame) -> Frame:
    """Every reason why runs failed, did not apply or did not converge, with the number of runs and their seeds."""
    listed = runs[(runs["status"] != "ok") | runs["error"].notna()]
    keys = ["status", "label", "vessel", "model", "train", "noise", "disturbance", "thinning", "length", "error"]
    listed = listed.assign(error=listed["error"].astype("str").fillna(""))
    table = listed.groupby(keys, sort=True, observed=True)["seed"].agg(
        runs="size", seeds=lambda seeds: ", ".join(str(seed) for seed in sorted(set(seeds)))
    )
    return table.reset_index()


def bootstrap_interval(values: Sequence[float] | np.ndarray, draws: int = BOOTSTRAP_DRAWS) -> tuple[float, float]:
    """Percentile bootstrap interval of the median at `LEVEL`; infinite values take part, nan must not be in it."""
    values = np.asarray(values, dtype=float)
    if values.size == 0:
        return np.nan, np.nan
    picks = np.random.default_rng(BOOTSTRAP_SEED).integers(values.size, size=(draws, values.size))
    drawn = np.sort(medians(values[picks]))
    tail = (1.0 - LEVEL) / 2.0
    low, high = int(np.floor(tail * (draws - 1))), int(np.ceil((1.0 - tail) * (draws - 1)))
    return float(drawn[low]), float(drawn[high])


def _standing(cells: Frame, efficiencies: Any) -> dict[str, Any]:
    """The figures of one method in one group; medians over the cells that were ranked, else over all."""
    ranked = cells[cells["rank"].notna()]
    compared = ranked if len(ranked) else cells
    row: dict[str, Any] = {"cells": len(ranked), "mean_rank": _mean(ranked["rank"])}
    row |= {name: _mean(ranked[name]) for name in CRITERIA}
    row |= {name: median(compared[name]) for name in MEDIANS if name in STANDING_COLUMNS}
    for name in CRITERIA.values():
        row[f"{name}_low"], row[f"{name}_high"] = bootstrap_interval(compared[name].dropna())
    row |= {name: int(cells[name].sum()) for name in (*STATUSES, "diverged", "runs")}
    return row | {"efficiency": median(efficiencies)}


def _comparable(errors: Series) -> Series:
    """Errors without the digits that must not decide a rank."""
    return errors.clip(lower=FLOOR).pipe(lambda kept: kept.where(np.isinf(kept) | kept.isna(), significant(kept)))


def significant(values: Any, digits: int = DIGITS) -> Any:
    """Positive values with so many significant digits; what is not finite stays."""
    with np.errstate(all="ignore"):
        unit: Any = 10.0 ** (np.floor(np.log10(values)) - digits + 1)
        return (values / unit).round() * unit


def labels(frame: Frame) -> Series:
    """The method, with its variant where that is not the corrected one."""
    return frame["method"].where(frame["variant"] == "corrected", frame["method"] + " (" + frame["variant"] + ")")


def in_order(level: str) -> tuple[tuple[int, float, str], ...]:
    """Key that sorts levels in reading order: noise levels by size, numbers by value, other texts by letter."""
    from ...datasets.sensors import NOISE

    sizes = {name: place for place, name in enumerate(NOISE)}
    parts = [part for part in re.split(r"(\d+(?:\.\d+)?)|,", level) if part]
    numbers = {part: float(part) for part in parts if part[0].isdigit()}
    return tuple(
        (0, sizes[part], "") if part in sizes else (1, numbers[part], "") if part in numbers else (2, 0.0, part)
        for part in parts
    )


def _mean(values: Series) -> float:
    known = values.dropna()
    return float(known.mean()) if len(known) else float("nan")


def median(values: Any) -> float:
    """Median without nan; infinite where the middle is."""
    known = np.asarray(values, dtype=float).ravel()
    return float(medians(known)) if known.size else float("nan")


def medians(rows: np.ndarray) -> np.ndarray:
    """Medians along the last axis without nan, infinities being ordinary large values; nan where nothing is known."""
    ordered, n = np.sort(rows, axis=-1), (~np.isnan(rows)).sum(axis=-1)
    low, high = (
        np.take_along_axis(ordered, np.maximum(place, 0)[..., None], axis=-1)[..., 0]
        for place in ((n - 1) // 2, n // 2)
    )
    with np.errstate(invalid="ignore"):
        return np.where(n == 0, np.nan, np.where(low == high, low, (low + high) / 2.0))
