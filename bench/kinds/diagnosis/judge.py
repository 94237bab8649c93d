"""Scores of one diagnosis against what was planted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite, pi
from typing import TYPE_CHECKING, Any

from .columns import CHANNELS

if TYPE_CHECKING:
    from ....diagnosis.result import Diagnosis, Finding, Size
    from ...faults.case import Planted
    from ...faults.effects import Effect
    from ...faults.ships import Ship

OUTCOMES = {
    "alone": "the first finding is the planted cause, by itself",
    "tie": "the first finding holds the planted cause beside others",
    "wrong_lead": "the first finding does not hold the planted cause",
    "missed": "nothing was found where something is planted",
    "both": "of two causes each is named in a tie of its own",
    "one": "of two causes one is named, or both in the same tie",
    "unexplained": "an effect outside the taxonomy was reported as unexplained",
    "named": "an effect outside the taxonomy was given a name of the bank",
    "adequate": "nothing is planted and nothing was found",
    "false_alarm": "nothing is planted and something was found",
}
KNOWN, UNKNOWN = ("planted", "pair"), ("anticipated", "unforeseen")
POWER, LEVEL = 0.99, 0.001
"""An effect is detectable where the best test of this level has this power."""
CIRCULAR = ("towards", "from")
"""Parameters that are directions."""


def judge(diagnosis: Diagnosis, group: str, planted: Sequence[str]) -> dict[str, Any]:
    """The scored columns of one case: verdict, what was named, outcome, false alarm, wrong name, size of the tie."""
    findings = [frozenset((f.cause, *f.tied_with)) for f in diagnosis.causes]
    holding = [found for found in findings if found & set(planted)]
    outcome = _outcome(diagnosis, group, planted, findings)
    confident = diagnosis.verdict in ("named", "tied")
    return {
        "verdict": diagnosis.verdict,
        "named": "+".join("/".join((f.cause, *sorted(f.tied_with))) for f in diagnosis.causes),
        "outcome": outcome,
        "false_alarm": outcome == "false_alarm" if group == "null" else None,
        "confident_wrong": confident and any(len(found) == 1 and not found & set(planted) for found in findings),
        "tie_size": max(map(len, holding)) if holding else None,
    }


def _outcome(diagnosis: Diagnosis, group: str, planted: Sequence[str], findings: Sequence[frozenset[str]]) -> str:
    unexplained = diagnosis.verdict == "unexplained"
    if group == "null":
        return "false_alarm" if findings or unexplained else "adequate"
    if group in UNKNOWN:
        return "unexplained" if unexplained else "named" if findings else "missed"
    if not findings:
        return "missed"
    if len(planted) == 1:
        held = planted[0] in findings[0]
        return "wrong_lead" if not held else "alone" if len(findings[0]) == 1 else "tie"
    if _apart(planted, findings):
        return "both"
    return "one" if any(found & set(planted) for found in findings) else "wrong_lead"


def _apart(planted: Sequence[str], findings: Sequence[frozenset[str]]) -> bool:
    """Whether two causes are in two findings, one each."""
    first, second = ([i for i, found in enumerate(findings) if cause in found] for cause in planted)
    return any(i != j for i in first for j in second)


def gain(diagnosis: Diagnosis) -> dict[str, float]:
    """Free-run errors on the held-out records before and after, by channel."""
    return {
        f"rmse_{when}_{channel}": float(getattr(found, f"rmse_{when}"))
        for channel, found in diagnosis.gain.items()
        if channel in CHANNELS
        for when in ("before", "after")
    }


def detectable(planted: Planted) -> bool:
    """Whether the best test at level .001 would find the effects with power .99.

    Its degrees of freedom are the numbers that are planted in the training records; what has no size is gross.
    """
    from scipy.stats import chi2, ncx2

    if not isfinite(planted.noncentrality):
        return True
    count = max(1, sum(_numbers(effect, len(planted.train)) for effect in planted.effects))
    return bool(ncx2.sf(chi2.isf(LEVEL, count), count, planted.noncentrality) >= POWER)


def _numbers(effect: Effect, train: int) -> int:
    """How many numbers of an effect act on the training records."""
    values = [v for k, v in effect.parameters.items() if k not in ("row", "channels") and not isinstance(v, str)]
    return sum(min(len(v), train) if isinstance(v, tuple) else 1 for v in values)


def size_rows(diagnosis: Diagnosis, planted: Planted) -> list[dict[str, Any]]:
    """Stated sizes of rightly named causes against the planted ones."""
    names = {record.name: i for i, record in enumerate((*planted.train, *planted.held_out))}
    rows = []
    for finding in diagnosis.causes:
        for effect in planted.effects:
            if effect.cause == finding.cause:
                rows += _rows_of(finding, effect, planted.case.ship, names)
    return rows


def _rows_of(finding: Finding, effect: Effect, ship: Ship, records: Mapping[str, int]) -> list[dict[str, Any]]:
    rows = []
    for size in finding.sizes:
        truth = truths(effect, ship, finding, records.get(size.record or "", 0)).get(size.parameter)
        if truth is not None:
            rows.append({"cause": finding.cause} | compare(size, truth))
    return rows


def compare(size: Size, truth: float) -> dict[str, Any]:
    """One stated size against the truth; directions on the circle."""
    error, covered = abs(size.value - truth), size.low <= truth <= size.high
    if size.parameter in CIRCULAR:
        error = abs(wrapped(size.value - truth))
        covered = any(size.low <= truth + turn <= size.high for turn in (-4 * pi, -2 * pi, 0.0, 2 * pi, 4 * pi))
    return {
        "parameter": size.parameter,
        "record": size.record or "",
        "unit": size.unit,
        "true": truth,
        "estimate": size.value,
        "low": size.low,
        "high": size.high,
        "covered": bool(covered),
        "rel_error": None if size.parameter in CIRCULAR or truth == 0.0 else error / abs(truth),
    }


def wrapped(angle: float) -> float:
    """An angle in -pi .. pi."""
    return (angle + pi) % (2.0 * pi) - pi


def truths(effect: Effect, ship: Ship, finding: Finding, record: int) -> dict[str, float]:
    """Planted sizes in one record under the names by which a finding states them.

    Most have the same name on both sides; what a diagnosis may state in other terms is added.
    """
    p = effect.at(record)
    found = {k: float(v) for k, v in p.items() if isinstance(v, int | float)}
    if effect.cause == "shallow_water":
        found["draught_over_depth"] = 1.0 / p["depth_ratio"]
    elif effect.cause == "second_order_lead":
        found["lead"] = 1.0 - p["T3"] / p["T2"] if p["T2"] else inf
    elif effect.cause == "speed_loss":
        found["loss_gain"] = p["drop"] * (ship.length_m / ship.speed_m_s) ** 2
    elif effect.cause == "coefficient_shift":
        same = finding.details.get("coefficient", p["name"]) == p["name"]
        found = {f"fraction:{p['name']}": p["fraction"]} | ({"fraction": p["fraction"]} if same else {})
    return found
