"""Scores of submissions: naming, sizes, regimes, and the prediction of held-out records.

What an answer is right about is counted so that saying more than is known does not pay.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import exp, isnan, log, pi
from pathlib import Path
from statistics import fmean, median
from typing import Any

import numpy as np

from ..faults.effects.base import Effect
from ..faults.regimes import TrueRegime
from ..kinds.diagnosis.bases import EXACT, UNSTATED
from ..kinds.diagnosis.judge import (
    BASE,
    KNOWN,
    UNKNOWN,
    judge,
    judge_names,
    localisation,
    named,
    of_base,
    size_rows,
    stated_regimes,
)
from .folder import Exam
from .key import WorldKey, motion_of
from .motion import Motion, errors, predicted_or_none
from .submission import Read, StatedDiagnosis, extended_model, given_motion, read_submissions, stated
from .worlds import KINDS

ALONE = ("alone", "both", "adequate", "unexplained")
"""Outcomes in which what was named is right."""
WIDEST, HALF_TURN = 10.0, pi
"""An interval that is wider than so many true sizes, or half a turn of a direction, says nothing: it holds no size."""
LEVEL = 0.9
"""Probability with which a stated interval should hold the true size."""
LARGEST = 1e3
"""Most that a relative error counts."""
EVERYWHERE = TrueRegime("time", "above", -1.0)


@dataclass(frozen=True)
class EffectSizes:
    """The sizes that an answer states for one effect which it names rightly; None where there is nothing to compare.

    error : median relative error, 1 where no size is stated.  covered : share of the intervals that hold the true size.
    interval : median interval score over the true size (Gneiting & Raftery 2007, J. Am. Stat. Assoc. 102, eq 43).
    """

    error: float | None
    covered: float | None
    interval: float | None


def naming(said: StatedDiagnosis, key: WorldKey) -> dict[str, Any]:
    """The outcome, as the suites judge a diagnosis."""
    spec = key.case
    return judge_names(said, frozenset(key.right)) if key.right else judge(said, spec.group, spec.injected, spec.base)


def is_alone(judged: Mapping[str, Any], said: StatedDiagnosis, key: WorldKey) -> bool:
    """Whether what was named is right, nothing else was named, and no effect was named in two findings."""
    tied = judged["outcome"] == "both" and said.verdict == "tied"
    return judged["outcome"] in ALONE and not judged["false_names"] and not tied and not _repeats(said, key)


def points(judged: Mapping[str, Any], alone: bool, share: float | None) -> int:
    """1 for an answer that is right alone, -1 for one that names what is false and nothing right, else 0.

    A guess pays only where it is right in more than half of the cases.

    share : as `right_share` gives it.
    """
    if alone:
        return 1
    return -1 if judged["outcome"] == "false_alarm" or (judged["false_names"] and not share) else 0


def _repeats(said: StatedDiagnosis, key: WorldKey) -> bool:
    injected = set(key.case.injected)
    holding = [held for f in said.causes if (held := injected & {f.cause, *f.tied_with})]
    return not key.right and len(holding) > len(set().union(*holding))


def right_share(said: StatedDiagnosis, key: WorldKey) -> float | None:
    """Right names over the names that were stated or had to be (Jaccard index); None of a control.

    Names that would do as well count as the others, names of which each is right as one.  Beside a base model of which
    all numbers are off, names of its own numbers do not count.
    """
    spec = key.case
    if spec.group == "null":
        return None
    if not key.right and spec.group in UNKNOWN:
        return float(said.verdict == "unexplained")
    if key.right:
        stated, right = frozenset().union(*named(said)), frozenset(key.right)
        return float(bool(stated & right)) / (1 + len(stated - right))
    stated, right = frozenset(_names(said, spec.base)), frozenset(spec.injected)
    return len(stated & right) / len(stated | right | _own_names(said, spec.base))


def _names(said: StatedDiagnosis, base: str) -> Iterator[str]:
    """Names of causes that count."""
    imperfect = base not in (EXACT, UNSTATED)
    for finding in said.causes:
        for name in (finding.cause, *finding.tied_with):
            if name != BASE and not (imperfect and of_base(name, base)):
                yield name


def _own_names(said: StatedDiagnosis, base: str) -> frozenset[str]:
    """Groups of the base model's own numbers that are named, where they count."""
    if base not in (EXACT, UNSTATED):
        return frozenset()
    texts = (f.details.get(key) for f in said.causes for key in ("groups", "would do as well"))
    return frozenset(f"group:{name}" for some in texts if some for name in some)


def sizes(said: StatedDiagnosis, key: WorldKey) -> list[EffectSizes]:
    """Sizes of the effects that are named, each effect once."""
    if key.case.group not in KNOWN:
        return []
    rows = size_rows(said, key.injected, key.ship, key.train, list(key.held_out))
    held = {finding.cause for finding in said.causes}
    found = [_of_effect(e, [r for r in rows if r["cause"] == e.cause], key) for e in key.injected if e.cause in held]
    return [one for one in found if one is not None]


def _of_effect(effect: Effect, rows: Sequence[Mapping[str, Any]], key: WorldKey) -> EffectSizes | None:
    errors = [min(row["rel_error"], LARGEST) for row in rows if row["rel_error"] is not None]
    limits = [row for row in rows if not isnan(row["low"])]
    scores = [_interval_score(row) for row in limits if row["rel_error"] is not None]
    if not errors and set(effect.kind.truths(effect.at(0), key.ship, {})) - set(effect.kind.directions):
        errors = [1.0]
    if not errors and not limits:
        return None
    return EffectSizes(
        median(errors) if errors else None,
        fmean(_holds(row) for row in limits) if limits else None,
        median(scores) if scores else None,
    )


def _holds(row: Mapping[str, Any]) -> bool:
    widest = HALF_TURN if row["rel_error"] is None and row["true"] else WIDEST * abs(row["true"])
    return row["covered"] and (row["true"] == 0.0 or row["high"] - row["low"] <= widest)


def _interval_score(row: Mapping[str, Any]) -> float:
    outside = max(row["low"] - row["true"], row["true"] - row["high"], 0.0)
    return min((row["high"] - row["low"] + 2.0 / (1.0 - LEVEL) * outside) / abs(row["true"]), LARGEST)


def regime_skill(said: StatedDiagnosis, key: WorldKey) -> float | None:
    """F1 of the samples in the stated regimes, rescaled: 0 is that of "everywhere" and below, 1 the best.

    None where nothing acts in a regime.
    """
    if not key.regimes:
        return None
    true, runs = key.regimes, key.true_motion()
    found, everywhere = (localisation(true, some, runs) for some in (stated_regimes(said), [EVERYWHERE]))
    if found is None or everywhere is None or everywhere == 1.0:
        return found
    return max(0.0, (found - everywhere) / (1.0 - everywhere))


ALL = "all"
LEAST_RATIO, LARGEST_RATIO = 1e-3, 1e3
"""Between these the ratio of two errors counts."""


@dataclass(frozen=True)
class WorldScore:
    """Scores of one answer.

    outcome : see `kinds.diagnosis.judge.OUTCOMES`.  points, right_share, regime : see the functions of these names.
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
    control = key.case.group == "null"
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
