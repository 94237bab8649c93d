"""Scores of submissions: naming, sizes, regimes, and the prediction of held-out records."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, isnan, log
from pathlib import Path
from statistics import fmean, median
from typing import Any

import numpy as np

from ..kinds.diagnosis.judge import KNOWN, judge, judge_names, size_rows
from ..kinds.diagnosis.localisation import localisation, stated_regimes
from .folder import Exam
from .key_file import WorldKey, motion_of
from .motion import Motion, errors, predicted_or_none
from .submission import Read, Stated, extended_model, given_motion, read_submission, stated
from .worlds import KINDS

ALL = "all"
ALONE = ("alone", "both", "adequate", "unexplained")
"""Outcomes in which what was named is right."""
LEAST_RATIO, LARGEST_RATIO = 1e-3, 1e3
"""Between these the ratio of two errors counts."""


@dataclass(frozen=True)
class WorldScore:
    """Scores of one answer.

    outcome : see `kinds.diagnosis.judge.OUTCOMES`.  alone : what is wrong was named and nothing else, or rightly
    nothing; among : it is in what was named; false_alarm : of a control, else None.
    sizes : relative errors of the sizes, covered : whether their intervals hold the true ones.
    f1 : of the samples in the regime, None where there is none.
    to_base, to_best : error of the predicted motion over that of the base model, and of the true ship; the geometric
    mean over the channels.
    """

    entrant: str
    world: str
    kind: str
    outcome: str
    named: str
    alone: bool
    among: bool | None
    false_alarm: bool | None
    sizes: tuple[float, ...]
    covered: tuple[bool, ...]
    f1: float | None
    to_base: float
    to_best: float


@dataclass(frozen=True)
class Score:
    """Scores of an entrant over the worlds of a kind, or over all.

    alone, among : shares of the worlds, among of those in which something is wrong; false_alarms : share of controls.
    wrong_size : median relative error of the sizes; coverage : share of the stated intervals that hold the true size.
    f1 : mean.  to_base, to_best : geometric means.  None where there is nothing to score.
    """

    entrant: str
    kind: str
    worlds: int
    alone: float
    among: float | None
    false_alarms: float | None
    sizes: int
    wrong_size: float | None
    coverage: float | None
    f1: float | None
    to_base: float
    to_best: float


def score(folder: Path, key: Path, submissions: Sequence[Path]) -> tuple[list[Score], list[WorldScore]]:
    """Scores of submissions by kind of world and over all, and of every answer.

    Raises
    ------
    BadInput : the exam was changed, the key is of another exam, or a submission cannot be used.
    """
    exam = Exam(folder)
    answers = exam.key(key)
    exam.check()
    rows: list[WorldScore] = []
    for read in [read_submission(path, exam) for path in submissions]:
        rows += [score_world(exam, world, own, read) for world, own in answers.worlds.items()]
    return summary(rows), rows


def score_world(exam: Exam, world: str, key: WorldKey, read: Read) -> WorldScore:
    """Scores of one answer."""
    said = stated(read.answer(world), exam.model(world))
    judged = naming(said, key)
    sizes = _sizes(said, key)
    to_base, to_best = _ratios(exam, world, key, read)
    control = key.spec.group == "null"
    return WorldScore(
        read.content.entrant,
        world,
        key.kind,
        judged["outcome"],
        judged["named"],
        _alone(judged, said),
        None if control else judged["tie_size"] is not None and judged["outcome"] != "one",
        judged["outcome"] == "false_alarm" if control else None,
        tuple(row["rel_error"] for row in sizes if row["rel_error"] is not None),
        tuple(row["covered"] for row in sizes if not isnan(row["low"])),
        localisation(key.true_regimes(), stated_regimes(said), key.true_motion()) if key.regimes else None,
        to_base,
        to_best,
    )


def naming(said: Stated, key: WorldKey) -> dict[str, Any]:
    """The outcome, as the suites judge a diagnosis."""
    spec = key.spec
    return judge_names(said, frozenset(key.right)) if key.right else judge(said, spec.group, spec.injected, spec.base)


def _alone(judged: Mapping[str, Any], said: Stated) -> bool:
    """Whether what was named is right and nothing else was named."""
    return judged["outcome"] in ALONE and not judged["extra_names"] and not (
        judged["outcome"] == "both" and said.verdict == "tied"
    )  # fmt: skip


def _sizes(said: Stated, key: WorldKey) -> list[dict[str, Any]]:
    if key.spec.group not in KNOWN:
        return []
    return size_rows(said, key.injected, key.ship, key.train, list(key.held_out))


def _ratios(exam: Exam, world: str, key: WorldKey, read: Read) -> tuple[float, float]:
    """Error of the predicted motion over the base model's and the true ship's; where nothing is predicted, the base
    model's error counts."""
    measured = {name: motion_of(kept.measured) for name, kept in key.held_out.items()}
    starts = {name: kept.start for name, kept in key.held_out.items()}
    handed_out = exam.records(world, exam.worlds[world].held_out)
    runs: dict[str, Motion] = given_motion(read, world, handed_out, starts)
    model = extended_model(read, world)
    if model is not None:
        runs = predicted_or_none(model, handed_out) | runs
    found = key.rmse_base | {c: x for c, x in errors(measured, runs, starts).items() if c in key.rmse_base}
    return _mean_ratio(found, key.rmse_base), _mean_ratio(found, key.rmse_best)


def _mean_ratio(found: Mapping[str, float], reference: Mapping[str, float]) -> float:
    """Geometric mean over the channels of the ratio of errors."""
    return _geometric(found[c] / reference[c] if reference[c] else LARGEST_RATIO for c in reference)


def _geometric(ratios: Iterable[float]) -> float:
    return exp(fmean(log(float(np.clip(one, LEAST_RATIO, LARGEST_RATIO))) for one in ratios))


def summary(rows: Sequence[WorldScore]) -> list[Score]:
    """Scores of every entrant, over all worlds and by kind."""
    found = []
    for entrant in dict.fromkeys(row.entrant for row in rows):
        own = [row for row in rows if row.entrant == entrant]
        kinds = [ALL, *sorted({row.kind for row in own}, key=lambda k: (KINDS.index(k) if k in KINDS else 99, k))]
        found += [
            _summed(entrant, kind, own if kind == ALL else [row for row in own if row.kind == kind]) for kind in kinds
        ]
    return found


def _summed(entrant: str, kind: str, rows: Sequence[WorldScore]) -> Score:
    sizes, covered = ([x for row in rows for x in getattr(row, name)] for name in ("sizes", "covered"))
    return Score(
        entrant,
        kind,
        len(rows),
        fmean(row.alone for row in rows),
        _share([row.among for row in rows]),
        _share([row.false_alarm for row in rows]),
        len(sizes),
        median(sizes) if sizes else None,
        _share(covered),
        _share([row.f1 for row in rows]),
        _geometric(row.to_base for row in rows),
        _geometric(row.to_best for row in rows),
    )


def _share(values: Sequence[float | bool | None]) -> float | None:
    """Mean of the values that there are."""
    known = [float(one) for one in values if one is not None]
    return fmean(known) if known else None
