"""Drawings of paper 000: its figures again, and what continuous records and noise do to its regression."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..study import StudyResult
from .records import ORDER, vehicle
from .studies import ANGLES, NOISE_DEG

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = {"rls": "RLS", "fw": "FW-RLS", "printed": "eq. (22) as printed"}
METHODS = {
    "rls": "RLS",
    "fw": "FW-RLS",
    "integral": "LS of the integrated equation",
    "oe": "output error",
}


def draw_zigzag(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figure 1: rudder and yaw angle of the 20/20 zigzag."""
    series = results[0].series
    axes = figure.subplots()
    axes.step(series["time_s"], series["rudder_deg"], where="pre", label="rudder")
    axes.plot(series["time_s"], series["heading_deg"], label="yaw angle")
    axes.set(xlabel="time [s]", ylabel="angle [deg]")
    axes.legend()


def draw_convergence(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 2 and 3: the four parameters along the recursions."""
    figure.set_size_inches(7.5, 5.2)
    series = results[0].series
    for axes, name in zip(figure.subplots(2, 2, sharex=True).flat, ORDER, strict=True):
        truth = vehicle().parameters[name]
        axes.axhline(truth, color="#888888", linewidth=0.8)
        for method, label in SHOWN.items():
            axes.plot(series["path_time_s"], series[f"{method}_{name}"], label=label)
        axes.set(title=name, xlim=(0.0, 20.0), ylim=(-0.1 * truth, 1.4 * truth))
    figure.supxlabel("time [s]")
    figure.axes[0].legend()


def draw_errors(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 4 and 5: sizes of the errors."""
    figure.set_size_inches(7.5, 5.2)
    series = results[0].series
    for axes, name in zip(figure.subplots(2, 2, sharex=True, sharey=True).flat, ORDER, strict=True):
        for method, label in SHOWN.items():
            error = np.abs(series[f"{method}_{name}"] - vehicle().parameters[name])
            axes.semilogy(series["path_time_s"], np.maximum(error, 1e-8), label=label)
        axes.set(title=name)
    figure.supxlabel("time [s]")
    figure.supylabel("size of the error")
    figure.axes[0].legend()


def draw_prediction(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 6 and 7: errors of the yaw angle in a sine manoeuvre, of the printed rows and of ours."""
    figure.set_size_inches(7.5, 5.2)
    series = results[0].series
    above, below = figure.subplots(2, 1, sharex=True)
    for angle in ANGLES:
        above.plot(series["time_s"], series[f"rows_printed_{angle}_deg"], label=f"{angle} deg")
        below.semilogy(series["time_s"], np.maximum(np.abs(series[f"fw_{angle}_deg"]), 1e-7), label=f"{angle} deg")
    above.set(title="rows of Table 3 as printed", ylabel="yaw angle error [deg]")
    below.set(title="FW-RLS computed again", xlabel="time [s]", ylabel="size of the error [deg]")
    above.legend(title="zigzag")


def draw_continuous(results: Sequence[StudyResult], figure: Figure) -> None:
    """What eq 8 finds on records of eq 5 at smaller and smaller steps."""
    series = results[0].series
    axes = figure.subplots()
    for name in ORDER:
        axes.semilogx(series["step_s"], series[name] / vehicle().parameters[name], "o-", label=name)
    axes.axhline(1.0, color="#888888", linewidth=0.8)
    axes.set(xlabel="sampling step [s]", ylabel="found over true")
    axes.legend()


def draw_noise(results: Sequence[StudyResult], figure: Figure) -> None:
    """Root mean square error of the worst parameter over the Cramer-Rao bound, against heading noise."""
    axes = figure.subplots()
    for method, label in METHODS.items():
        ratios = [[result.values[f"{method}_{level}_ratio"] for result in results] for level in NOISE_DEG]
        axes.loglog([*NOISE_DEG.values()], np.median(ratios, axis=1), "o-", label=label)
    axes.axhline(1.0, color="#888888", linewidth=0.8)
    axes.set(xlabel="heading noise [deg]", ylabel="rms error over the bound")
    axes.legend()
