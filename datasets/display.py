"""How records are shown: figures of time series, and tables for notebooks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from ..models.display import html_table
from ..models.errors import BadInput
from .columns import CANONICAL, UNITS, in_order
from .geometry import unwrapped
from .indices_of_many import INDICES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .many import SimulatedRuns
    from .record import Record

IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}
"""SI unit -> the unit in which it is shown."""
COLOURS = ("#222222", "#d1495b", "#1b6ca8", "#2e8b57")
WIDTH_IN, PANEL_IN = 8.0, 1.7


@dataclass(frozen=True)
class Curve:
    """A labelled line: time_s (N,) s and values (N,) in the SI unit of its panel's channel."""

    label: str
    time_s: np.ndarray
    values: np.ndarray


def shown_unit(channel: str) -> tuple[str, float]:
    """The unit in which a channel is shown, and the factor to it from SI."""
    return _shown(CANONICAL[channel])


def _shown(unit: str) -> tuple[str, float]:
    return (IN_DEGREES[unit], 180.0 / math.pi) if unit in IN_DEGREES else (unit, 1.0)


def shown_name(channel: str) -> str:
    """`yaw rate` for `yaw_rate_rad_s`."""
    suffix = next(iter(UNITS[CANONICAL[channel]]))
    return channel.removesuffix(f"_{suffix}").replace("_", " ")


def record_figure(record: Record, channels: Sequence[str] | None = None) -> Figure:
    """The channels of a record over time, one panel each; BadInput where there is none."""
    names = in_order(record.channels) if channels is None else list(channels)
    if not names:
        raise BadInput("no channel to draw", file=record.name, hint=f"it has {', '.join(record.channels) or 'none'}")
    panels = {name: [Curve("", record.time_s, continuous(name, record.column(name)))] for name in names}
    return time_figure(panels, record.name)


def time_figure(panels: Mapping[str, Iterable[Curve]], title: str) -> Figure:
    """Curves over time, one panel a channel below the other; a legend where the curves have labels."""
    from ..models.figure import ShownFigure

    figure = ShownFigure(WIDTH_IN, 0.8 + PANEL_IN * len(panels))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for (channel, curves), panel in zip(panels.items(), axes, strict=True):
        unit, factor = shown_unit(channel)
        for colour, curve in zip(COLOURS, curves, strict=False):
            panel.plot(curve.time_s, factor * curve.values, color=colour, linewidth=1.0, label=curve.label or None)
        panel.set_ylabel(f"{shown_name(channel)}\n[{unit}]")
        panel.grid(True, linewidth=0.3)
    handles, labels = axes[0].get_legend_handles_labels()
    if labels:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize="small")
    axes[-1].set_xlabel("time [s]")
    figure.suptitle(title, fontsize="medium")
    return figure


def continuous(channel: str, values: np.ndarray) -> np.ndarray:
    """The samples (N,) of a channel; a heading without jumps of a full turn."""
    return unwrapped(values) if channel == "heading_rad" else values


def record_html(record: Record, extent: str) -> str:
    """A record as a table for notebooks: smallest, mean and largest value of each channel, and its gaps."""
    rows = [_channel_row(name, record.column(name)) for name in in_order(record.channels)]
    table = html_table(("channel", "unit", "smallest", "mean", "largest", "gaps"), rows)
    facts = [record.meta.vessel, record.meta.manoeuvre, record.meta.source]
    side = record.meta.positive_rudder
    facts.append(f"positive rudder to {side}" if side else None)
    told = "; ".join(escape(fact) for fact in facts if fact)
    return f"<p><b>{escape(record.name)}</b>: {escape(extent)}{'<br>' + told if told else ''}</p>{table}"


def runs_html(runs: SimulatedRuns) -> str:
    """Many runs as a table for notebooks: quantiles of the indices, and of the channels at the end of the runs."""
    rows = [_spread_row(name.replace("_", " "), INDICES[name], values) for name, values in runs.indices.items()]
    rows += [
        _spread_row(f"{shown_name(name)} at the end", CANONICAL[name], values[:, -1])
        for name, values in runs.channels.items()
    ]
    table = html_table(("quantity", "unit", "5 %", "median", "95 %"), rows)
    return f"<p>{escape(repr(runs)[1:-1])}</p>{table}"


def _spread_row(label: str, si_unit: str, values: np.ndarray) -> tuple[str, ...]:
    unit, factor = _shown(si_unit)
    known = factor * values[np.isfinite(values)]
    numbers = np.quantile(known, [0.05, 0.5, 0.95]) if known.size else (math.nan,) * 3
    return (label, unit, *(f"{number:.4g}" for number in numbers))


def _channel_row(name: str, values: np.ndarray) -> tuple[str, ...]:
    unit, factor = shown_unit(name)
    known = factor * continuous(name, values)[np.isfinite(values)]
    numbers = (known.min(), known.mean(), known.max()) if known.size else (math.nan,) * 3
    return (shown_name(name), unit, *(f"{number:.4g}" for number in numbers), str(values.size - known.size))
