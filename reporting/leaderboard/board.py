"""The leaderboard of one results store: standings, cells and failures, which show themselves."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..tables import html
from .charts import standings_figure
from .standings import FACTORS, Frame, cell_table, details, efficiency, failures, judged, matched, standings
from .tables import overall_table


@dataclass(frozen=True, repr=False)
class Leaderboard:
    """Aggregated results; every table is a pandas frame.

    `overall` has `STANDING_COLUMNS`, and so has every frame of `by`: factor -> standings at each of its levels, for
    factors with more than one.  `cells` is the `cell_table`, `estimates` are the parameters put together over seeds;
    `failures` has one row per distinct reason.
    """

    overall: Frame
    by: dict[str, Frame]
    cells: Frame
    estimates: Frame
    failures: Frame

    @cached_property
    def detail(self) -> Frame:
        """One row a cell and method, in reading order, with the estimates of small models."""
        return details(self.cells, self.estimates)

    def table(self) -> Frame:
        """All standings in one table, as `leaderboard.csv` holds them."""
        import pandas as pd

        return pd.concat([self.overall, *self.by.values()], ignore_index=True)

    def plot(self) -> Any:
        """Draw the held-out prediction error of every method with its interval; a matplotlib figure, not of pyplot."""
        return standings_figure(self.overall)

    def __repr__(self) -> str:
        methods = ", ".join(self.overall["method"])
        return f"<Leaderboard of {len(self.overall)} methods, best first: {methods}>"

    def _repr_html_(self) -> str:
        return html(overall_table(self.overall))


def build(results: Frame, estimates: Frame, runs: Frame | None = None, cells: Frame | None = None) -> Leaderboard:
    """The leaderboard of one results store.

    results : as `store.read_tables` gives them.
    estimates : `estimates.summarised` of the parameters.
    runs, cells : `judged` and `cell_table` of them, where these are known already.
    """
    runs = judged(results, estimates) if runs is None else runs
    cells = cell_table(runs) if cells is None else cells
    efficiencies = efficiency(estimates)
    overall = standings(cells, efficiencies, "overall")
    blocks = {factor: matched(cells, factor) for factor in FACTORS}
    by = {factor: standings(rows, efficiencies, factor) for factor, rows in blocks.items() if len(rows)}
    return Leaderboard(overall, by, cells, estimates, failures(runs))
