"""What a comparison says: models or methods side by side, by free runs of records that took no part in the fit."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.display import shown_name, shown_unit
from ...estimation.estimates.comparison import HELD_OUT, TIME_BLOCKS
from ..numbers import SHORT, number, r_squared
from ..page import GOOD, QUESTIONS, Verdict, result_page
from ..plots import COLOURS, SOFT
from ..tables import Column, Table, field, make_table, numeric

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...estimation.estimates.comparison import Candidate, Comparison
    from ..page import Page


def page(comparison: Comparison) -> Page:
    """The page of models or methods side by side."""
    chosen = comparison.chosen
    return result_page(
        f"{len(comparison.candidates)} candidates",
        comparison.basis,
        Verdict(GOOD, f"Chosen is {chosen.model.id} by {chosen.method}.", (comparison_note(comparison),)),
        seen=[comparison_table(comparison)],
        titles=("Candidates", *QUESTIONS[1:]),
    )


def comparison_table(comparison: Comparison, title: str = "", note: str = "") -> Table:
    """Candidates side by side: errors of free runs, parameters, time; the chosen one is marked."""
    models = len({one.model.id for one in comparison.candidates}) > 1
    methods = len({one.method for one in comparison.candidates}) > 1
    columns = [
        *([Column("model", lambda one: one.model.id)] if models or not methods else []),
        *([field("method")] if methods else []),
        Column("coefficients", _coefficients, lambda one: one.n_parameters or None),
        numeric("error", "error"),
        *(column for channel in comparison.channels for column in _channel_columns(channel)),
        Column("parameters", _parameters_text),
        numeric("time, s", "wall_s", SHORT),
        Column("remark", lambda one: "chosen" if one is comparison.chosen else one.reason),
    ]
    return make_table(columns, comparison.candidates, title, note)


def _coefficients(one: Candidate) -> str:
    return "black box" if one.estimate is not None and one.estimate.predictor is not None else number(one.n_parameters)


def _channel_columns(channel: str) -> Sequence[Column]:
    def score(place: int, one: Candidate) -> float | None:
        return one.pooled(channel).scores()[place] if one.squares else None

    (unit, factor), name = shown_unit(channel), shown_name(channel)
    return (
        numeric(f"{name}, RMSE, {unit}", partial(score, 0), scale=factor),
        numeric(f"{name}, R²", partial(score, 1), r_squared),
    )


def _parameters_text(one: Candidate) -> str:
    values = {} if one.estimate is None else one.estimate.parameters
    shown = [f"{name} {number(value)}" for name, value in values.items()]
    return ", ".join(shown if len(shown) <= 5 else [*shown[:4], "..."])


def comparison_note(comparison: Comparison) -> str:
    """How the candidates were compared, in a few sentences."""
    count = len(comparison.tested)
    held_out = ", ".join(comparison.tested)
    how = {
        HELD_OUT: f"Fitted to the training records, run freely along the held-out records ({held_out}).",
        TIME_BLOCKS: f"The record was cut into {count} blocks of time; each was left out of a fit and run freely.",
    }.get(comparison.basis, f"Each of the {count} training records was left out of a fit and run freely.")
    channels = ", ".join(map(shown_name, comparison.channels))
    return (
        f"{how} Error: mean over {channels} of sqrt(SSE/SST). Chosen is the least "
        "error, or a model with fewer coefficients that is not worse by more than the standard error of the difference."
    )


def comparison_figure(comparison: Comparison) -> Figure:
    """The error of every candidate on each record that tests it, on a logarithmic axis; what failed is left out."""
    from ...models.figure import ShownFigure

    shown = [one for one in comparison.candidates if np.isfinite(one.error)]
    figure = ShownFigure(7.5, 1.2 + 0.32 * len(shown))
    axes = figure.subplots()
    for place, one in enumerate(shown):
        colour = COLOURS[0] if one is comparison.chosen else SOFT
        axes.plot(one.errors, [place] * len(one.errors), "|", color=colour, markersize=9)
        axes.plot(one.error, place, "o", color=colour)
    axes.set_yticks(range(len(shown)), [f"{one.model.id} by {one.method}" for one in shown])
    axes.set(xscale="log", ylim=(len(shown) - 0.5, -0.5), xlabel=f"error of free runs, {comparison.basis}")
    axes.grid(True, linewidth=0.3)
    return figure
