"""How an estimate is shown: a figure of its predictions, and a table for notebooks."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.display import Curve, continuous, html_table, time_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..datasets.record import Record
    from .estimate import Estimate


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
