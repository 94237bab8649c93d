"""The leaderboard of one results store: standings, cells, contest and failures, which show themselves.

`python -m helmbench.reporting.leaderboard.board RESULTS FILE`, which `make board-picture` calls, draws the standings.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ...bench.store import read_tables
from ...models.folders import make_folder, write_atomic
from ..plots import COLOURS, SOFT, as_svg
from ..tables import html
from .contest import Contest, contest
from .standings import (
    CELL,
    Frame,
    cell_table,
    efficiency,
    failures,
    judged,
    standings,
)
from .tables import CRITERIA, overall_table


@dataclass(frozen=True, repr=False)
class Leaderboard:
    """Aggregated results; every table is a pandas frame.

    Attributes
    ----------
    runs : `standings.judged` runs.
    parameters : a row a run and parameter, as stored.
    """

    runs: Frame
    parameters: Frame

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
        """The standings over all cells, with `STANDING_COLUMNS`, as `leaderboard.csv` holds them."""
        return standings(self.cells, efficiency(self.parameters).merge(self.cells[CELL].drop_duplicates(), on=CELL))

    @cached_property
    def failures(self) -> Frame:
        """One row per distinct reason."""
        return failures(self.runs)

    def in_problems_of(self, suite: str) -> Leaderboard:
        """The leaderboard of all runs in the problems of one suite."""
        own = self.runs.loc[self.runs["suite"] == suite, CELL].drop_duplicates()
        return Leaderboard(self.runs.merge(own, on=CELL), self.parameters)

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
    """The leaderboard of runs and parameters as `store.read_tables` gives them."""
    return Leaderboard(judged(results, parameters), parameters)


def write_picture(results: Path, place: Path) -> None:
    """Draw the standings of stored results (a folder) into a file."""
    make_folder(place.parent)
    write_atomic(place, build(*read_tables(results)).picture().encode())


if __name__ == "__main__":
    write_picture(Path(sys.argv[1]), Path(sys.argv[2]))
