"""Drawings of paper 004: zigzags of identified models, the influence of omega, and the unknown ship."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..study import StudyResult
from .studies import OMEGAS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = {"forces": "gusts and mean wave forces", "swell": "with first-order wave motion"}


def draw_printed_model(results: Sequence[StudyResult], figure: Figure) -> None:
    """Surge speed of the ship and of Table 2's model on the same rudder, until that diverges."""
    series = results[0].series
    axes = figure.subplots()
    axes.plot(series["time_s"], series["printed_ship_m_s"], label="ship")
    for name, label in (("printed", "Table 2, instantaneous-speed primes"), ("fixed", "Table 2, fixed-speed primes")):
        speed = series[f"{name}_printed_m_s"]
        axes.plot(series["time_s"], np.where(np.abs(speed) < 30.0, speed, np.nan), label=label)
    axes.set(xlabel="time [s]", ylabel="surge speed [m/s]", xlim=(0.0, 200.0))
    axes.legend()


def draw_tracks(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figure 3 (a): tracks of a calm zigzag, of the ship and of models identified in sea state 5."""
    series = results[0].series
    axes = figure.subplots()
    for name, label, style in (("ship", "ship", "-"), ("mi", "MILS (MI-RLS)", "-"), ("nmi", "NMI-RLS", "--")):
        track = series[f"{name}_m"]
        axes.plot(track[:, 1], track[:, 0], style, label=label)
    axes.set(xlabel="east [m]", ylabel="north [m]")
    axes.legend()


def draw_omega(results: Sequence[StudyResult], figure: Figure) -> None:
    """How far NMI-RLS is from MI-RLS, and how often its model cannot sail the zigzag, against omega."""
    left, right = figure.subplots(1, 2, sharex=True)
    for kind, label in KINDS.items():
        gap = [np.median([result.values[f"{kind}_{w:g}_gap"] for result in results]) for w in OMEGAS]
        lost = [np.mean([result.values[f"{kind}_{w:g}_diverged"] for result in results]) for w in OMEGAS]
        left.loglog(OMEGAS, gap, "o-", label=label)
        right.semilogx(OMEGAS, 100.0 * np.array(lost), "o-", label=label)
    left.set(xlabel="omega", ylabel="median relative difference to MI-RLS")
    right.set(xlabel="omega", ylabel="models that diverge [%]", ylim=(0.0, 100.0))
    left.legend()


def draw_unknown_ship(results: Sequence[StudyResult], figure: Figure) -> None:
    """Figures 5 and 6 with the KVLCC2 as the unknown ship, and a zigzag that was not trained on."""
    figure.set_size_inches(7.5, 5.6)
    series = next(result.series for result in results if result.series)
    titles = {"turn": "35 deg turn (trained on)", "zigzag": "20/20 zigzag (trained on)", "small": "10/10 zigzag (new)"}
    circle, *others = figure.subplots(2, 2).flat
    for who, label in (("ship", "ship"), ("model", "NMI-RLS")):
        track = series[f"turn_{who}_m"]
        circle.plot(track[:, 1], track[:, 0], label=label)
        for axes, (name, title) in zip(others, titles.items(), strict=True):
            axes.plot(series[f"{name}_time_s"], series[f"{name}_{who}_deg_s"], label=label)
            axes.set(title=title, xlabel="time [s]", ylabel="yaw rate [deg/s]")
    circle.set(title="turning circle", xlabel="east [m]", ylabel="north [m]", aspect="equal")
    circle.legend()
