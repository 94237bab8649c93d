"""Figures of paper 003's page."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ....models.model import resolve
from ..study import StudyResult
from .identification import PARAMETERS, table_5
from .robustness import FORMS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RUNS = (
    ("true", "simulated", "#222222"),
    ("corrected", "observer, corrected", "#1b6ca8"),
    ("as_printed", "observer, as printed", "#d1495b"),
)
NAMES = {"psi": "heading, rad", "psi_ddot": "yaw acceleration, rad/s²"}
LEAST_DRAWN = 1e-16
"""Where a curve of convergence that has come to its end is drawn."""
FORM_NAMES = {
    "ls": "LS-SVR",
    "printed": "RW-LSSVR as printed",
    "weights": "weights in |e|",
    "corrected": "RW-LSSVR corrected",
}


def draw_states(results: Sequence[StudyResult], figure: Figure) -> None:
    """Heading and yaw acceleration, simulated and as both forms of the observer see them, and the latter's errors."""
    series = results[0].series
    part = slice(0, len(series["time"]) // 3)
    time = series["time"][part]
    axes = figure.subplots(3, 1, sharex=True)
    figure.set_size_inches(7.5, 6.0)
    for axis, (name, label) in zip(axes, NAMES.items(), strict=False):
        for run, title, colour in RUNS:
            dashes = "--" if run == "corrected" else "-"
            axis.plot(time, series[f"{run}_{name}"][part], dashes, color=colour, label=title)
        axis.set_ylim(np.array([-1.2, 1.9]) * np.abs(series[f"as_printed_{name}"][part]).max())
        axis.set_ylabel(label)
    for run, _, colour in RUNS[1:]:
        error = series[f"{run}_psi_ddot"] - series["true_psi_ddot"]
        axes[2].plot(time, error[part], color=colour)
    axes[0].legend(ncols=3, loc="upper right")
    axes[2].set_ylabel("its error, rad/s²")
    axes[2].set_xlabel("time, s")


def _errors(vessel: str, results: Sequence[StudyResult], figure: Figure) -> None:
    """Errors of a vessel's parameters."""
    truth = np.array([resolve(vessel).parameters[name] for name in PARAMETERS])
    axis = figure.subplots()
    kinds = {"corrected_rw": "our runs, RW-LSSVR corrected", "as_printed_rw": "our runs, as printed"}
    for shift, (kind, title) in zip((-0.15, 0.15), kinds.items(), strict=True):
        found = np.array([[run.values[f"{kind}_{name}"] for name in PARAMETERS] for run in results], float)
        places = np.broadcast_to(np.arange(4) + shift, found.shape)
        axis.plot(places.ravel(), 100.0 * (found / truth - 1.0).ravel(), "o", ms=3, alpha=0.6, label=title)
    for marker, (method, title) in zip(
        "Dx", {"rw": "published, RW-LSSVR", "ls": "published, LS-SVR"}.items(), strict=True
    ):
        errors = 100.0 * (table_5(vessel, method) / truth - 1.0)
        axis.plot(np.arange(4), errors, marker, color="#222222", ms=5, label=title)
    axis.set_yscale("symlog", linthresh=0.1)
    axis.set_xticks(range(4), PARAMETERS)
    axis.set_ylabel("error, %")
    axis.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, 1.18))


draw_errors_cargo, draw_errors_patrol = partial(_errors, "cargo"), partial(_errors, "patrol")


def draw_prediction(results: Sequence[StudyResult], figure: Figure) -> None:
    """Third derivative of the heading over the validation samples, and the models' errors."""
    series = results[0].series
    upper, lower = figure.subplots(2, 1, sharex=True)
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
    upper.legend(ncols=3, loc="upper right")
    upper.set_ylim(np.array([-1.0, 1.6]) * np.abs(series["truth"]).max() * 1.3)
    upper.set_ylabel("third derivative, rad/s³")
    lower.set_ylabel("error, rad/s³")
    lower.set_xlabel("time since the start of validation, s")


def draw_outliers(results: Sequence[StudyResult], figure: Figure) -> None:
    """Worst parameter error with 10 % outliers, one by one and in bursts."""
    for axis, (kind, title) in zip(
        figure.subplots(1, 2, sharey=True), {"single": "single outliers", "burst": "in bursts"}.items(), strict=True
    ):
        for place, name in enumerate(FORMS):
            values = np.array([run.values[f"{name}_{kind}"] for run in results], float)
            axis.plot(np.full(len(values), place), values, "o", ms=3, alpha=0.4)
            axis.plot([place - 0.3, place + 0.3], [np.median(values)] * 2, color="#222222")
        axis.set_yscale("log")
        axis.set_xticks(range(len(FORMS)), [FORM_NAMES[name] for name in FORMS], rotation=25, ha="right")
        axis.set_title(title, fontsize=9)
        axis.set_ylim(0.03, 100.0)
    figure.axes[0].set_ylabel("worst parameter error, %")


def draw_convergence(results: Sequence[StudyResult], figure: Figure) -> None:
    """Least validation error of the colony after each of its cycles, above that after the last, one line a run."""
    figure.set_size_inches(7.5, 3.0)
    for axis, vessel in zip(figure.subplots(1, 2, sharey=True), ("cargo", "patrol"), strict=True):
        for method, title, colour in (("rw", "RW-LSSVR", "#1b6ca8"), ("ls", "LS-SVR", "#d1495b")):
            for place, run in enumerate(results):
                best = run.series[f"{vessel}_best_{method}"]
                excess = np.maximum(best / best[-1] - 1.0, LEAST_DRAWN)
                axis.step(np.arange(len(best)), excess, where="post", color=colour, label="" if place else title)
        axis.set_yscale("log")
        axis.set_title(vessel, fontsize=9)
        axis.set_xlabel("cycles of 60 evaluations, after 30 first ones")
    figure.axes[0].set_ylabel("error above the last one (-)")
    figure.axes[0].legend(loc="upper right")
