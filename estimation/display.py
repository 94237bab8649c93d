"""How an estimate is shown: a figure of its predictions, and a table for notebooks."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.display import Curve, continuous, time_figure
from ..models.display import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..datasets.record import Record
    from .estimate import Estimate
    from .identifiability import Identifiability


def estimate_figure(estimate: Estimate, record: Record) -> Figure:
    """Measured samples, free run and one-step prediction of a record, one panel a channel."""
    from .prediction import CHANNELS

    measured = record.turned(estimate.model.positive_rudder)
    free, one = estimate.simulate(record), estimate.predict(record)
    panels = {}
    for channel in (name for name in CHANNELS if free.has(name)):
        curves = [("measured", measured), ("one step", one), ("free run", free)]
        panels[channel] = [Curve(label, run.time_s, continuous(channel, run.column(channel))) for label, run in curves]
    return time_figure(panels, f"{estimate.model.family} by {estimate.method}: {record.name}")


def estimate_html(estimate: Estimate) -> str:
    """The parameters of an estimate with their standard errors."""
    title = f"<p><b>{escape(estimate.model.family)}</b> by {escape(estimate.method)}"
    state = "" if estimate.converged else f"; not converged: {escape(estimate.message)}"
    if estimate.predictor is not None:
        return f"{title}{state}; a black box without coefficients</p>"
    units = dict(zip(estimate.model.parameter_names, estimate.model.parameter_units, strict=True))
    errors = {name: _error(estimate.stderr.get(name, np.nan)) for name in estimate.parameters}
    rows = [(name, f"{value:.5g}", errors[name], units[name]) for name, value in estimate.parameters.items()]
    return f"{title}{state}</p>{html_table(('parameter', 'estimate', 'standard error', 'unit'), rows)}"


def _error(value: float) -> str:
    if np.isinf(value):
        return "not identified"
    return "" if np.isnan(value) else f"{value:.2g}" if value else "fixed"


def identifiability_html(found: Identifiability) -> str:
    """How well records determine parameters: a table, and the sentences."""
    rows = [(one.name, f"{one.value:.5g}", one.unit, _share(one.relative)) for one in found.parameters]
    table = html_table(("parameter", "value", "unit", "smallest relative standard deviation"), rows)
    return f"{table}<pre>{escape(chr(10).join(found.lines()))}</pre>"


def _share(relative: float) -> str:
    return "not determined" if np.isinf(relative) else "" if np.isnan(relative) else f"{100.0 * relative:.2g} %"


def identifiability_figure(found: Identifiability) -> Figure:
    """Smallest relative standard deviations by parameter, on a logarithmic axis; those not determined have no point."""
    from ..models.figure import ShownFigure
    from .identifiability import PRECISE, ROUGH

    names = [one.name for one in found.parameters]
    values = [one.relative if np.isfinite(one.relative) else np.nan for one in found.parameters]
    figure = ShownFigure(7.5, 1.2 + 0.22 * len(names))
    axes = figure.subplots()
    axes.plot(values, range(len(names)), "o", color="#1b6ca8", markersize=4)
    for edge in (PRECISE, ROUGH):
        axes.axvline(edge, color="#5b6b7b", linewidth=0.8, linestyle="--")
    axes.set_yticks(range(len(names)), names)
    axes.set(xscale="log", ylim=(len(names) - 0.5, -0.5), xlabel="smallest relative standard deviation")
    axes.grid(True, linewidth=0.3)
    return figure
