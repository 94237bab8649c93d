"""Parameters of all runs, put together over the seeds: what the leaderboard needs of them."""

from __future__ import annotations

import numpy as np

from .standings import CELL, Frame, labels

FIRST_SEED = 0


def summarised(parameters: Frame) -> Frame:
    """One row a cell, method and parameter, in the order of these: `CELL`, label, parameter, and

    unit, true, true_kind, crb_sd : of a first run.
    identifiable, judged : whether any run's parameter is identifiable, has a relative error.
    estimate : median over seeds.
    seeds, bound, square : number of estimates that have a bound, their mean crb_sd^2 and mean squared error.
    first_seed, first_estimate, first_stderr : whether the first seed has the parameter, and what it gives.
    """
    keys = [*CELL, "label", "parameter"]
    parameters = parameters.assign(label=labels(parameters))
    number = parameters.groupby(keys, sort=True, observed=True).ngroup().to_numpy()
    count = int(number.max(initial=-1)) + 1
    first = np.empty(count, dtype=np.int64)
    first[number[::-1]] = np.arange(len(number))[::-1]
    found = parameters[[*keys, "unit", "true", "true_kind", "crb_sd"]].iloc[first].reset_index(drop=True)
    return found.assign(**_over_seeds(parameters, number, count), **_of_first_seed(parameters, number, count))


def _over_seeds(parameters: Frame, number: np.ndarray, count: int) -> dict[str, np.ndarray]:
    """Figures of `count` groups, `number` (N,) being the group of every row."""
    estimate, bound = (parameters[name].to_numpy(dtype=float, na_value=np.nan) for name in ("estimate", "crb_sd"))
    bounded = (bound > 0.0) & ~np.isnan(estimate)

    def total(values: np.ndarray) -> np.ndarray:
        return np.bincount(number, weights=values, minlength=count)

    seeds = total(bounded)
    shares = np.where(seeds > 0.0, seeds, np.nan)
    error = estimate - parameters["true"].to_numpy(dtype=float, na_value=np.nan)
    return {
        "identifiable": total(parameters["identifiable"].eq(True).to_numpy(dtype=bool)) > 0.0,
        "judged": total(parameters["rel_error"].notna().to_numpy()) > 0.0,
        "estimate": _medians(estimate, number, count),
        "seeds": seeds.astype(int),
        "bound": total(np.where(bounded, bound**2, 0.0)) / shares,
        "square": total(np.where(bounded, error**2, 0.0)) / shares,
    }


def _medians(values: np.ndarray, number: np.ndarray, count: int) -> np.ndarray:
    import pandas as pd

    return pd.Series(values).groupby(number).median().reindex(range(count)).to_numpy()


def _of_first_seed(parameters: Frame, number: np.ndarray, count: int) -> dict[str, np.ndarray]:
    rows = np.flatnonzero(parameters["seed"] == FIRST_SEED)
    found = {"first_seed": np.zeros(count, dtype=bool)}
    found["first_seed"][number[rows]] = True
    for name in ("estimate", "stderr"):
        values = np.full(count, np.nan)
        values[number[rows]] = parameters[name].to_numpy(dtype=float, na_value=np.nan)[rows]
        found[f"first_{name}"] = values
    return found
