"""Tables 4 to 6 over what paper 003 does not print: the sines of the heading reference and the noise."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...claims.files import load
from ..study import StudyResult, point
from . import identification, states, vessels

SINES = {
    "cargo": {1: ((1.0, 0.0105),), 3: ((1.0, 0.0105), (0.6, 0.031), (0.4, 0.083))},
    "patrol": {1: ((1.0, 0.27),), 3: ((1.0, 0.12), (0.6, 0.5), (0.4, 1.6))},
}
"""Shares of the amplitude and frequencies, rad/s, before scaling."""


def _chosen(study: str, index: int) -> dict[str, Any]:
    return point(load("003").search(study), index)


def _sines(vessel: str, chosen: dict[str, Any]) -> str:
    """The heading reference of a point, as manoeuvres write it."""
    parts = SINES[vessel][chosen["number of sines"]]
    amplitude, factor = chosen["amplitude"], chosen["frequency factor"]
    return "+".join(f"{share * amplitude:.6f}deg/{factor * omega:.9f}rad_s" for share, omega in parts)


def states_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Table 4, ESO: RMSE and R^2 of both forms of the observer at one point."""
    chosen = _chosen(f"states_{vessel}_searched", index)
    truth = vessels.motion(vessel, _sines(vessel, chosen), "euler")
    noise = chosen["heading noise"] * np.random.default_rng(index).normal(size=len(truth.psi))
    values: dict[str, float] = {}
    for variant in ("corrected", "as_printed"):
        seen = states.observed(variant, truth.psi + noise, truth, vessel)
        values |= states.scores(f"{variant}_eso", seen, truth, vessel)
    return StudyResult(values)


def motions_searched(rng: np.random.Generator, *, index: int) -> StudyResult:
    """What Tables 4 to 6 imply, on the noise-free motions of one point."""
    chosen = _chosen("motions_searched", index)
    values: dict[str, float] = {}
    for vessel in vessels.VESSELS:
        values |= identification.of_motion(vessel, _sines(vessel, chosen))
    return StudyResult(values)


def identified_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Tables 5 and 6: both methods, corrected and as printed, at one point; its noise belongs to the point."""
    chosen = _chosen(f"identified_{vessel}_searched", index)
    own = np.random.default_rng(index)
    found = identification.on_sines(vessel, _sines(vessel, chosen), chosen["heading noise"], own)
    return StudyResult(found.values)
