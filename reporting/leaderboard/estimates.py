"""Parameters of all runs, put together over the seeds: what the leaderboard needs of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .standings import CELL, Frame, Series, labels

FIRST_SEED = 0
LARGEST = 2**62
"""Number of groups that whole numbers can tell apart."""


def summarised(parameters: Frame) -> Frame:
    """One row a cell, method and parameter, in the order of these: `CELL`, label, parameter, and

    unit, true, true_kind, crb_sd : of a first run.
    identifiable, judged : whether any run's parameter is identifiable, has a relative error.
    seeds, bound, square : number of estimates that have a bound, their mean crb_sd^2 and mean squared error.
    first_seed, first_estimate, first_stderr : whether the first seed has the parameter, and what it gives.
    """
    import pandas as pd

    keys = [*CELL, "label", "parameter"]
    parameters = parameters.assign(label=labels(parameters))
    number = _group_numbers(parameters, keys)
    count = int(number.max(initial=-1)) + 1
    first = np.empty(count, dtype=np.int64)
    first[number[::-1]] = np.arange(len(number))[::-1]
    own = {name: parameters[name].take(first).array for name in (*keys, "unit", "true", "true_kind", "crb_sd")}
    figures = _over_seeds(parameters, number, count) | _of_first_seed(parameters, number, count)
    return pd.DataFrame(own | figures, copy=False)


def _group_numbers(frame: Frame, keys: Sequence[str]) -> np.ndarray:
    """Number (N,) of every row's group, the groups in the order of their keys; in less memory than `groupby`."""
    number, size = np.zeros(len(frame), dtype=np.int64), 1
    for name in keys:
        codes, levels = _coded(frame[name])
        if size * levels > LARGEST:
            number = np.unique(number, return_inverse=True)[1]
            size = int(number.max(initial=0)) + 1
        number *= levels
        number += codes
        size *= levels
    return np.unique(number, return_inverse=True)[1].astype(np.int32)


def _coded(values: Series) -> tuple[np.ndarray, int]:
    """Number (N,) of every value among the distinct ones in their order, and how many numbers there are."""
    import pandas as pd

    if isinstance(values.dtype, pd.CategoricalDtype):
        return values.cat.codes.to_numpy(), max(1, len(values.cat.categories))
    codes, levels = pd.factorize(values, sort=True)
    return codes, max(1, len(levels))


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
        "seeds": seeds.astype(np.int32),
        "bound": total(np.where(bounded, bound**2, 0.0)) / shares,
        "square": total(np.where(bounded, error**2, 0.0)) / shares,
    }


def _of_first_seed(parameters: Frame, number: np.ndarray, count: int) -> dict[str, np.ndarray]:
    rows = np.flatnonzero(parameters["seed"] == FIRST_SEED)
    found = {"first_seed": np.zeros(count, dtype=bool)}
    found["first_seed"][number[rows]] = True
    for name in ("estimate", "stderr"):
        values = np.full(count, np.nan)
        values[number[rows]] = parameters[name].to_numpy(dtype=float, na_value=np.nan)[rows]
        found[f"first_{name}"] = values
    return found
