"""What an answer is right about: names, sizes and regimes, counted so that saying more than is known does not pay."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isnan, pi
from statistics import fmean, median
from typing import Any

from ..faults.effects.base import Effect
from ..faults.regimes import TrueRegime
from ..kinds.diagnosis.bases import EXACT, UNSTATED
from ..kinds.diagnosis.judge import KNOWN, UNKNOWN, judge, judge_names, of_base, size_rows
from ..kinds.diagnosis.localisation import localisation, stated_regimes
from ..kinds.diagnosis.names import BASE, named
from .key import WorldKey
from .submission import StatedDiagnosis

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
    spec = key.spec
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
    injected = set(key.spec.injected)
    holding = [held for f in said.causes if (held := injected & {f.cause, *f.tied_with})]
    return not key.right and len(holding) > len(set().union(*holding))


def right_share(said: StatedDiagnosis, key: WorldKey) -> float | None:
    """Right names over the names that were stated or had to be (Jaccard index); None of a control.

    Names that would do as well count as the others, names of which each is right as one.  Beside a base model of which
    all numbers are off, names of its own numbers do not count.
    """
    spec = key.spec
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
    if key.spec.group not in KNOWN:
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
    true, runs = key.true_regimes(), key.true_motion()
    found, everywhere = (localisation(true, some, runs) for some in (stated_regimes(said), [EVERYWHERE]))
    if found is None or everywhere is None or everywhere == 1.0:
        return found
    return max(0.0, (found - everywhere) / (1.0 - everywhere))
