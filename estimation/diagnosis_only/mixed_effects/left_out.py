"""Records predicted by fits to the others, and scores of such predictions with their standard errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from ....models.linear_algebra import lstsq
from ...numerics.threads import in_threads
from .expansion import Expansion
from .fit import LONGEST, Fitted, Number, equations, moved
from .problem import Problem, Squares, pooled, squares

SIZES = 4
"""Times that the error sizes are worked out anew for a predicted fit."""


@dataclass(frozen=True)
class LeftOut:
    """One record predicted by a fit to the others: the free numbers' values (p,), squared errors with the record's own
    effects estimated and with none, and half the penalty of the own effects."""

    values: np.ndarray
    adapted: Squares
    free: Squares
    penalty: float


def leave_one_out(found: Fitted) -> tuple[LeftOut, ...]:
    """Each record predicted by a fit to the others: its normal equations subtracted and one step taken.

    Eq. 6 of docs/mathematics/calibration.md.
    """
    p = found.problem
    return tuple(in_threads(p.threads, partial(_left_out, found), range(len(p.runs))))


def _left_out(found: Fitted, i: int) -> LeftOut:
    p, (matrix, slope, follow) = found.problem, found.blocks[i]
    theta, step = found.theta, np.zeros(len(found.numbers))
    if found.numbers:
        prior_sd = np.array([n.sd for n in found.numbers])
        step = _bounded(np.linalg.solve(found.normal - matrix, found.slope - slope), prior_sd)
        theta = moved(theta, found.numbers, step)
    own = found.own[i] + follow[:, -1] - follow[:, :-1] @ step
    penalty = 0.5 * float(np.sum((own / p.own_sd) ** 2))
    adapted, free = squares(p, theta, p.runs[i], own), squares(p, theta, p.runs[i])
    return LeftOut(theta[[n.place for n in found.numbers]], adapted, free, penalty)


def predicted(
    found: Fitted, expansions: Sequence[Expansion], numbers: Sequence[Number], pick: np.ndarray
) -> tuple[LeftOut, ...]:
    """Each record as a fit of some numbers to the others would leave it, to second order: no run is made.

    Eq. 6 of docs/mathematics/calibration.md.

    expansions : of all records in `numbers`, made at the fit `found`.  pick (p,) : places of the chosen ones.
    """
    p, own = found.problem, [e.of(pick) for e in expansions]
    chosen, sd = [numbers[j] for j in pick], found.sd
    prior_sd = np.array([n.sd for n in chosen])
    for _ in range(SIZES):
        normal, slope, blocks = equations(p, own, chosen, found.theta, sd)
        step = _bounded(lstsq(normal, slope), prior_sd)
        errors = pooled([e.squares(step, e.adapted(step, b[2])) for e, b in zip(own, blocks, strict=True)])
        sd = np.where(p.known, p.floor, np.sqrt(errors**2 + p.floor**2))
    normal, slope, blocks = equations(p, own, chosen, found.theta, sd)
    out = []
    for e, (matrix, pull, follow) in zip(own, blocks, strict=True):
        step = _bounded(lstsq(normal - matrix, slope - pull), prior_sd)
        effects = e.adapted(step, follow)
        penalty = 0.5 * float(np.sum((effects / p.own_sd) ** 2))
        values = found.theta[[n.place for n in chosen]] + step
        out.append(LeftOut(values, e.squares(step, effects), e.squares(step, np.zeros(effects.size)), penalty))
    return tuple(out)


def _bounded(step: np.ndarray, prior_sd: np.ndarray) -> np.ndarray:
    """A step (p,), shortened to LONGEST prior standard deviations."""
    return step * min(1.0, LONGEST / max(float(np.max(np.abs(step) / prior_sd, initial=0.0)), 1e-9))


class Fall(NamedTuple):
    """By how much the score of left-out records falls, and its jackknife standard error over records; the same of the
    part that plain free runs have in it."""

    gain: float
    error: float
    free_gain: float
    free_error: float


def scores(p: Problem, parts: Sequence[LeftOut], kept: Sequence[int]) -> np.ndarray:
    """(2,) log scores of some records, halved: with their own effects (penalised), and of plain free runs; lower is
    better.

    Eq. 7 of docs/mathematics/calibration.md.
    """
    floor = p.floor**2
    adapted = pooled([parts[i].adapted for i in kept]) ** 2
    free = pooled([parts[i].free for i in kept]) ** 2
    penalty = sum(parts[i].penalty for i in kept) / float(p.weight[list(kept)].sum())
    known = np.isfinite(adapted)
    own, plain = (float(np.sum(np.log(square + floor)[known])) for square in (adapted, free))
    return np.array([0.25 * own + 0.5 * penalty, 0.25 * plain])


def jackknife(values: np.ndarray) -> np.ndarray:
    """Jackknife standard error (...,) of a statistic from its values (R, ...) with one record left out each.

    Eq. 8 of docs/mathematics/calibration.md.
    """
    n = len(values)
    return np.sqrt((n - 1.0) / n * np.sum((values - values.mean(axis=0)) ** 2, axis=0))


def score_difference(p: Problem, old: Sequence[LeftOut], new: Sequence[LeftOut]) -> Fall:
    """By how much the mean of both scores falls from old to new (eq. 8 of docs/mathematics/calibration.md)."""
    everyone = range(len(old))

    def both(kept: Sequence[int]) -> tuple[float, float]:
        own, plain = (scores(p, old, kept) - scores(p, new, kept)).tolist()
        return own + plain, plain

    gain, free_gain = both(everyone)
    if len(old) == 1:
        return Fall(gain, np.inf, free_gain, np.inf)
    error, free_error = jackknife(np.array([both([j for j in everyone if j != i]) for i in everyone])).tolist()
    return Fall(gain, error, free_gain, free_error)
