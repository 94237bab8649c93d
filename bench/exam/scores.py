"""Scores of submissions: naming, sizes, regimes, and the prediction of held-out records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from pathlib import Path
from statistics import fmean, median

import numpy as np

from .folder import Exam
from .judging import EffectSizes, is_alone, naming, points, regime_skill, right_share, sizes
from .key import WorldKey, motion_of
from .motion import Motion, errors, predicted_or_none
from .submission import Read, extended_model, given_motion, read_submissions, stated
from .worlds import KINDS

ALL = "all"
LEAST_RATIO, LARGEST_RATIO = 1e-3, 1e3
"""Between these the ratio of two errors counts."""


@dataclass(frozen=True)
class WorldScore:
    """Scores of one answer.

    outcome : see `kinds.diagnosis.judge.OUTCOMES`.  points, right_share, regime : see `judging.points` and so on.
    alone : what is wrong was named and nothing else, or rightly nothing; false_alarm : of a control, else None.
    sizes : of the effects that are named.
    predicted : whether the motion of every held-out record is given in every channel that counts.
    to_base, to_best : error of the predicted motion over that of the base model, and of the true ship; the geometric
    mean over the channels.
    """

    entrant: str
    world: str
    kind: str
    outcome: str
    named: str
    points: int
    alone: bool
    right_share: float | None
    false_alarm: bool | None
    sizes: tuple[EffectSizes, ...]
    regime: float | None
    predicted: bool
    to_base: float
    to_best: float


@dataclass(frozen=True)
class EntrantScore:
    """Scores of an entrant over the worlds of a kind, or over all.

    points : mean over the worlds.  alone : share of the worlds; right_share : mean over those in which something is
    wrong; false_alarms : share of controls.
    sizes : number of effects with sizes; wrong_size : median of their relative errors; coverage : mean share of the
    stated intervals that hold the true size; interval : median interval score.  regime : mean.
    predicted : share of the worlds; to_base, to_best : geometric means.  None where there is nothing to score.
    """

    entrant: str
    kind: str
    worlds: int
    points: float
    alone: float
    right_share: float | None
    false_alarms: float | None
    sizes: int
    wrong_size: float | None
    coverage: float | None
    interval: float | None
    regime: float | None
    predicted: float
    to_base: float
    to_best: float


def score(folder: Path, key: Path, submissions: Sequence[Path]) -> tuple[list[EntrantScore], list[WorldScore]]:
    """Scores of submissions by kind of world and over all, and of every answer.

    Raises
    ------
    BadInput : the exam was changed, the key is of another exam or lies in its folder, a submission cannot be used, or
        two have the same entrant.
    """
    exam = Exam(folder)
    answers = exam.key(key)
    exam.check()
    rows: list[WorldScore] = []
    for read in read_submissions(submissions, exam):
        rows += [score_world(exam, world, own, read) for world, own in answers.worlds.items()]
    return summary(rows), rows


def score_world(exam: Exam, world: str, key: WorldKey, read: Read) -> WorldScore:
    """Scores of one answer."""
    said = stated(read.answer(world), exam.model(world))
    judged = naming(said, key)
    alone, share = is_alone(judged, said, key), right_share(said, key)
    found = _errors(exam, world, key, read)
    errors = key.rmse_base | found
    control = key.spec.group == "null"
    return WorldScore(
        read.content.entrant,
        world,
        key.kind,
        judged["outcome"],
        judged["named"],
        points(judged, alone, share),
        alone,
        share,
        judged["outcome"] == "false_alarm" if control else None,
        tuple(sizes(said, key)),
        regime_skill(said, key),
        set(found) == set(key.rmse_base),
        _mean_ratio(errors, key.rmse_base),
        _mean_ratio(errors, key.rmse_best),
    )


def _errors(exam: Exam, world: str, key: WorldKey, read: Read) -> dict[str, float]:
    """Errors of the predicted motion of the channels that are given in every held-out record; of the others the base
    model's count."""
    measured = {name: motion_of(kept.measured) for name, kept in key.held_out.items()}
    starts = {name: kept.start for name, kept in key.held_out.items()}
    handed_out = exam.records(world, exam.worlds[world].held_out)
    runs: dict[str, Motion] = given_motion(read, world, handed_out, starts)
    model = extended_model(read, world)
    if model is not None:
        runs = predicted_or_none(model, handed_out) | runs
    return {c: x for c, x in errors(measured, runs, starts).items() if c in key.rmse_base}


def _mean_ratio(found: Mapping[str, float], reference: Mapping[str, float]) -> float:
    """Geometric mean over the channels of the ratio of errors."""
    return _geometric(found[c] / reference[c] if reference[c] else LARGEST_RATIO for c in reference)


def _geometric(ratios: Iterable[float]) -> float:
    return exp(fmean(log(float(np.clip(one, LEAST_RATIO, LARGEST_RATIO))) for one in ratios))


def summary(rows: Sequence[WorldScore]) -> list[EntrantScore]:
    """Scores of every entrant, over all worlds and by kind."""
    found = []
    for entrant in dict.fromkeys(row.entrant for row in rows):
        own = [row for row in rows if row.entrant == entrant]
        kinds = [ALL, *sorted({row.kind for row in own}, key=lambda k: (KINDS.index(k) if k in KINDS else 99, k))]
        found += [
            _summed(entrant, kind, own if kind == ALL else [row for row in own if row.kind == kind]) for kind in kinds
        ]
    return found


def _summed(entrant: str, kind: str, rows: Sequence[WorldScore]) -> EntrantScore:
    effects = [one for row in rows for one in row.sizes]
    wrong, intervals = ([x for e in effects if (x := getattr(e, name)) is not None] for name in ("error", "interval"))
    return EntrantScore(
        entrant,
        kind,
        len(rows),
        fmean(row.points for row in rows),
        fmean(row.alone for row in rows),
        _share([row.right_share for row in rows]),
        _share([row.false_alarm for row in rows]),
        len(effects),
        median(wrong) if wrong else None,
        _share([one.covered for one in effects]),
        median(intervals) if intervals else None,
        _share([row.regime for row in rows]),
        fmean(row.predicted for row in rows),
        _geometric(row.to_base for row in rows),
        _geometric(row.to_best for row in rows),
    )


def _share(values: Sequence[float | bool | None]) -> float | None:
    """Mean of the values that there are."""
    known = [float(one) for one in values if one is not None]
    return fmean(known) if known else None
