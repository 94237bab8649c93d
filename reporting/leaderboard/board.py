"""The leaderboard of one results store: standings, cells, contest and failures, which show themselves.

`python -m helmbench.reporting.leaderboard.board RESULTS FILE`, which `make board-picture` calls, draws the standings.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ...models.folders import make_folder, write_atomic
from ..plots import COLOURS, SOFT, as_svg
from ..tables import html
from .compact import read_compact
from .contest import Contest, contest
from .standings import (
    CELL,
    FACTORS,
    Frame,
    Series,
    cell_table,
    efficiency,
    failures,
    judged,
    labels,
    matched,
    standings,
)
from .tables import CRITERIA, overall_table

# ---- Parameters of all runs, put together over the seeds: what the leaderboard needs of them.

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


@dataclass(frozen=True, repr=False)
class Leaderboard:
    """Aggregated results; every table is a pandas frame.

    Attributes
    ----------
    runs : `standings.judged` runs.
    estimates : the parameters put together over seeds, `estimates.summarised`.
    """

    runs: Frame
    estimates: Frame

    @cached_property
    def cells(self) -> Frame:
        """One row a cell and method (`cell_table`)."""
        return cell_table(self.runs)

    @cached_property
    def contest(self) -> Contest:
        """The prediction errors of methods on problems."""
        return contest(self.cells, self.runs)

    @cached_property
    def overall(self) -> Frame:
        """The standings over all cells, with `STANDING_COLUMNS`."""
        return standings(self.cells, self._efficiencies, "overall")

    @cached_property
    def by(self) -> dict[str, Frame]:
        """Factor -> standings at each of its levels, for factors with more than one."""
        blocks = {factor: matched(self.cells, factor) for factor in FACTORS}
        return {factor: standings(rows, self._efficiencies, factor) for factor, rows in blocks.items() if len(rows)}

    @cached_property
    def failures(self) -> Frame:
        """One row per distinct reason."""
        return failures(self.runs)

    @cached_property
    def _efficiencies(self) -> Frame:
        return efficiency(self.estimates)

    def in_problems_of(self, suite: str) -> Leaderboard:
        """The leaderboard of all runs in the problems of one suite."""
        own = self.runs.loc[self.runs["suite"] == suite, CELL].drop_duplicates()
        return Leaderboard(self.runs.merge(own, on=CELL), self.estimates)

    def table(self) -> Frame:
        """All standings in one table, as `leaderboard.csv` holds them."""
        import pandas as pd

        return pd.concat([self.overall, *self.by.values()], ignore_index=True)

    def plot(self) -> Any:
        """Draw the held-out prediction error of every method with its interval; a matplotlib figure, not of pyplot.

        The best method stands first, the errors on a logarithmic axis.
        """
        from ...models.figure import ShownFigure

        rows = self.overall
        places = range(len(rows))
        figure = ShownFigure(7.5, 1.2 + 0.28 * len(rows))
        axes = figure.subplots()
        axes.hlines(places, rows["nrmse_low"], rows["nrmse_high"], color=SOFT, linewidth=1.0)
        axes.plot(rows["nrmse"], places, "o", color=COLOURS[0])
        axes.set_yticks(places, list(rows["method"]))
        axes.set(xscale="log", ylim=(len(rows) - 0.5, -0.5), xlabel=CRITERIA["nrmse"])
        axes.grid(True, linewidth=0.3)
        for place, error in zip(places, rows["nrmse"], strict=True):
            if error == math.inf:
                across = axes.get_yaxis_transform()
                axes.text(0.98, place, "median: infinite", color=SOFT, ha="right", va="center", transform=across)
        return figure

    def picture(self) -> str:
        """`plot` as the text of an SVG file, the same every time."""
        return as_svg(self.plot)

    def __repr__(self) -> str:
        methods = ", ".join(self.overall["method"])
        return f"<Leaderboard of {len(self.overall)} methods, best first: {methods}>"

    def _repr_html_(self) -> str:
        return html(overall_table(self.overall))


def build(results: Frame, parameters: Frame) -> Leaderboard:
    """The leaderboard of runs and parameters as `store.read_tables` or `read_compact` give them."""
    estimates = summarised(parameters)
    return Leaderboard(judged(results, estimates), estimates)


def write_picture(results: Path, place: Path) -> None:
    """Draw the standings of stored results (a folder) into a file."""
    make_folder(place.parent)
    write_atomic(place, build(*read_compact(results)).picture().encode())


if __name__ == "__main__":
    write_picture(Path(sys.argv[1]), Path(sys.argv[2]))
