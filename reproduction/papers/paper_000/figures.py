"""Drawings of paper 000: its figures again, and what continuous records and noise do to its regression.

Each function plots on the axes that its claims file states.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..study import Results, Series
from .records import ORDER, vehicle
from .studies import ANGLES, NOISE_DEG

SHOWN = {"rls": "RLS", "fw": "FW-RLS", "printed": "eq. (22) as printed"}
METHODS = {
    "rls": "RLS",
    "fw": "FW-RLS",
    "integral": "LS of the integrated equation",
    "oe": "output error",
}


def draw_zigzag(axes: Any, series: Series, results: Results) -> None:
    """Figure 1: rudder and yaw angle of the 20/20 zigzag."""
    axes.step(series["time_s"], series["rudder_deg"], where="pre", label="rudder")
    axes.plot(series["time_s"], series["heading_deg"], label="yaw angle")


def draw_convergence(panels: Any, series: Series, results: Results) -> None:
    """Figures 2 and 3: the four parameters along the recursions."""
    for axes, name in zip(panels, ORDER, strict=True):
        truth = vehicle().parameters[name]
        axes.axhline(truth, color="#888888", linewidth=0.8)
        for method, label in SHOWN.items():
            axes.plot(series["path_time_s"], series[f"{method}_{name}"], label=label)
        axes.set(title=name, ylim=(-0.1 * truth, 1.4 * truth))


def draw_errors(panels: Any, series: Series, results: Results) -> None:
    """Figures 4 and 5: sizes of the errors."""
    for axes, name in zip(panels, ORDER, strict=True):
        for method, label in SHOWN.items():
            error = np.abs(series[f"{method}_{name}"] - vehicle().parameters[name])
            axes.semilogy(series["path_time_s"], np.maximum(error, 1e-8), label=label)
        axes.set(title=name)


def draw_prediction(panels: Any, series: Series, results: Results) -> None:
    """Figures 6 and 7: errors of the yaw angle in a sine manoeuvre, of the printed rows and of ours."""
    above, below = panels
    for angle in ANGLES:
        above.plot(series["time_s"], series[f"rows_printed_{angle}_deg"], label=f"{angle} deg")
        below.semilogy(series["time_s"], np.maximum(np.abs(series[f"fw_{angle}_deg"]), 1e-7), label=f"{angle} deg")


def draw_continuous(axes: Any, series: Series, results: Results) -> None:
    """What eq 8 finds on records of eq 5 at smaller and smaller steps."""
    for name in ORDER:
        axes.semilogx(series["step_s"], series[name] / vehicle().parameters[name], "o-", label=name)
    axes.axhline(1.0, color="#888888", linewidth=0.8)


def draw_noise(axes: Any, series: Series, results: Results) -> None:
    """Root mean square error of the worst parameter over the Cramer-Rao bound, against heading noise."""
    for method, label in METHODS.items():
        ratios = [[result.values[f"{method}_{level}_ratio"] for result in results] for level in NOISE_DEG]
        axes.loglog([*NOISE_DEG.values()], np.median(ratios, axis=1), "o-", label=label)
    axes.axhline(1.0, color="#888888", linewidth=0.8)
