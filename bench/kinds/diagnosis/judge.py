"""Scores of one diagnosis against the injected effects: what it names, sizes, gain, and where an effect acts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, pi
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ....checks.result import Size
from ....checks.sensors import HeadingDrift
from ....datasets.record import Record
from ....diagnosis.causes.registry import all_causes
from ....diagnosis.result import Diagnosis, Finding
from ....models.coefficient_groups import stated_groups, values_of
from ....models.model import Model
from .bases import EXACT, LACKING, UNSTATED
from .columns import CHANNELS
from .plan import PLANTED

if TYPE_CHECKING:
    from ...faults import Effect, Injected
    from ...faults.regimes import TrueRegime
    from ...faults.ships import TrueShip

BASE = "base_coefficients"
"""The cause under which a finding states groups of the base model's numbers in its details."""


class Said(Protocol):
    """What is judged of a diagnosis, or of an answer that no diagnosis of this package gave."""

    @property
    def model(self) -> Model: ...
    @property
    def verdict(self) -> str: ...
    @property
    def causes(self) -> Sequence[Finding]: ...


def named(diagnosis: Said) -> list[frozenset[str]]:
    """One set of interchangeable names for each thing that a diagnosis names, in its order.

    A single number counts as its group.  A finding of the base model's numbers names each of the groups in its details,
    by id or title; further details, "would do as well" or "coefficient", name ties or the number itself.
    """
    known = group_names(diagnosis.model)
    found = [sets for finding in diagnosis.causes for sets in _of_finding(finding, known)]
    return list(dict.fromkeys(found))


def group_names(model: Model) -> dict[str, str]:
    """Number, or title of a group in small letters -> id of the group; empty where the family states no groups."""
    groups = stated_groups(model)
    return {name: g.id for g in groups for name in g.every} | {g.title.lower(): g.id for g in groups}


def _of_finding(finding: Finding, known: Mapping[str, str]) -> list[frozenset[str]]:
    """Sets of interchangeable names of one finding."""
    ties = [*finding.tied_with, *_texts(finding.details.get("would do as well"))]
    ties = [_id(text, known) for text in ties if text != BASE]
    groups = [_id(text, known) for text in _texts(finding.details.get("groups"))]
    if finding.cause == BASE:
        return [frozenset({group, *ties}) for group in groups] or [frozenset({BASE, *ties})]
    number = finding.details.get("coefficient")
    return [frozenset({_id(str(number or finding.cause), known), *ties})]


def _texts(value: object) -> list[str]:
    """A text or a list of texts as a list."""
    if isinstance(value, str):
        return [value]
    return [str(one) for one in value] if isinstance(value, list | tuple) else []


def _id(text: str, known: Mapping[str, str]) -> str:
    """The group of a number or title, or of `group.number`; an id, also with blanks, as it is."""
    return known.get(text, known.get(text.lower(), text.replace(" ", "_").partition(".")[0]))


OUTCOMES = {
    "alone": "the first finding is the injected cause, by itself",
    "tie": "the first finding holds the injected cause, tied with others",
    "wrong_first": "the first finding does not hold the injected cause",
    "missed": "nothing was found where an effect is injected",
    "both": "each of two causes is in a finding of its own",
    "one": "one of two causes is named, or both in the same finding",
    "among": "what is wrong with the base model is in one of several findings",
    "unexplained": "an effect outside the taxonomy, or a planted null, was reported as of no known cause",
    "named": "an effect outside the taxonomy, or a planted null, was named as a cause of the taxonomy",
    "adequate": "no effect is injected and nothing was found",
    "false_alarm": "no effect is injected and something was found",
}
KNOWN, UNKNOWN = ("injected", "pair"), ("anticipated", "unforeseen", PLANTED)
NAMED_AS = {"sensor_ramp": HeadingDrift.id}
"""Effect outside the taxonomy -> the cause that is right where it is one of these: a heading that drifts, where
positions tell it from a yaw rate that does."""
POWER, LEVEL = 0.99, 0.001
"""An effect is detectable where the best test of this level has this power."""


def judge(diagnosis: Said, group: str, injected: Sequence[str], base: str = EXACT) -> dict[str, Any]:
    """The scored columns of one case: verdict, what was named, outcome, false alarm, wrong name, size of the tie, how
    many further names are none of the hull's, and how many names are stated and are false.

    Of planted nulls every name is false.  An unexplained error states none: what fits it best does not explain it.
    base : what is wrong with the base model itself (`bases.BASES`); unless it is exact, names of what it lacks itself
    are right, and count only where such an effect is injected.
    """
    injected = () if group == PLANTED else [*injected, *(NAMED_AS[name] for name in injected if name in NAMED_AS)]
    findings = [frozenset((f.cause, *f.tied_with)) for f in diagnosis.causes]
    extra = [f for f, held in zip(diagnosis.causes, findings, strict=True) if not held & set(injected)]
    others = [f for f in extra if not of_base(f.cause, base)]
    imperfect = base not in (EXACT, UNSTATED)
    if imperfect:
        pairs = zip(diagnosis.causes, findings, strict=True)
        findings = [held for f, held in pairs if not of_base(f.cause, base) or held & set(injected)]
    outcome = _outcome(diagnosis, group, injected, findings)
    return {
        "named": "+".join("/".join((f.cause, *sorted(f.tied_with))) for f in diagnosis.causes),
        "outcome": outcome,
        "false_alarm": outcome == "false_alarm" if group == "null" else None,
        "extra_names": len(others),
        **_of_names(
            diagnosis, findings, frozenset(injected), len(diagnosis.causes), len(others if imperfect else extra)
        ),
    }


def _of_names(
    diagnosis: Said, findings: Sequence[frozenset[str]], right: frozenset[str], names: int, false: int
) -> dict[str, Any]:
    """Scored columns of findings, of which names hold what is right; names, false : how many are stated and are false,
    of a diagnosis that states any."""
    holding = [found for found in findings if found & right]
    confident, stated = diagnosis.verdict in ("named", "tied"), diagnosis.verdict != "unexplained"
    return {
        "verdict": diagnosis.verdict,
        "confident_wrong": confident and any(len(found) == 1 and not found & right for found in findings),
        "tie_size": max(map(len, holding)) if holding else None,
        "names": names if stated else 0,
        "false_names": false if stated else 0,
    }


def judge_names(diagnosis: Said, right: frozenset[str]) -> dict[str, Any]:
    """The scored columns of a base with one wrong number, or of a fault in a regime, as `judge` gives them.

    right : groups of numbers and causes that name what is wrong.

    `alone`: all that is named is right; `tie`: it is tied with others; `among`: there are further findings, which
    `extra_names` counts.
    """
    findings = named(diagnosis)
    holding = [found for found in findings if found & right]
    extra = len(findings) - len(holding)
    if not holding:
        outcome = "wrong_first" if findings else "missed"
    elif extra:
        outcome = "among"
    else:
        outcome = "alone" if all(found <= right for found in holding) else "tie"
    return {
        "named": "+".join("/".join(sorted(found, key=lambda name: (name not in right, name))) for found in findings),
        "outcome": outcome,
        "false_alarm": None,
        "extra_names": extra,
        **_of_names(diagnosis, findings, right, len(findings), extra),
    }


def of_base(name: str, base: str) -> bool:
    """Whether a name says something of the base model's own numbers, or of what its family lacks."""
    known = all_causes()
    return name in LACKING.get(base, ()) or (name in known and known[name].describes_hull)


def _outcome(diagnosis: Said, group: str, injected: Sequence[str], findings: Sequence[frozenset[str]]) -> str:
    unexplained = diagnosis.verdict in ("unexplained", "described")
    if group == "null":
        return "false_alarm" if findings or unexplained else "adequate"
    if group in UNKNOWN:
        return "unexplained" if unexplained else "named" if findings else "missed"
    if not findings:
        return "missed"
    if len(injected) == 1:
        held = injected[0] in findings[0]
        return "wrong_first" if not held else "alone" if len(findings[0]) == 1 else "tie"
    if _separate(injected, findings):
        return "both"
    return "one" if any(found & set(injected) for found in findings) else "wrong_first"


def _separate(injected: Sequence[str], findings: Sequence[frozenset[str]]) -> bool:
    """Whether two causes are in two findings, one each."""
    first, second = ([i for i, found in enumerate(findings) if cause in found] for cause in injected)
    return any(i != j for i in first for j in second)


def description(diagnosis: Diagnosis, effects: Sequence[Effect]) -> dict[str, Any]:
    """The scored columns of what describes the rest: the variables, and whether a force that is told, or one that is as
    likely, depends on what an unknown effect depends on (None where no variable of it is known)."""
    right = frozenset(v for effect in effects for v in effect.kind.variables(effect.parameters))
    words = [" ".join((*force.depends_on, *force.tied_with)) for force in diagnosis.remaining]
    words += ["time" for f in diagnosis.causes if f.cause in {NAMED_AS.get(effect.kind.id) for effect in effects}]
    return {
        "described": "+".join("/".join(force.depends_on) for force in diagnosis.remaining),
        "right_variable": any(variable in said for variable in right for said in words) if right else None,
    }


def gain(diagnosis: Diagnosis) -> dict[str, float]:
    """Free-run errors on the held-out records before and after, by channel."""
    return {
        f"rmse_{when}_{channel}": float(getattr(found, f"rmse_{when}"))
        for channel, found in diagnosis.gain.items()
        if channel in CHANNELS
        for when in ("before", "after")
    }


def truth_errors(case: Injected) -> dict[str, float]:
    """Errors on the held-out records of the true ship with its effects, under the same rudder without gusts."""
    pairs = list(zip(case.held_out, case.held_out_without_gusts(), strict=True))
    found = {}
    for channel in (c for c in CHANNELS if case.held_out[0].has(c)):
        errors = np.concatenate([measured.column(channel) - true.column(channel) for measured, true in pairs])
        errors = wrapped(errors) if channel == "heading_rad" else errors
        found[f"rmse_truth_{channel}"] = float(np.sqrt(np.nanmean(errors**2)))
    return found


def detectable(case: Injected) -> bool:
    """Whether the best test at level .001 would find the effects with power .99.

    Its degrees of freedom are the numbers of the effects in the training records; an effect without a size is
    detectable.
    """
    from scipy.stats import chi2, ncx2

    if not isfinite(case.noncentrality):
        return True
    count = max(1, sum(effect.count(len(case.train)) for effect in case.effects))
    return bool(ncx2.sf(chi2.isf(LEVEL, count), count, case.noncentrality) >= POWER)


def size_rows(
    diagnosis: Said, effects: Sequence[Effect], ship: TrueShip, train: Sequence[str], held_out: Sequence[str]
) -> list[dict[str, Any]]:
    """Stated sizes of correctly named causes against the true ones; train, held_out : names of the records."""
    names = {name: i for i, name in enumerate((*train, *held_out))}
    rows = []
    for finding in diagnosis.causes:
        for effect in effects:
            if effect.cause == finding.cause:
                rows += _rows_of(finding, effect, ship, names, len(train))
    return rows


def _rows_of(
    finding: Finding, effect: Effect, ship: TrueShip, records: Mapping[str, int], training: int
) -> list[dict[str, Any]]:
    """A size of all records is compared with the mean over the training records."""
    rows = []
    for size in finding.sizes:
        which = range(training) if size.record is None else [records.get(size.record, 0)]
        each = [effect.kind.truths(effect.at(i), ship, finding.details).get(size.parameter) for i in which]
        known = [float(x) for x in each if x is not None]
        truth = sum(known) / len(known) if known else None
        if truth is not None:
            circular = size.parameter in effect.kind.directions
            rows.append({"cause": finding.cause} | compare(size, truth, circular))
    return rows


def compare(size: Size, truth: float, circular: bool = False) -> dict[str, Any]:
    """One stated size against the truth; a circular one is an angle on the full circle."""
    error, covered = abs(size.value - truth), size.low <= truth <= size.high
    if circular:
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
        "rel_error": None if circular or truth == 0.0 else error / abs(truth),
    }


def wrapped(angle: Any) -> Any:
    """An angle in -pi .. pi, or an array of such."""
    return (angle + pi) % (2.0 * pi) - pi


def regime_scores(diagnosis: Diagnosis, case: Injected) -> dict[str, Any]:
    """Columns of the regime of a case: the true one, those stated in `details["regime"]`, and their F1.

    F1 is over the samples of all training records: truly in the regime against said to be in any of those stated, both
    by the true motion.  It is 0 without a stated regime, empty without a true one.
    """
    stated = stated_regimes(diagnosis)
    true = [e.kind.regime(e.at(0), case.case.ship) for e in case.effects if e.kind.regime]
    return {
        "regime_true": "+".join(map(str, true)),
        "regime_named": "+".join(map(str, stated)),
        "regime_f1": localisation(true, stated, case.true_motion()) if true else None,
    }


def stated_regimes(diagnosis: Said) -> list[TrueRegime]:
    """The regimes that the findings of a diagnosis state."""
    from ...faults.regimes import TrueRegime

    details = [finding.details.get("regime") for finding in diagnosis.causes]
    return list(dict.fromkeys(TrueRegime.of(one) for one in details if isinstance(one, dict)))


def localisation(true: Sequence[TrueRegime], stated: Sequence[TrueRegime], runs: Sequence[Record]) -> float | None:
    """F1 of samples of records of the true motion in any of the regimes; None where the true one never occurs."""
    from ...faults.regimes import f1

    truly, said = (
        np.concatenate(
            [np.any([one.inside(run) for one in some], axis=0) if some else np.zeros(run.n, bool) for run in runs]
        )
        for some in (true, stated)
    )
    return f1(truly, said) if truly.any() else None


def healthy_bias(diagnosis: Diagnosis, true: Model, wrong: frozenset[str]) -> float | None:
    """Root mean square error of the extended model's numbers that are right in the base model, in prior standard
    deviations.

    true : the model of the ship; wrong : numbers, and groups of numbers, that are left out.  None where the family
    states no priors.
    """
    now, then = values_of(diagnosis.extended), values_of(true)
    groups = [g for g in stated_groups(true) if g.extension is None and g.id not in wrong]
    own = {name: sd for g in groups for name, sd in g.sd.items() if name not in wrong}
    errors = [(now[name] - then[name]) / sd for name, sd in own.items() if name in now]
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else None
