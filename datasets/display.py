"""How channels are shown: figures of time series, and rows of tables for notebooks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from .columns import CANONICAL, UNITS
from .geometry import unwrapped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}
"""SI unit -> the unit in which it is shown."""
COLOURS = ("#222222", "#d1495b", "#1b6ca8", "#2e8b57")
WIDTH_IN, PANEL_IN = 8.0, 1.7


LabelledLine: TypeAlias = tuple[str, np.ndarray, np.ndarray]
"""A label, '' for none, times (N,), s, and values (N,) in the SI unit of the panel's channel."""


def shown_unit(channel: str) -> tuple[str, float]:
    """The unit in which a channel is shown, and the factor to it from SI."""
    return _shown(CANONICAL[channel])


def _shown(unit: str) -> tuple[str, float]:
    return (IN_DEGREES[unit], 180.0 / math.pi) if unit in IN_DEGREES else (unit, 1.0)


def shown_name(channel: str) -> str:
    """`yaw rate` for `yaw_rate_rad_s`."""
    suffix = next(iter(UNITS[CANONICAL[channel]]))
    return channel.removesuffix(f"_{suffix}").replace("_", " ")


def time_figure(panels: Mapping[str, Iterable[LabelledLine]], title: str) -> Figure:
    """Curves over time, one panel a channel below the other; a legend where the curves have labels."""
    from ..models.figure import ShownFigure

    figure = ShownFigure(WIDTH_IN, 0.8 + PANEL_IN * len(panels))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for (channel, curves), panel in zip(panels.items(), axes, strict=True):
        unit, factor = shown_unit(channel)
        for colour, (label, time_s, values) in zip(COLOURS, curves, strict=False):
            panel.plot(time_s, factor * values, color=colour, linewidth=1.0, label=label or None)
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


def spread_row(label: str, si_unit: str, values: np.ndarray) -> tuple[str, ...]:
    """Texts of a quantity for a table: name, unit, and quantiles of its values (B,), given in SI."""
    unit, factor = _shown(si_unit)
    known = factor * values[np.isfinite(values)]
    numbers = np.quantile(known, [0.05, 0.5, 0.95]) if known.size else (math.nan,) * 3
    return (label, unit, *(f"{number:.4g}" for number in numbers))


def channel_row(name: str, values: np.ndarray) -> tuple[str, ...]:
    """Texts of a channel for a table: name, unit, smallest, mean and largest of its samples (N,), number of gaps."""
    unit, factor = shown_unit(name)
    known = factor * continuous(name, values)[np.isfinite(values)]
    numbers = (known.min(), known.mean(), known.max()) if known.size else (math.nan,) * 3
    return (shown_name(name), unit, *(f"{number:.4g}" for number in numbers), str(values.size - known.size))
