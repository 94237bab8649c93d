"""Which manoeuvre would tell most about the numbers that the records leave open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.generator import record_run
from ...datasets.manoeuvres import parse_manoeuvre
from ...estimation.information.design import information_gain
from ...estimation.records.series import MEASURED
from ...estimation.selection.number import distinct
from ...models.model import CHANNELS
from ..free_runs.bank import numbers_of
from ..free_runs.units import whole_unit
from .group_fits import GroupSteps, whole_and_parts
from .result import NextRun

if TYPE_CHECKING:
    from ...estimation.selection.minimiser import Point
    from ...estimation.selection.number import Number
    from ...models.coefficient_groups import Group
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns

CANDIDATES = {
    "zigzag:10/10": "a 10/10 zigzag",
    "zigzag:20/20": "a 20/20 zigzag",
    "zigzag:35/5": "a 35/5 zigzag",
    "turn:20": "a turning circle with 20 deg of rudder to starboard",
    "turn:35": "a turning circle with 35 deg of rudder to starboard",
    "turn:35:port": "a turning circle with 35 deg of rudder to port",
    "straight": "a straight run",
}
"""Manoeuvres that are compared, and their words."""
DURATION, STEP = 20.0, 0.03
"""Length and step of a candidate run, in ship lengths sailed."""
SHOWN = 3


def next_runs(extended: Model, runs: FreeRuns, selection: GroupSteps, groups: Sequence[Group]) -> tuple[NextRun, ...]:
    """The candidates that add most information (`estimation.information.design`) on the numbers that moved, and that
    were tied.

    extended : makes the candidates.  runs : of the training records.
    """
    open_ids = {g.id for g in selection.final.groups} | {tied for s in selection.steps for tied in s.tied_with}
    chosen = [g for i, g in whole_and_parts(groups).items() if i in open_ids]
    numbers, point = distinct(n for g in chosen for n in numbers_of(g, runs.bank.values)), selection.final.fitted.point
    now = _information(runs, point, point.own, numbers) + np.eye(len(numbers))
    unmeasured = {CHANNELS[symbol]: None for symbol in MEASURED if symbol not in runs.symbols}
    out = []
    for text in CANDIDATES:
        duration_s, dt_s = DURATION * runs.length_s, STEP * runs.length_s
        record = record_run(extended, parse_manoeuvre(text), duration_s=duration_s, dt_s=dt_s)
        record = record.with_channels(**unmeasured)
        one = runs.along([whole_unit(runs.bank.model, record, runs.length_s)])
        out.append(NextRun(text, information_gain(now, _information(one, point, one.no_own, numbers))))
    return tuple(sorted(out, key=lambda run: -run.information)[:SHOWN])


def _information(runs: FreeRuns, point: Point, own: np.ndarray, numbers: Sequence[Number]) -> np.ndarray:
    """Information (p, p) on numbers in units of their prior standard deviations, at the error sizes of a point."""
    size = point.size[: len(runs.channels)]
    normal = runs.quadratic(point.values, own, numbers).normal(size)
    scale = np.array([n.sd for n in numbers])
    return normal.matrix.sum(axis=0) * np.outer(scale, scale)
