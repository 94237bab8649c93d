"""The figures of paper 002, and three that explain them; each function plots on axes that the claims file states."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..study import Results, Series

METHODS = {
    "basic": "basic",
    "fci.without": "FCI-LS, β = 0",
    "fci": "FCI-LS, corrected",
    "fci.printed": "FCI-LS as printed",
}
RUNS = ("25/5", "10/10 P", "10/10 S")
TANK = {
    "integrator": "pure integrator",
    "fci.radians": "FCI-LS as printed, rad",
    "fci": "FCI-LS corrected",
    "ls": "least squares",
    "ls .5 s": "least squares, 0.5 s",
    "oe": "output error, 1st order",
    "oe-2": "output error, 2nd order",
    "oe-2-speed": "2nd order, |r|r, offset, U^m",
}


def draw_convergence(panels: Any, series: Series, results: Results) -> None:
    """Figures 1 and 2: error of every parameter along the recursion."""
    names = [key.removeprefix("basic.") for key in series if key.startswith("basic.")]
    for ax, name in zip(panels, names, strict=False):
        for key, label in METHODS.items():
            if f"{key}.{name}" in series:
                ax.plot(100.0 * series[f"{key}.{name}"], label=label)
        ax.axhspan(-5.0, 5.0, color="0.92", zorder=0)
        ax.set(ylim=(-60.0, 60.0), ylabel=f"error of {name}, %")
    for ax in panels[len(names) :]:
        ax.set_axis_off()
    for ax in panels[max(len(names) - 2, 0) : len(names)]:
        ax.set_xlabel("t, s")
        ax.xaxis.set_tick_params(labelbottom=True)


def draw_noise(axes: Any, series: Series, results: Results) -> None:
    """Error of K against the noise, medians of the runs."""
    for key, label in METHODS.items():
        name = {"fci.without": "without"}.get(key, key)
        lines = np.array([result.series[name] for result in results])
        axes.plot(series["sd_deg_s"], 100.0 * np.nanmedian(lines, axis=0), "o-", markersize=3.0, label=label)
    axes.axvline(np.sqrt(0.05), color="0.5", linestyle="--", label="variance 0.05 (°/s)²")


def draw_beta(axes: Any, series: Series, results: Results) -> None:
    """Error of K after FCI-LS against beta, up to where it diverges."""
    titles = {"rad": "as printed, rad", "deg": "as printed, degrees", "corrected": "corrected"}
    for key, label in titles.items():
        axes.plot(series["share"], 100.0 * series[key], "o-", markersize=3.0, label=label)
    axes.axvline(1.0, color="0.5", linestyle="--")


def draw_tank_course(panels: Any, series: Series, results: Results) -> None:
    """Figure 3: K, T and alpha along the recursion on the 15/5 zigzag."""
    for ax, name in zip(panels, ("K", "T", "alpha"), strict=True):
        ax.plot(series["time_s"], series[f"course.{name}"])


def draw_tank(axes: Any, series: Series, results: Results) -> None:
    """Figure 4 in numbers: R^2 of the predicted yaw rate of three runs."""
    place = np.arange(len(TANK))
    for k, run in enumerate(RUNS):
        heights = [np.nan_to_num(series[f"r2.{name}"][k]) for name in TANK]
        axes.bar(place + 0.27 * (k - 1), np.maximum(heights, 0.0), 0.25, label=run)
    axes.set_xticks(place, list(TANK.values()), rotation=25, ha="right")
    axes.set_axisbelow(True)
