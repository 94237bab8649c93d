"""The diagnosis of a base model whose own numbers may be wrong: sensors first, then causes beside a discrepancy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..estimation.diagnosis_only.refit import refit
from ..estimation.filters.innovations.estimator import Estimator, estimator
from ..models.errors import FitFailed
from ..models.instruments import combined
from .causes.base import Cause
from .causes.base_coefficients import BaseCoefficients
from .causes.registry import terms_for
from .causes.rudder_effectiveness import RudderEffectiveness
from .criteria.marginal_likelihood import Found, MarginalCandidate, search
from .discrepancy.entering import entering
from .discrepancy.fit import Base, Fitted
from .discrepancy.projection import number_of, projected
from .discrepancy.quadratic import mode
from .discrepancy.regimes import Local, local_errors
from .discrepancy.shares import Shares, shares, simulating_variances
from .discrepancy.subsets import Subset, best_subsets
from .discrepancy.terms import NUMBERS, terms_of
from .discrepancy.told import Sized, sized
from .felt import felt
from .gain.extension import extended_model
from .gain.measured import held_out_setting, of_state
from .report import findings, verdict
from .report.bank import beside_numbers
from .report.outcome import diagnosis_of, noise_of
from .starting import starting_state, thinned
from .state import State

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.filters.innovations.settings import Setting
    from ..models.model import Model
    from .candidate import Variant
    from .kinematics.stage import Sensors
    from .options import Options
    from .prepared import Prepared
    from .result import Diagnosis, Finding

EXACT = 3.0
"""Nats of marginal likelihood below which the base model's own numbers count as exact."""
SLIGHT = 0.005
"""Share of the squared free-run error below which the numbers take nothing off it."""
MOVED = 2.0
"""Posterior standard deviations from which a number counts as moved."""
SELECTED = ("rudder_offset",)
"""Numbers of the rudder that are chosen together with those of the hull, by free runs."""
AT_BOUND = "the base model's own numbers are at the bound of their priors, which it cannot be told from"


@dataclass(frozen=True)
class Conclusion:
    """The search, sizes of what is named with the index of its drop, of what is not with the reason, and shares."""

    found: Found
    named: tuple[tuple[int, Sized], ...]
    others: tuple[tuple[int, Sized, str], ...]
    shares: Shares


class BesideNumbers(NamedTuple):
    """What the likelihood says where the base model's own numbers are uncertain.

    found : the diagnosis; None where the likelihood shows no error of the numbers beside causes and gusts, or the
    records cannot decide.  cleaned : the records with the sensors' errors removed.  felt : also without what the causes
    that entered explain, so that what is left is the hull's.  subsets : the best small sets of the numbers.  regimes :
    looks for numbers that are wrong in a part of the runs only.
    """

    found: Diagnosis | None
    cleaned: Prepared
    felt: Prepared
    subsets: tuple[Subset, ...] = ()
    regimes: Callable[[], tuple[Local, ...]] = tuple


def of_uncertain_base(model: Model, given: Prepared, options: Options) -> BesideNumbers:
    """The diagnosis with the base model's own numbers uncertain.

    Raises
    ------
    CannotFit : a record lacks what the model needs.
    FitFailed : the model cannot be run with the records.
    """
    rng = np.random.default_rng(options.seed)
    sensors = given.sensors(options.causes())
    state, cannot = starting_state(_estimator(model, sensors.train, options), options)
    if verdict.undecidable(state.est, state.start) is not None:
        return BesideNumbers(None, given, given)
    if state.now.diverged:
        raise FitFailed(f"model {model.id} cannot be run with the records: its filter is not finite")
    base = Base(state.est, terms_of(state.est, state.now), state.start)
    bank = {c: v for c, v in state.bank.items() if c.stands_beside_numbers(model.is_3dof)}
    found = search(state, base, bank, options.max_effects, rng)
    if _exact(found):
        cleaned = behind_sensors(given, sensors)
        return BesideNumbers(None, cleaned, cleaned, (), partial(_regimes, found))
    done = _concluded(found, bank, rng)
    raw = state if sensors.train is given.train else starting_state(_estimator(model, given.train, options), options)[0]
    return _told(done, raw, sensors, given, options, cannot, rng)


def _estimator(model: Model, records: Sequence[Record], options: Options) -> Estimator:
    return estimator(model, thinned(records, model), threads=options.threads, terms=terms_for(model))


def behind_sensors(given: Prepared, sensors: Sensors) -> Prepared:
    """Records with the sensors' errors removed, and what was found of these."""
    return replace(
        given,
        train=sensors.train,
        held_out=sensors.held_out,
        shown=given.shown.then(sensors.shown),
        decided=frozenset(sensors.shown.statistics),
    )


def _exact(found: Found) -> bool:
    """Whether the discrepancy gains nothing beside causes none of which is the hull's, or without any.

    Eq. 13 of docs/mathematics/default-route.md.
    """
    if any(a.cause.describes_hull for a in found.accepted):
        return False
    final = found.final
    held = len(final.base.terms.parameters)
    x = final.x.copy()
    x[:held] = 0.0
    s = final.base.at(x, final.variant, final.setting)
    best = -np.inf
    for noise in (s.noise, final.base.origin.noise):
        _, now = refit(final.base.est, replace(s, noise=noise), final.variant, 4)
        best = max(best, now.log_likelihood)
    return final.evidence - best < EXACT


# ---- what stands
def _concluded(found: Found, bank: Mapping[Cause, Sequence[Variant]], rng: np.random.Generator) -> Conclusion:
    """The causes that matter: by size, by an interval without zero, and by what they take off free runs; where all
    together take little off, none but waves, which no free run has."""
    every = sized(found, bank)
    parts = shares(found.null, found.final, places_of(found), rng)
    all_together = AT_BOUND if found.final.at_bound else ""
    enough = _explained(parts, ()) >= verdict.PARTLY
    why = [
        all_together or _why_not(found.final, one, felt, enough) for one, felt in zip(every, parts.felt, strict=True)
    ]
    chosen = list(enumerate(zip(every, why, strict=True)))
    return Conclusion(
        found,
        tuple((i, one) for i, (one, reason) in chosen if not reason),
        tuple((i, one, reason) for i, (one, reason) in chosen if reason),
        parts,
    )


def places_of(found: Found) -> list[np.ndarray]:
    """Places of each accepted cause's parameters among those of the last fit."""
    edges = np.cumsum([len(found.final.base.terms.parameters), *(len(a.variant) for a in found.accepted)])
    return [np.arange(a, b) for a, b in pairwise(edges.tolist())]


def _why_not(final: Fitted, one: Sized, felt: bool, enough: bool) -> str:
    """Why a cause that the search accepted is not named; '' where it is."""
    if not one.variant:
        return ""  # waves: a random motion that no free run has
    if not one.accepted.cause.matters(final.base.est, one.variant, one.values):
        return "too small to matter"
    if not one.clear:
        return "its size is not clearly other than zero"
    if not felt:
        return "no channel's free-run error is surely smaller by it"
    return "" if enough else "all causes together take little off the free-run error"


# ---- what is told
def _told(
    done: Conclusion, raw: State, sensors: Sensors, given: Prepared, options: Options, cannot: Mapping[Cause, str],
    rng: np.random.Generator,
) -> BesideNumbers:  # fmt: skip
    """The diagnosis, with gains on the records as they were given, and the records behind sensors and causes.

    raw : the base model on these.
    """
    own_findings = _findings(done, rng)
    of_numbers = any(BaseCoefficients.id in (f.cause, *f.tied_with) for f in own_findings)
    causes, own = _built_in(done, of_numbers, raw.est)
    values = {name: value for name, value in sensors.shown.instruments.items() if name in raw.est.index}
    setting = raw.est.with_entries(own, values)
    entered = [replace(a, setting=setting, now=raw.now) for a in causes]
    state = replace(raw, nuisance=(), prior=None).at(setting, raw.now, entered)
    held_out = thinned(given.held_out, raw.est.model)
    of_record = of_state(state, setting, held_out)
    cleaned = behind_sensors(given, sensors)
    behind = felt(cleaned.train, raw.est, own, SELECTED), cleaned.held_out
    if held_out:
        behind = behind[0], felt(cleaned.held_out, *held_out_setting(state, own, held_out), SELECTED)
    of_faults = [findings.of_fault(fault) for fault in given.faults]
    every = (*of_faults, *given.shown.findings, *findings.once(sensors.shown.findings, own_findings))
    instruments = combined(given.instruments, sensors.shown.instruments)
    extended = extended_model(raw.est, setting, [a.cause for a in causes], {**instruments})
    noise = noise_of(raw.est, done.found.final.setting)
    others = {one.accepted.cause.id: (done.shares.drops[i], reason) for i, one, reason in done.others}
    bank = beside_numbers(done.found, every, others, cannot)
    told = diagnosis_of((raw.est.model, extended), options, _verdict(done, every), every, bank, noise=noise)
    behind_causes = replace(cleaned, train=behind[0], held_out=behind[1])
    projection = projected(done.found.final, _beside_hull(done.found))
    subsets = best_subsets(projection.profile)
    regimes = partial(local_errors, done.found.final, projection, subsets)
    return BesideNumbers(replace(told, of_held_out=of_record), cleaned, behind_causes, subsets, regimes)


def _regimes(found: Found) -> tuple[Local, ...]:
    """Numbers that are wrong in a part of the runs only, beside the causes that a search accepted."""
    projection = projected(found.final, _beside_hull(found))
    return local_errors(found.final, projection, best_subsets(projection.profile))


def _beside_hull(found: Found) -> np.ndarray:
    """Places, among the causes' parameters of the last fit, of those that do not describe the hull."""
    owners = [a.cause for a in found.accepted for _ in a.variant]
    return np.array([i for i, cause in enumerate(owners) if not cause.describes_hull], int)


def _findings(done: Conclusion, rng: np.random.Generator) -> list[Finding]:
    """Causes that are none of the hull's, the base model's own numbers, and what describes these."""
    final = done.found.final
    held = len(final.base.terms.parameters)
    x = final.x.copy()
    x[:held] = 0.0
    s = final.base.at(x, final.variant, final.setting)
    told = [
        (one.accepted.cause, findings.of_cause_beside(one, s, final.base.est, done.shares.drops[i], rng))
        for i, one in done.named
    ]
    own = [f for cause, f in told if not cause.describes_hull]
    hull = [findings.of_the_hull(f) for cause, f in told if cause.describes_hull]
    return [*own, *_of_numbers(done), *hull]


def _of_numbers(done: Conclusion) -> list[Finding]:
    """That the base model's own numbers are wrong; nothing where they take nothing off free runs."""
    ways = (done.shares.beside,) if done.named else (done.shares.numbers, done.shares.beside)
    part = max(ways, key=lambda share: share.low)
    if not part.low > 0.0 or part.value < SLIGHT:
        return []
    final = done.found.final
    values, spread = _numbers_at(final)
    z = values / np.maximum(spread, 1e-300)
    off = float(np.sqrt(np.mean((values**2 + spread**2)[final.base.terms.group == NUMBERS])))
    moved = {number_of(p) for p, own in zip(final.base.terms.parameters, z.tolist(), strict=True) if abs(own) > MOVED}
    gain = not final.base.est.model.is_3dof and bool(moved & {*RudderEffectiveness.gains})
    return [findings.of_numbers(z, off, part, gain)]


def _numbers_at(final: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard deviations (m,) of the terms that a simulation carries, in prior standard deviations; zero of
    all others."""
    at = mode(final.expansion, simulating_variances(final), final.free)
    terms = final.base.terms
    spread = np.zeros(final.x.size)
    spread[at.active] = np.sqrt(np.diag(at.covariance))
    count = len(terms.parameters)
    return np.where(terms.simulating, at.x[:count], 0.0), np.where(terms.simulating, spread[:count], 0.0)


def _built_in(done: Conclusion, of_numbers: bool, est: Estimator) -> tuple[list[MarginalCandidate], Setting]:
    """Accepted causes that the extended model holds, and the setting of it.

    of_numbers : whether what is named says that the base model's own numbers are wrong.
    """
    final = done.found.final
    chosen = entering(final, places_of(done.found), [i for i, _ in done.named], of_numbers)
    named = [done.found.accepted[i] for i in chosen.causes]
    kept = any(a.time_s is not None or not a.variant for a in named)
    base = final.base if kept else replace(final.base, origin=est.start())
    return named, base.at(chosen.x, final.variant, final.setting)


def _verdict(done: Conclusion, found: Sequence[Finding]) -> tuple[str, str]:
    """By the share of the explainable error that is explained."""
    explained = _explained(done.shares, [i for i, *_ in done.others])
    if not found:
        return "unexplained", "no cause stands beside the base model's own numbers, and these explain nothing"
    behind = any(f.stage == findings.BY_CHANNELS for f in found)
    what = "what is named beside errors of files and sensors takes" if behind else "what is named takes"
    decided, said = verdict.by_share(what, explained)
    if decided == "named" and any(f.tied_with for f in found if not _of_numbers_alone(f)):
        return "tied", said
    return ("partly_named" if decided == "unexplained" and not done.shares.channels else decided), said


def _explained(parts: Shares, without: Sequence[int]) -> float:
    """Share of the explainable error that all but some of the causes, and the numbers, take off.

    Eq. 15 of docs/mathematics/default-route.md.
    """
    return float(np.mean([channel.explained(without) for channel in parts.channels] or [0.0]))


def _of_numbers_alone(f: Finding) -> bool:
    return f.cause == BaseCoefficients.id or f.tied_with == (BaseCoefficients.id,)
