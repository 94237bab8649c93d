"""Paper 003's studies; Tables 4 to 6 also over what it does not print: the sines of the heading reference, the noise.

`vessels` has the vessels and their runs, `settings` what needs neither noise nor fit, `states` Table 4,
`identification` Tables 5 and 6, `proposed` the proposal as a whole with its bee colony, `robustness` the effect of
outliers.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from ..study import PaperStudy, StudyResult, settings_at
from . import identification, proposed, robustness, settings, states, vessels

SINES = {
    "cargo": {1: ((1.0, 0.0105),), 3: ((1.0, 0.0105), (0.6, 0.031), (0.4, 0.083))},
    "patrol": {1: ((1.0, 0.27),), 3: ((1.0, 0.12), (0.6, 0.5), (0.4, 1.6))},
}
"""Shares of the amplitude and frequencies, rad/s, before scaling."""


def _sines(vessel: str, chosen: dict[str, Any]) -> str:
    """The heading reference of a point, as manoeuvres write it."""
    parts = SINES[vessel][chosen["number of sines"]]
    amplitude, factor = chosen["amplitude"], chosen["frequency factor"]
    return "+".join(f"{share * amplitude:.6f}deg/{factor * omega:.9f}rad_s" for share, omega in parts)


def states_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Table 4, ESO: RMSE and R^2 of both forms of the observer at one point."""
    chosen = settings_at("003", f"states_{vessel}_searched", index)
    truth = vessels.motion(vessel, _sines(vessel, chosen), "euler")
    noise = chosen["heading noise"] * np.random.default_rng(index).normal(size=len(truth.psi))
    values: dict[str, float] = {}
    for variant in ("corrected", "as_printed"):
        seen = states.observed(variant, truth.psi + noise, truth, vessel)
        values |= states.scores(f"{variant}_eso", seen, truth, vessel)
    return StudyResult(values)


def motions_searched(rng: np.random.Generator, *, index: int) -> StudyResult:
    """What Tables 4 to 6 imply, on the noise-free motions of one point."""
    chosen = settings_at("003", "motions_searched", index)
    values: dict[str, float] = {}
    for vessel in vessels.VESSELS:
        values |= identification.of_motion(vessel, _sines(vessel, chosen))
    return StudyResult(values)


def identified_searched(vessel: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Tables 5 and 6: both methods, corrected and as printed, at one point; its noise belongs to the point."""
    chosen = settings_at("003", f"identified_{vessel}_searched", index)
    own = np.random.default_rng(index)
    found = identification.on_sines(vessel, _sines(vessel, chosen), chosen["heading noise"], own)
    return StudyResult(found.values)


STUDIES = {
    "settings": PaperStudy(settings.settings),
    "arithmetic": PaperStudy(identification.arithmetic),
    "noise_free": PaperStudy(identification.noise_free),
    "rule": PaperStudy(robustness.rule),
    "states_cargo": PaperStudy(partial(states.table_4, "cargo"), seeds=8),
    "states_patrol": PaperStudy(partial(states.table_4, "patrol"), seeds=20),
    "observers_cargo": PaperStudy(partial(states.observers, "cargo"), seeds=3),
    "observers_patrol": PaperStudy(partial(states.observers, "patrol"), seeds=8),
    "identified_cargo": PaperStudy(partial(identification.tables_5_and_6, "cargo"), seeds=20),
    "identified_patrol": PaperStudy(partial(identification.tables_5_and_6, "patrol"), seeds=40),
    "states_cargo_searched": PaperStudy(partial(states_searched, "cargo"), seeds=24),
    "states_patrol_searched": PaperStudy(partial(states_searched, "patrol"), seeds=32),
    "motions_searched": PaperStudy(motions_searched, seeds=32),
    "identified_cargo_searched": PaperStudy(partial(identified_searched, "cargo"), seeds=12),
    "identified_patrol_searched": PaperStudy(partial(identified_searched, "patrol"), seeds=24),
    "crossover_cargo": PaperStudy(partial(states.crossover, "cargo")),
    "crossover_patrol": PaperStudy(partial(states.crossover, "patrol")),
    "aligned": PaperStudy(identification.aligned, seeds=5),
    "sensitivity": PaperStudy(robustness.sensitivity, seeds=20),
    "outliers": PaperStudy(robustness.outliers, seeds=150),
    "efficiency": PaperStudy(robustness.efficiency, seeds=12),
    "proposed": PaperStudy(proposed.proposed, seeds=3, drawn=3),
}
