"""Statistics of a whole suite for the report: statements, charts and the table of sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..numbers import MISSING, number, p_value, percent
from ..plots import SOFT, chart, legend_beside
from ..tables import Column, Table, field, make_table
from . import profiles
from .answer import begin
from .contest import Contest
from .equivalence import LEAST
from .grey_black import GreyBlack, grey_against_black
from .paired import LEVEL, PairedComparison, compare
from .stability import stability
from .standings import CASES, Frame, in_order

DIFFERENCES = (0.1, 0.25)
"""Differences of errors for which the number of seeds is stated."""
DRAWN = 8
"""Methods in a chart with a curve a method: the best."""
FACTORS = np.logspace(0.0, 2.0, 121)
LOST = "0.46"
"""Grey of a heat map where there is no finite error: white text and, on a dark page, black text is read on it."""


@dataclass(frozen=True)
class Statistics:
    """A contest with the tables that it was made of."""

    board: Contest
    cells: Frame
    estimates: Frame

    @cached_property
    def comparison(self) -> PairedComparison:
        """The methods that were compared in nearly every problem, on the problems that they share."""
        return compare(*self.board.block())

    @cached_property
    def grey_black(self) -> GreyBlack | None:
        """The best grey box against the best black box; None where too few problems have both."""
        return grey_against_black(self.board)

    @cached_property
    def sensitivity(self) -> list[profiles.Sensitivity]:
        """The ranking by other metrics and without single vessels."""
        return profiles.sensitivity(self.board, profiles.other_metrics(self.cells, self.board))

    @cached_property
    def power(self) -> profiles.Power:
        """Seeds needed to tell methods apart in one problem."""
        return profiles.seeds_needed(self.board.runs, DIFFERENCES)

    def statements(self) -> list[str]:
        """Sentences on the tests, the sensitivity and the number of seeds."""
        found, own = self._stability(), self.comparison
        if np.isfinite(own.friedman_p) and own.n >= LEAST:
            p = f"{'<' if own.friedman_p < 0.001 else '='} {p_value(max(own.friedman_p, 0.001))}"
            found.append(
                f"Friedman's test over {own.n} problems and {len(own.methods)} methods, that all are equal: p {p}. "
                f"Two mean ranks differ at {percent(LEVEL)} by more than {number(own.critical_difference)}."
            )
        if self.sensitivity and own.n >= LEAST:
            least = min(self.sensitivity, key=lambda row: row.tau)
            firsts = sum(row.first == own.methods[0] for row in self.sensitivity) if own.methods else 0
            found.append(
                f"The first method stays first in {firsts} of {len(self.sensitivity)} other choices of metric and "
                f"vessels; the ranking differs most {least.choice} (Kendall's tau {number(least.tau)})."
            )
        if self.power.needed:
            needs = " and ".join(f"{n} seeds for {percent(d)}" for d, n in self.power.needed.items())
            found.append(
                "To tell apart two methods in one problem (power 80 %, level 5 %) takes "
                f"{needs} of difference in error; there are {self.power.seeds}. Rankings rest on many problems instead."
            )
        return found

    def _stability(self) -> list[str]:
        """A sentence for every case of what is known that has several ships."""
        told = []
        for case in CASES:
            board = self.board.where({"case": case})
            found = stability(board)
            if found:
                told.append(f"{begin(case)}: {found.sentence(board.order()[0].method)}")
        return told

    def sensitivity_table(self) -> Table:
        """Kendall's tau of the ranking with others."""
        columns = [
            field("choice", "ranking"),
            Column("Kendall's tau", lambda row: number(row["tau"]), lambda row: row["tau"]),
            field("first", "first method"),
            Column("largest move", _move, lambda row: row["places"]),
            Column("problems", lambda row: str(row["problems"]), lambda row: row["problems"]),
        ]
        note = "1: the same order of the methods; the largest move is in places, + upwards."
        return make_table(columns, [vars(row) for row in self.sensitivity], "What the ranking depends on", note)

    def charts(self) -> list[tuple[str, str]]:
        """Pairs of caption and SVG."""
        errors, methods = self.board.block()
        found = [
            (
                "Mean ranks; a bar joins methods that no test tells apart, which is no sign that they are equal",
                _difference_diagram(self.comparison),
            ),
            ("Share of problems solved within a factor of the least error", _profiles(errors, methods)),
            ("Parameter error by noise, with the Cramer-Rao bound as floor", self._noise(methods)),
            ("Median prediction error of method and vessel", self._heat_map()),
        ]
        return [(caption, svg) for caption, svg in found if svg]

    def _noise(self, methods: Sequence[str]) -> str:
        own = [method for method in methods if method in set(self.cells["label"])]
        curves, floor = profiles.noise_curves(self.cells, self.estimates, own)
        curves = dict(list((m, curves[m]) for m in own if m in curves)[:DRAWN])
        levels = sorted({level for curve in curves.values() for level in curve}, key=in_order)
        if len(levels) < 2:
            return ""

        def draw(figure) -> None:
            axes = figure.subplots()
            _levels(axes, curves, levels)
            known = [level for level in levels if floor.get(level, 0.0) > 0.0]
            if known:
                places, values = [levels.index(level) for level in known], [floor[level] for level in known]
                axes.plot(places, values, color=SOFT, linestyle="--", linewidth=2.0, label="Cramer-Rao bound")
            axes.set(
                yscale="log", xlabel="sensor noise", ylabel="median parameter error (-)", xlim=(-0.3, len(levels) - 0.7)
            )
            axes.set_xticks(range(len(levels)), levels)
            legend_beside(axes)

        return chart(draw, (7.0, 3.6), "parameter error by noise")

    def _heat_map(self) -> str:
        methods, vessels, table = profiles.by_vessel(self.board)
        if len(vessels) < 2 or len(methods) < 2:
            return ""

        def draw(figure) -> None:
            from matplotlib import colormaps
            from matplotlib.colors import LogNorm

            axes = figure.subplots()
            finite = table[np.isfinite(table) & (table > 0.0)]
            norm = LogNorm(max(finite.min(), 1e-4), min(max(finite.max(), 1e-3), 10.0)) if finite.size else None
            most = norm.vmax if norm else np.inf
            shown = np.where(table > most, 1e9, table)
            colours = colormaps["viridis_r"].with_extremes(over=LOST)
            image = axes.imshow(shown, norm=norm, cmap=colours, aspect="auto")
            for i, j in zip(*np.nonzero(table > most), strict=True):
                told = "inf" if np.isinf(table[i, j]) else f">{most:g}"
                axes.text(j, i, told, ha="center", va="center", color="white", fontsize=7)
            axes.set_xticks(range(len(vessels)), vessels, rotation=40, ha="right")
            axes.set_yticks(range(len(methods)), methods)
            axes.grid(False)
            figure.colorbar(image, ax=axes, label="median prediction error (-)")

        return chart(draw, (7.0, 1.6 + 0.19 * len(methods)), "prediction error of method and vessel")


def _move(row) -> str:
    return f"{row['moved']} by {row['places']:+d}" if row["places"] else MISSING


def _levels(axes, curves, levels: Sequence[str]) -> None:
    """A line a method over levels; values that are zero or infinite stand as marks at the edges."""
    finite = [v for curve in curves.values() for v in curve.values() if np.isfinite(v) and v > 1e-9]
    low, high = (min(finite) / 3.0, max(finite) * 3.0) if finite else (1e-9, 1.0)
    for method, curve in curves.items():
        values = [curve.get(level, np.nan) for level in levels]
        inside = [v if np.isfinite(v) and v > 1e-9 else np.nan for v in values]
        (line,) = axes.plot(range(len(levels)), inside, marker="o", markersize=4, label=method)
        for place, value in enumerate(values):
            if np.isinf(value) or value <= 1e-9:
                edge, mark = (high, "^") if np.isinf(value) else (low, "v")
                axes.plot([place], [edge], mark, color=line.get_color(), markersize=6, clip_on=False)


def _profiles(errors: np.ndarray, methods: Sequence[str]) -> str:
    if len(errors) < 2 or len(methods) < 2:
        return ""
    shares = profiles.performance_profiles(errors, FACTORS)

    def draw(figure) -> None:
        from matplotlib.ticker import PercentFormatter

        axes = figure.subplots()
        for j, method in enumerate(methods[:DRAWN]):
            axes.step(FACTORS, shares[:, j], where="post", label=method)
        axes.set(xscale="log", xlabel="factor of the least error (-)", xlim=(1.0, 100.0))
        axes.set(ylabel="problems", ylim=(0.0, 1.02))
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
        legend_beside(axes)

    return chart(draw, (7.0, 3.6), "performance profiles")


def _difference_diagram(own: PairedComparison) -> str:
    m = len(own.methods)
    if m < 2 or own.n < 2:
        return ""

    def draw(figure) -> None:
        axes = figure.subplots()
        axes.plot(own.mean_ranks, range(m), "o", markersize=5)
        for i, (method, rank) in enumerate(zip(own.methods, own.mean_ranks, strict=True)):
            told = f"{method}  {rank:.2f}"
            axes.annotate(told, (rank, i), (8, 0), textcoords="offset points", va="center", fontsize=8)
        low = own.mean_ranks.min()
        for k, (first, last) in enumerate(own.groups):
            place = low - 0.25 - 0.22 * (k % 6)
            axes.plot([place, place], [first - 0.2, last + 0.2], linewidth=3.0, color=SOFT, solid_capstyle="butt")
        width = own.mean_ranks.max() - low
        axes.set(xlabel="mean rank", ylim=(m - 0.4, -0.6), xlim=(low - 1.6, own.mean_ranks.max() + 0.35 * width + 1.5))
        axes.set_yticks([])
        axes.spines["left"].set_visible(False)

    return chart(draw, (7.0, 1.2 + 0.19 * m), "critical-difference diagram")
