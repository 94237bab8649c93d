"""Figures of paper 003's page; each function plots on the axes that the claims file states."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ....models.model import resolve
from ..study import Results, Series
from .identification import PARAMETERS, table_5
from .robustness import FORMS

RUNS = (
    ("true", "simulated", "#222222"),
    ("corrected", "observer, corrected", "#1b6ca8"),
    ("as_printed", "observer, as printed", "#d1495b"),
)
LEAST_DRAWN = 1e-16
"""Where a curve of convergence that has come to its end is drawn."""
FORM_NAMES = {
    "ls": "LS-SVR",
    "printed": "RW-LSSVR as printed",
    "weights": "weights in |e|",
    "corrected": "RW-LSSVR corrected",
}


def draw_states(panels: Any, series: Series, results: Results) -> None:
    """Heading and yaw acceleration, simulated and as both forms of the observer see them, and the latter's errors."""
    part = slice(0, len(series["time"]) // 3)
    time = series["time"][part]
    for axis, name in zip(panels, ("psi", "psi_ddot"), strict=False):
        for run, title, colour in RUNS:
            dashes = "--" if run == "corrected" else "-"
            axis.plot(time, series[f"{run}_{name}"][part], dashes, color=colour, label=title)
        axis.set_ylim(np.array([-1.2, 1.9]) * np.abs(series[f"as_printed_{name}"][part]).max())
    for run, _, colour in RUNS[1:]:
        error = series[f"{run}_psi_ddot"] - series["true_psi_ddot"]
        panels[2].plot(time, error[part], color=colour)


def _errors(vessel: str, axis: Any, series: Series, results: Results) -> None:
    """Errors of a vessel's parameters."""
    truth = np.array([resolve(vessel).parameters[name] for name in PARAMETERS])
    kinds = {"corrected_rw": "our runs, RW-LSSVR corrected", "as_printed_rw": "our runs, as printed"}
    for shift, (kind, title) in zip((-0.15, 0.15), kinds.items(), strict=True):
        found = np.array([[run.values[f"{kind}_{name}"] for name in PARAMETERS] for run in results], float)
        places = np.broadcast_to(np.arange(4) + shift, found.shape)
        axis.plot(places.ravel(), 100.0 * (found / truth - 1.0).ravel(), "o", ms=3, alpha=0.6, label=title)
    for marker, method, title in (("D", "rw", "published, RW-LSSVR"), ("x", "ls", "published, LS-SVR")):
        errors = 100.0 * (table_5(vessel, method) / truth - 1.0)
        axis.plot(np.arange(4), errors, marker, color="#222222", ms=5, label=title)
    axis.set_yscale("symlog", linthresh=0.1)
    axis.set_xticks(range(4), PARAMETERS)


draw_errors_cargo, draw_errors_patrol = partial(_errors, "cargo"), partial(_errors, "patrol")


def draw_prediction(panels: Any, series: Series, results: Results) -> None:
    """Third derivative of the heading over the validation samples, and the models' errors."""
    upper, lower = panels
    part = slice(0, len(series["time"]) // 4)
    models = {
        "truth": ("simulated", "#222222"),
        "corrected_rw": ("RW-LSSVR corrected", "#1b6ca8"),
        "table_5": ("parameters of Table 5", "#d1495b"),
    }
    for name, (title, colour) in models.items():
        upper.plot(series["time"][part], series[name][part], color=colour, label=title)
        if name != "truth":
            lower.plot(series["time"][part], (series[name] - series["truth"])[part], color=colour)
    upper.set_ylim(np.array([-1.0, 1.6]) * np.abs(series["truth"]).max() * 1.3)


def draw_outliers(panels: Any, series: Series, results: Results) -> None:
    """Worst parameter error with 10 % outliers, one by one and in bursts."""
    kinds = {"single": "single outliers", "burst": "in bursts"}
    for axis, (kind, title) in zip(panels, kinds.items(), strict=True):
        for place, name in enumerate(FORMS):
            values = np.array([run.values[f"{name}_{kind}"] for run in results], float)
            axis.plot(np.full(len(values), place), values, "o", ms=3, alpha=0.4)
            axis.plot([place - 0.3, place + 0.3], [np.median(values)] * 2, color="#222222")
        axis.set_xticks(range(len(FORMS)), [FORM_NAMES[name] for name in FORMS], rotation=25, ha="right")
        axis.set_title(title, fontsize=9)


def draw_convergence(panels: Any, series: Series, results: Results) -> None:
    """Least validation error of the colony after each of its cycles, above that after the last, one line a run."""
    for axis, vessel in zip(panels, ("cargo", "patrol"), strict=True):
        for method, title, colour in (("rw", "RW-LSSVR", "#1b6ca8"), ("ls", "LS-SVR", "#d1495b")):
            for place, run in enumerate(results):
                best = run.series[f"{vessel}_best_{method}"]
                excess = np.maximum(best / best[-1] - 1.0, LEAST_DRAWN)
                axis.step(np.arange(len(best)), excess, where="post", color=colour, label="" if place else title)
        axis.set_title(vessel, fontsize=9)
