"""Drawings of paper 004: zigzags of identified models, the influence of omega, and the unknown ship.

Each function plots on the axes that its claims file states.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..study import Results, Series
from .studies import OMEGAS

KINDS = {"forces": "gusts and mean wave forces", "swell": "with first-order wave motion"}


def draw_printed_model(axes: Any, series: Series, results: Results) -> None:
    """Surge speed of the ship and of Table 2's model on the same rudder, until that diverges."""
    axes.plot(series["time_s"], series["printed_ship_m_s"], label="ship")
    for name, label in (("printed", "Table 2, instantaneous-speed primes"), ("fixed", "Table 2, fixed-speed primes")):
        speed = series[f"{name}_printed_m_s"]
        axes.plot(series["time_s"], np.where(np.abs(speed) < 30.0, speed, np.nan), label=label)


def draw_tracks(axes: Any, series: Series, results: Results) -> None:
    """Figure 3 (a): tracks of a calm zigzag, of the ship and of models identified in sea state 5."""
    for name, label, style in (("ship", "ship", "-"), ("mi", "MILS (MI-RLS)", "-"), ("nmi", "NMI-RLS", "--")):
        track = series[f"{name}_m"]
        axes.plot(track[:, 1], track[:, 0], style, label=label)


def draw_omega(panels: Any, series: Series, results: Results) -> None:
    """How far NMI-RLS is from MI-RLS, and how often its model cannot sail the zigzag, against omega."""
    left, right = panels
    for kind, label in KINDS.items():
        gap = [np.median([result.values[f"{kind}_{w:g}_gap"] for result in results]) for w in OMEGAS]
        lost = [np.mean([result.values[f"{kind}_{w:g}_diverged"] for result in results]) for w in OMEGAS]
        left.loglog(OMEGAS, gap, "o-", label=label)
        right.semilogx(OMEGAS, 100.0 * np.array(lost), "o-", label=label)


def draw_unknown_ship(panels: Any, series: Series, results: Results) -> None:
    """Figures 5 and 6 with the KVLCC2 as the unknown ship, and a zigzag that was not trained on."""
    circle, *others = panels
    for who, label in (("ship", "ship"), ("model", "NMI-RLS")):
        track = series[f"turn_{who}_m"]
        circle.plot(track[:, 1], track[:, 0], label=label)
        for axes, name in zip(others, ("turn", "zigzag", "small"), strict=True):
            axes.plot(series[f"{name}_time_s"], series[f"{name}_{who}_deg_s"], label=label)
