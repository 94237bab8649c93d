"""Paper 003: extended state observer, then robust weighted LS-SVR, on a cargo and a patrol vessel.

`vessels` has the vessels and their runs, `settings` what needs neither noise nor fit, `states` Table 4,
`identification` Tables 5 and 6, `proposed` the proposal as a whole with its bee colony, `robustness` the effect of
outliers, `figures` the figures.
"""

from __future__ import annotations

from functools import partial

from ..study import Study, StudyResult
from . import identification, proposed, robustness, search, settings, states
from .figures import (
    draw_convergence,
    draw_errors_cargo,
    draw_errors_patrol,
    draw_outliers,
    draw_prediction,
    draw_states,
)

__all__ = [
    "draw_convergence",
    "draw_errors_cargo",
    "draw_errors_patrol",
    "draw_outliers",
    "draw_prediction",
    "draw_states",
]


def _of(function, vessel: str):
    """A function of (vessel, rng) as a study's function."""
    return partial(_run, function, vessel)


def _run(function, vessel: str, rng, *, index: int) -> StudyResult:
    return function(vessel, rng)


STUDIES = {
    "settings": Study(settings.settings),
    "arithmetic": Study(identification.arithmetic),
    "noise_free": Study(identification.noise_free),
    "rule": Study(robustness.rule),
    "states_cargo": Study(_of(states.table_4, "cargo"), seeds=8),
    "states_patrol": Study(_of(states.table_4, "patrol"), seeds=20),
    "observers_cargo": Study(_of(states.observers, "cargo"), seeds=3),
    "observers_patrol": Study(_of(states.observers, "patrol"), seeds=8),
    "identified_cargo": Study(partial(identification.tables_5_and_6, "cargo"), seeds=20),
    "identified_patrol": Study(partial(identification.tables_5_and_6, "patrol"), seeds=40),
    "states_cargo_searched": Study(partial(search.states_searched, "cargo"), seeds=24),
    "states_patrol_searched": Study(partial(search.states_searched, "patrol"), seeds=32),
    "motions_searched": Study(search.motions_searched, seeds=32),
    "identified_cargo_searched": Study(partial(search.identified_searched, "cargo"), seeds=12),
    "identified_patrol_searched": Study(partial(search.identified_searched, "patrol"), seeds=24),
    "crossover_cargo": Study(_of(states.crossover, "cargo")),
    "crossover_patrol": Study(_of(states.crossover, "patrol")),
    "aligned": Study(identification.aligned, seeds=5),
    "sensitivity": Study(robustness.sensitivity, seeds=20),
    "outliers": Study(robustness.outliers, seeds=150),
    "efficiency": Study(robustness.efficiency, seeds=12),
    "proposed": Study(proposed.proposed, seeds=3, drawn=3),
}
