"""The figures of paper 002, and three that explain them; each function adds axes to an empty matplotlib figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..study import StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


def draw_convergence(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 1 and 2: error of every parameter along the recursion."""
    series = results[0].series
    names = [key.removeprefix("basic.") for key in series if key.startswith("basic.")]
    figure.set_size_inches(8.5, 1.7 * ((len(names) + 1) // 2) + 0.5)
    axes = figure.subplots((len(names) + 1) // 2, 2, sharex=True, squeeze=False).ravel()
    for ax, name in zip(axes, names, strict=False):
        for key, label in METHODS.items():
            if f"{key}.{name}" in series:
                ax.plot(100.0 * series[f"{key}.{name}"], label=label)
        ax.axhspan(-5.0, 5.0, color="0.92", zorder=0)
        ax.set(ylim=(-60.0, 60.0), ylabel=f"error of {name}, %")
    for ax in axes[len(names) :]:
        ax.set_axis_off()
    for ax in axes[max(len(names) - 2, 0) : len(names)]:
        ax.set_xlabel("t, s")
        ax.xaxis.set_tick_params(labelbottom=True)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)


def draw_noise(results: Sequence[StudyResult], figure: Figure) -> None:
    """Error of K against the noise, medians of the runs."""
    ax = figure.subplots()
    for key, label in METHODS.items():
        name = {"fci.without": "without"}.get(key, key)
        lines = np.array([result.series[name] for result in results])
        ax.plot(results[0].series["sd_deg_s"], 100.0 * np.nanmedian(lines, axis=0), "o-", markersize=3.0, label=label)
    ax.axvline(np.sqrt(0.05), color="0.5", linestyle="--", label="variance 0.05 (°/s)²")
    ax.set(xscale="log", yscale="log", xlabel="noise on the right side, °/s", ylabel="median error of K, %")
    ax.legend()


def draw_beta(results: Sequence[StudyResult], figure: Figure) -> None:
    """Error of K after FCI-LS against beta, up to where it diverges."""
    series = results[0].series
    ax = figure.subplots()
    titles = {"rad": "as printed, rad", "deg": "as printed, degrees", "corrected": "corrected"}
    for key, label in titles.items():
        ax.plot(series["share"], 100.0 * series[key], "o-", markersize=3.0, label=label)
    ax.axvline(1.0, color="0.5", linestyle="--")
    ax.set(xscale="log", yscale="log", xlabel="β as a share of 2/|φ|²", ylabel="error of K, %")
    ax.legend()


def draw_tank_course(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figure 3: K, T and alpha along the recursion on the 15/5 zigzag."""
    series = results[0].series
    axes = figure.subplots(1, 3)
    for ax, (name, unit) in zip(axes, {"K": "1/s", "T": "s", "alpha": "s²"}.items(), strict=True):
        ax.plot(series["time_s"], series[f"course.{name}"])
        ax.set(xlabel="t, s", ylabel=f"{name}, {unit}")


def draw_tank(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figure 4 in numbers: R^2 of the predicted yaw rate of three runs."""
    series = results[0].series
    ax = figure.subplots()
    place = np.arange(len(TANK))
    for k, run in enumerate(RUNS):
        heights = [np.nan_to_num(series[f"r2.{name}"][k]) for name in TANK]
        ax.bar(place + 0.27 * (k - 1), np.maximum(heights, 0.0), 0.25, label=run)
    ax.set_xticks(place, list(TANK.values()), rotation=25, ha="right")
    ax.set(ylim=(0.0, 1.15), ylabel="R² of the yaw rate in free run")
    ax.set_axisbelow(True)
    ax.legend(loc="upper left", ncols=3)
