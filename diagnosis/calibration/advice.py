"""Which manoeuvre would tell most about the numbers that the records leave open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.generator import record_run
from ...datasets.manoeuvres import parse_manoeuvre
from ...estimation.diagnosis_only.mixed_effects.fit import normal_equations
from ...estimation.diagnosis_only.mixed_effects.problem import problem
from ...estimation.information.design import information_gain
from ...estimation.records.series import MEASURED
from ...models.model import CHANNELS
from .attempts import Selection, numbers_of, whole_and_parts
from .result import NextRun

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group
    from ...models.model import Model

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
DURATION = 20.0
"""Length of a candidate run, in ship lengths sailed."""
SHOWN = 3


def next_runs(extended: Model, whole: Model, found: Selection, groups: Sequence[Group]) -> tuple[NextRun, ...]:
    """The candidates that add most information (`estimation.information.design`) on the numbers that moved, and that
    were tied."""
    open_ids = {g.id for g in found.final.groups} | {tied for s in found.steps for tied in s.tied_with}
    p, fitted = found.final.fitted.problem, found.final.fitted
    numbers = numbers_of(p, [g for i, g in whole_and_parts(groups).items() if i in open_ids])
    scale = np.array([n.sd for n in numbers])
    now = normal_equations(p, numbers, fitted.theta, fitted.own, fitted.sd)[0] * np.outer(scale, scale)
    unmeasured = {CHANNELS[symbol]: None for symbol in MEASURED if symbol not in p.channels}
    out = []
    for text in CANDIDATES:
        record = record_run(extended, parse_manoeuvre(text), duration_s=DURATION * p.length_s, dt_s=0.03 * p.length_s)
        one = replace(problem(whole, [record.with_channels(**unmeasured)]), local=p.local)
        shared = [p.channels.index(c) for c in one.channels]
        still = np.zeros((1, one.own_sd.size))
        added = normal_equations(one, numbers, fitted.theta, still, fitted.sd[shared])[0] * np.outer(scale, scale)
        out.append(NextRun(text, information_gain(now, added - np.eye(len(numbers)))))
    return tuple(sorted(out, key=lambda run: -run.information)[:SHOWN])
