"""The figures of paper 001; each function adds axes to an empty matplotlib figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.model import resolve
from ..study import StudyResult
from . import studies

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MANOEUVRES = ("15° zigzag", "15° sine", "15° turn", "30° zigzag", "30° sine", "30° turn")
LINES = {"A1p": "published A1", "A2p": "published A2", "A1": "A1", "midpoint": "central differences"}


def draw_data(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figure 1: speeds, yaw rate, heading and rudder of the 15 deg zigzag."""
    series = results[0].series
    time = series["Figure 1.time_s"]
    panels = (("surge_m_s", 1.0, "u, m/s"), ("sway_m_s", 1.0, "v, m/s"), ("yaw_rate_rad_s", np.rad2deg(1.0), "r, °/s"))
    axes = figure.subplots(2, 2, sharex=True).ravel()
    for ax, (name, unit, label) in zip(axes, panels, strict=False):
        ax.plot(time, unit * series[f"Figure 1.{name}"])
        ax.set_ylabel(label)
    axes[3].plot(time, np.rad2deg(series["Figure 1.heading_rad"]), label="heading")
    axes[3].plot(time, np.rad2deg(series["Figure 1.rudder_rad"]), label="rudder (positive to port)")
    axes[3].set_ylabel("°")
    axes[3].legend()
    for ax in axes[2:]:
        ax.set_xlabel("t, s")


def draw_headings(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 2-7 (a): heading of the original and of free runs with the same rudder."""
    figure.set_size_inches(8.5, 5.0)
    series = results[0].series
    for ax, number, title in _six(figure):
        time = series[f"{number}.time_s"]
        ax.plot(time, np.rad2deg(series[f"{number}.heading_rad"]), color="0.6", linewidth=3.0, label="original")
        for name, label in LINES.items():
            ax.plot(time, np.rad2deg(series[f"{number}.{name}.heading"]), label=label, linestyle=_style(name))
        ax.set(title=title, xlabel="t, s", ylabel="heading, °")
        _within(ax, np.rad2deg(series[f"{number}.heading_rad"]))
    _legend(figure)


def draw_trajectories(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 2-7 (b): tracks."""
    figure.set_size_inches(8.5, 5.5)
    series = results[0].series
    for ax, number, title in _six(figure):
        east, north = series[f"{number}.east_m"], series[f"{number}.north_m"]
        ax.plot(east, north, color="0.6", linewidth=3.0, label="original")
        for name, label in LINES.items():
            line = series[f"{number}.{name}.east"], series[f"{number}.{name}.north"]
            ax.plot(*line, label=label, linestyle=_style(name))
        ax.set(title=title, xlabel="east, m", ylabel="north, m")
        _within(ax, north)
        _within(ax, east, "x")
    _legend(figure)


def draw_coefficients(results: Sequence[StudyResult], figure: Figure) -> None:
    """Table 2: published columns and ours, relative to the true coefficients."""
    figure.set_size_inches(8.5, 5.0)
    names, true = _original()
    used = true != 0.0
    columns = {f"published {c}": studies.published(c) for c in ("A1", "A2")}
    ours = np.array([[result.values[f"A1.{name}"] for name in names] for result in results], float)
    ax = figure.subplots()
    place = np.arange(int(used.sum()))
    error = np.abs(ours / np.where(used, true, 1.0) - 1.0)[:, used]
    ax.vlines(
        place, *np.nanquantile(error, [0.025, 0.975], axis=0), color="0.7", linewidth=5.0, label="A1, 40 settings"
    )
    for label, column in columns.items():
        ax.plot(place, np.maximum(np.abs(column[used] / true[used] - 1.0), 1e-4), "o", markersize=4.0, label=label)
    ax.set(yscale="log", ylabel="relative error")
    ax.set_xticks(place, [name for name, keep in zip(names, used, strict=True) if keep], rotation=90)
    ax.legend()


def draw_accuracy(results: Sequence[StudyResult], figure: Figure) -> None:
    """Median error of A1, A2 and the other pairings against the length of the record."""
    series = results[0].series
    ax = figure.subplots()
    titles = {"A2": "A2", "A1": "A1 (forward)", "backward": "A1, backward", "midpoint": "central differences"}
    for name, label in titles.items():
        ax.plot(series["duration_s"], series[name], "o-", markersize=3.0, label=label)
    ax.axhline(results[0].values["A1 column"], color="0.5", linestyle="--", label="A1 column of Table 2")
    ax.set(yscale="log", xlabel="length of the record, s", ylabel="median error of 40 coefficients, %")
    ax.legend(loc="center right")


def draw_explanation(results: Sequence[StudyResult], figure: Figure) -> None:
    """The A1 column against what backward differences and another inertia matrix give."""
    figure.set_size_inches(7.5, 4.6)
    series = results[0].series
    names, _ = _original()
    panels = {"backward.alone": "backward differences", "backward": "and another inertia matrix"}
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    size = np.abs(series["published"])
    ends = [size.min() / 2.0, size.max() * 2.0]
    for ax, (key, title) in zip(axes, panels.items(), strict=True):
        for letter in "XYN":
            own = np.array([name[0] == letter for name in names])
            ax.plot(size[own], np.abs(series[key][own]), "o", markersize=3.5, label=f"{letter} coefficients")
        ax.plot(ends, ends, color="0.6", linewidth=0.8)
        ax.set(xscale="log", yscale="log", title=title, xlabel="|published A1|")
    axes[0].set_ylabel("|ours|")
    axes[0].legend()


def _original() -> tuple[Sequence[str], np.ndarray]:
    model = resolve("mariner-model")
    return model.coordinates, model.coefficients


def _six(figure: Figure):
    """(axes, "Figure n", title) of six panels."""
    axes = figure.subplots(2, 3).ravel()
    return zip(axes, (f"Figure {n}" for n in range(2, 8)), MANOEUVRES, strict=True)


def _style(name: str) -> str:
    return "--" if name == "midpoint" else "-"


def _within(ax: Any, values: np.ndarray, axis: str = "y") -> None:
    """Limits of the observed range and a third of it on either side."""
    room = max(float(np.ptp(values)) / 3.0, 1.0)
    ax.set(**{f"{axis}lim": (values.min() - room, values.max() + room)})


def _legend(figure: Figure) -> None:
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
