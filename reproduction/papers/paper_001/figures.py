"""The figures of paper 001; each function plots on the axes that its claims file states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....models.model import resolve
from ..study import Results, Series
from . import studies

NUMBERS = tuple(f"Figure {n}" for n in range(2, 8))
LINES = {"A1p": "published A1", "A2p": "published A2", "A1": "A1", "midpoint": "central differences"}


def draw_data(panels: Any, series: Series, results: Results) -> None:
    """Figure 1: speeds, yaw rate, heading and rudder of the 15 deg zigzag."""
    time = series["Figure 1.time_s"]
    units = {"surge_m_s": 1.0, "sway_m_s": 1.0, "yaw_rate_rad_s": np.rad2deg(1.0)}
    for ax, (name, unit) in zip(panels, units.items(), strict=False):
        ax.plot(time, unit * series[f"Figure 1.{name}"])
    panels[3].plot(time, np.rad2deg(series["Figure 1.heading_rad"]), label="heading")
    panels[3].plot(time, np.rad2deg(series["Figure 1.rudder_rad"]), label="rudder (positive to port)")


def draw_headings(panels: Any, series: Series, results: Results) -> None:
    """Figures 2-7 (a): heading of the original and of free runs with the same rudder."""
    for ax, number in zip(panels, NUMBERS, strict=True):
        time = series[f"{number}.time_s"]
        ax.plot(time, np.rad2deg(series[f"{number}.heading_rad"]), color="0.6", linewidth=3.0, label="original")
        for name, label in LINES.items():
            ax.plot(time, np.rad2deg(series[f"{number}.{name}.heading"]), label=label, linestyle=_style(name))
        _within(ax, np.rad2deg(series[f"{number}.heading_rad"]))


def draw_trajectories(panels: Any, series: Series, results: Results) -> None:
    """Figures 2-7 (b): tracks."""
    for ax, number in zip(panels, NUMBERS, strict=True):
        east, north = series[f"{number}.east_m"], series[f"{number}.north_m"]
        ax.plot(east, north, color="0.6", linewidth=3.0, label="original")
        for name, label in LINES.items():
            line = series[f"{number}.{name}.east"], series[f"{number}.{name}.north"]
            ax.plot(*line, label=label, linestyle=_style(name))
        _within(ax, north)
        _within(ax, east, "x")


def draw_coefficients(axes: Any, series: Series, results: Results) -> None:
    """Table 2: published columns and ours, relative to the true coefficients."""
    names, true = _original()
    used = true != 0.0
    columns = {f"published {c}": studies.published(c) for c in ("A1", "A2")}
    ours = np.array([[result.values[f"A1.{name}"] for name in names] for result in results], float)
    place = np.arange(int(used.sum()))
    error = np.abs(ours / np.where(used, true, 1.0) - 1.0)[:, used]
    ends = np.nanquantile(error, [0.025, 0.975], axis=0)
    axes.vlines(place, *ends, color="0.7", linewidth=5.0, label="A1, 40 settings")
    for label, column in columns.items():
        axes.plot(place, np.maximum(np.abs(column[used] / true[used] - 1.0), 1e-4), "o", markersize=4.0, label=label)
    axes.set_xticks(place, [name for name, keep in zip(names, used, strict=True) if keep], rotation=90)


def draw_accuracy(axes: Any, series: Series, results: Results) -> None:
    """Median error of A1, A2 and the other pairings against the length of the record."""
    titles = {"A2": "A2", "A1": "A1 (forward)", "backward": "A1, backward", "midpoint": "central differences"}
    for name, label in titles.items():
        axes.plot(series["duration_s"], series[name], "o-", markersize=3.0, label=label)
    axes.axhline(results[0].values["A1 column"], color="0.5", linestyle="--", label="A1 column of Table 2")


def draw_explanation(panels: Any, series: Series, results: Results) -> None:
    """The A1 column against what backward differences and another inertia matrix give."""
    names, _ = _original()
    size = np.abs(series["published"])
    ends = [size.min() / 2.0, size.max() * 2.0]
    for ax, key in zip(panels, ("backward.alone", "backward"), strict=True):
        for letter in "XYN":
            own = np.array([name[0] == letter for name in names])
            ax.plot(size[own], np.abs(series[key][own]), "o", markersize=3.5, label=f"{letter} coefficients")
        ax.plot(ends, ends, color="0.6", linewidth=0.8)


def _original() -> tuple[Sequence[str], np.ndarray]:
    model = resolve("mariner-model")
    return model.coordinates, model.coefficients


def _style(name: str) -> str:
    return "--" if name == "midpoint" else "-"


def _within(ax: Any, values: np.ndarray, axis: str = "y") -> None:
    """Limits of the observed range and a third of it on either side."""
    room = max(float(np.ptp(values)) / 3.0, 1.0)
    ax.set(**{f"{axis}lim": (values.min() - room, values.max() + room)})
