"""The diagnosis of a base model whose own numbers may be wrong: sensors first, then causes beside a discrepancy."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.base import Check
from ...estimation.diagnosis_only.refit import refit
from ...estimation.filters.innovations.estimator import Estimator, estimator
from ...models.errors import FitFailed
from ...models.instruments import combined
from .. import verdict
from ..causes.base import Cause
from ..causes.base_coefficients import BaseCoefficients
from ..causes.registry import causes, terms_for
from ..causes.rudder_effectiveness import RudderEffectiveness
from ..felt import felt
from ..findings import diagnosis_of, noise_of, of_fault
from ..gain.extension import extended_model
from ..gain.measured import base_setting, gain_of, held_out_setting
from ..kinematics.stage import Sensors, sensors_of
from ..result import Entry, Finding
from ..starting import starting_state, thinned
from ..state import Candidate, State
from .entering import entering
from .fit import Base, Fitted
from .projection import number_of, projected
from .quadratic import MOST, mode
from .regimes import Local, local_errors
from .search import Accepted, Found, search
from .shares import Shares, shares, simulating_variances
from .subsets import Subset, best_subsets
from .terms import NUMBERS, terms_of
from .told import STAGE, Sized, finding, sized

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.settings import Setting
    from ...models.model import Model
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis
    from ..state import Variant

LEFT_OUT = ("coefficient_shift", "clock_jitter", "wave_drift", "speed_loss", "second_order_lead")
"""Causes that a discrepancy takes the place of, or that its remains feed; of a response model a rudder of another
effectiveness too, which is its turning gain."""
OF_HULL = ("shallow_water",)
"""Causes beside those of the hull that describe its numbers."""
EXACT = 3.0
"""Nats of marginal likelihood below which the base model's own numbers count as exact."""
BOUND = 0.98
"""Share of the largest variance of the model's numbers from which they are further off than their priors hold: no cause
can be told beside them, and free runs have to say more."""
NAMED, PARTLY = 0.8, 0.2
MOVED = 2.0
"""Posterior standard deviations from which a number counts as moved."""
GAINS = ("b", "b1")
"""Turning gains of response models: a rudder of another effectiveness is nothing else."""
SELECTED = ("rudder_offset",)
"""Numbers of the rudder that are chosen together with those of the hull, by free runs."""
TAKEN_BACK = 0.1
"""Share of a sensor's size up to which what two stages say of it together is nothing."""
AT_BOUND = "the base model's own numbers are at the bound of their priors, which it cannot be told from"
HULL = "a description of the hull, which wrong numbers of the base model cannot be told from"


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
    sensors = sensors_of(given.train, given.held_out, options.causes())
    state, cannot = starting_state(_estimator(model, sensors.train, options), options)
    if verdict.undecidable(state.est, state.start) is not None:
        return BesideNumbers(None, given, given)
    if state.now.diverged:
        raise FitFailed(f"model {model.id} cannot be run with the records: its filter is not finite")
    base = Base(state.est, terms_of(state.est, state.now), state.start)
    left = LEFT_OUT if model.is_3dof else (*LEFT_OUT, RudderEffectiveness.id)
    bank = {c: v for c, v in state.bank.items() if c.id not in left}
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
    if any(of_hull(a.cause) for a in found.accepted):
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
    held = found.final.variances[NUMBERS] < BOUND * MOST[NUMBERS]
    all_together = "" if held else AT_BOUND
    enough = _explained(parts, ()) >= PARTLY
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


def of_hull(cause: Check) -> bool:
    """Whether a cause describes the hull, as the base model's own numbers do."""
    return cause.where == "hull" or cause.id in OF_HULL


# ---- what is told
def _told(
    done: Conclusion, raw: State, sensors: Sensors, given: Prepared, options: Options, cannot: Mapping[Cause, str],
    rng: np.random.Generator,
) -> BesideNumbers:  # fmt: skip
    """The diagnosis, with gains on the records as they were given, and the records behind sensors and causes.

    raw : the base model on these.
    """
    findings = _findings(done, rng)
    of_numbers = any(BaseCoefficients.id in (f.cause, *f.tied_with) for f in findings)
    causes, own = _built_in(done, of_numbers, raw.est)
    values = {name: value for name, value in sensors.shown.instruments.items() if name in raw.est.index}
    setting = raw.est.with_entries(own, values)
    entered = [Candidate(a.cause, a.variant, a.log_p, a.statistic, setting, raw.now) for a in causes]
    state = replace(raw, nuisance=(), prior=None).at(setting, raw.now, entered)
    held_out = thinned(given.held_out, raw.est.model)
    predicted = gain_of(state, base_setting(state, options), setting, held_out, rng)
    cleaned = behind_sensors(given, sensors)
    behind = felt(cleaned.train, raw.est, own, SELECTED), cleaned.held_out
    if held_out:
        behind = behind[0], felt(cleaned.held_out, *held_out_setting(state, own, held_out), SELECTED)
    every = (*map(of_fault, given.faults), *given.shown.findings, *once(sensors.shown.findings, findings))
    instruments = combined(given.instruments, sensors.shown.instruments)
    extended = extended_model(raw.est, setting, [a.cause for a in causes], {**instruments})
    noise = noise_of(raw.est, done.found.final.setting)
    bank = _bank(done, every, cannot)
    told = diagnosis_of((raw.est.model, extended), options, _verdict(done, every), every, bank, predicted, noise=noise)
    behind_causes = replace(cleaned, train=behind[0], held_out=behind[1])
    projection = projected(done.found.final, _beside_hull(done.found))
    subsets = best_subsets(projection.profile)
    regimes = partial(local_errors, done.found.final, projection, subsets)
    return BesideNumbers(told, cleaned, behind_causes, subsets, regimes)


def _regimes(found: Found) -> tuple[Local, ...]:
    """Numbers that are wrong in a part of the runs only, beside the causes that a search accepted."""
    projection = projected(found.final, _beside_hull(found))
    return local_errors(found.final, projection, best_subsets(projection.profile))


def _beside_hull(found: Found) -> np.ndarray:
    """Places, among the causes' parameters of the last fit, of those that do not describe the hull."""
    owners = [a.cause for a in found.accepted for _ in a.variant]
    return np.array([i for i, cause in enumerate(owners) if not of_hull(cause)], int)


def once(of_channels: Sequence[Finding], of_motion: Sequence[Finding]) -> list[Finding]:
    """Findings of both stages, a cause that both name once, of both sizes together; not at all where the second size
    takes the first one back, which was that of a cause it was tied with."""
    sized = {f.cause for f in of_channels if f.sizes}
    twice = {f.cause: f for f in of_motion if f.sizes and f.cause in sized}
    out = []
    for f in of_channels:
        if f.cause not in twice or not f.sizes:
            out.append(f)
            continue
        one, other = f.sizes[0], twice[f.cause].sizes[0]
        middle = one.value + other.value
        half = 0.5 * float(np.hypot(one.high - one.low, other.high - other.low))
        if abs(middle) > max(half, TAKEN_BACK * abs(one.value)):
            both = replace(one, value=middle, low=middle - half, high=middle + half)
            out.append(replace(f, sizes=(both,), evidence=f"{f.evidence}; {twice[f.cause].evidence}"))
    return [*out, *(f for f in of_motion if f.cause not in twice or not f.sizes)]


def _findings(done: Conclusion, rng: np.random.Generator) -> list[Finding]:
    """Causes that are none of the hull's, the base model's own numbers, and what describes these."""
    final = done.found.final
    held = len(final.base.terms.parameters)
    x = final.x.copy()
    x[:held] = 0.0
    s = final.base.at(x, final.variant, final.setting)
    told = [(one, finding(one, s, final.base.est, done.shares.drops[i], rng)) for i, one in done.named]
    own = [f for one, f in told if not of_hull(one.accepted.cause)]
    hull = [
        replace(f, tied_with=(*f.tied_with, BaseCoefficients.id), evidence=f"{f.evidence}; {HULL}")
        for one, f in told
        if of_hull(one.accepted.cause)
    ]
    numbers = _of_numbers(done)
    return [*own, *([numbers] if numbers is not None else []), *hull]


def _of_numbers(done: Conclusion) -> Finding | None:
    """That the base model's own numbers are wrong; None where they take nothing off free runs.

    Which ones is not told: what a ridge moves is correlated with what is wrong, and no more (see `subsets`).
    """
    ways = (done.shares.beside,) if done.named else (done.shares.numbers, done.shares.beside)
    part = max(ways, key=lambda share: share.low)
    if not part.low > 0.0:
        return None
    final, est = done.found.final, done.found.final.base.est
    values, spread = _numbers_at(final)
    z = values / np.maximum(spread, 1e-300)
    off = float(np.sqrt(np.mean((values**2 + spread**2)[final.base.terms.group == NUMBERS])))
    said = (
        f"the model's own numbers, off by {off:.2g} prior standard deviations or so, "
        f"take off {part.text} of the squared error of free runs of records that were left out"
    )
    moved = {number_of(p) for p, own in zip(final.base.terms.parameters, z.tolist(), strict=True) if abs(own) > MOVED}
    gain = not est.model.is_3dof and bool(moved & {*GAINS})
    return Finding(
        BaseCoefficients.id,
        (RudderEffectiveness.id,) if gain else (),
        STAGE,
        float(np.sum(z**2)),
        0.0,
        (),
        evidence=said,
        separate_by=RudderEffectiveness.separate_by if gain else None,
    )


def _numbers_at(final: Fitted) -> tuple[np.ndarray, np.ndarray]:
    """Values and standard deviations (m,) of the terms that a simulation carries, in prior standard deviations; zero of
    all others."""
    at = mode(final.expansion, simulating_variances(final), final.free)
    terms = final.base.terms
    spread = np.zeros(final.x.size)
    spread[at.active] = np.sqrt(np.diag(at.covariance))
    count = len(terms.parameters)
    return np.where(terms.simulating, at.x[:count], 0.0), np.where(terms.simulating, spread[:count], 0.0)


def _built_in(done: Conclusion, of_numbers: bool, est: Estimator) -> tuple[list[Accepted], Setting]:
    """Accepted causes that the extended model holds, and the setting of it.

    of_numbers : whether what is named says that the base model's own numbers are wrong.
    """
    final = done.found.final
    chosen = entering(final, places_of(done.found), [i for i, _ in done.named], of_numbers)
    named = [done.found.accepted[i] for i in chosen.causes]
    kept = any(a.time_s is not None or not a.variant for a in named)
    base = final.base if kept else replace(final.base, origin=est.start())
    return named, base.at(chosen.x, final.variant, final.setting)


def _verdict(done: Conclusion, findings: Sequence[Finding]) -> tuple[str, str]:
    """By the share of the explainable error that is explained."""
    explained = _explained(done.shares, [i for i, *_ in done.others])
    said = f"what is named takes off {100.0 * min(explained, 1.0):.0f} % of what can be explained of the free-run error"
    if not findings:
        return "unexplained", "no cause stands beside the base model's own numbers, and these explain nothing"
    if explained >= NAMED:
        ties = any(f.tied_with for f in findings if not _of_numbers_alone(f))
        return ("tied" if ties else "named"), said
    return ("partly_named" if explained >= PARTLY or not done.shares.channels else "unexplained"), said


def _explained(parts: Shares, without: Sequence[int]) -> float:
    """Share of the explainable error that all but some of the causes, and the numbers, take off.

    Eq. 15 of docs/mathematics/default-route.md.
    """
    return float(np.mean([channel.explained(without) for channel in parts.channels] or [0.0]))


def _of_numbers_alone(f: Finding) -> bool:
    return f.cause == BaseCoefficients.id or f.tied_with == (BaseCoefficients.id,)


def _bank(done: Conclusion, findings: Sequence[Finding], cannot: Mapping[Cause, str]) -> tuple[Entry, ...]:
    """One line for every cause of the taxonomy."""
    named = {f.cause: f for f in findings}
    tied = {name: f.cause for f in findings for name in f.tied_with}
    seen = {one.accepted.cause.id: (done.shares.drops[i], reason) for i, one, reason in done.others}
    leads = {cause.id: lead for cause, lead in done.found.leads.items()}
    untestable = {cause.id: why for cause, why in cannot.items()}
    out = []
    for cause in causes().values():
        lead = leads.get(cause.id)
        statistic = None if lead is None else lead.statistic
        p = None if lead is None else float(min(1.0, 25.0 * np.exp(max(lead.log_p, -700.0))))
        if cause.id in named:
            f = named[cause.id]
            status, statistic, p, why = "tied" if f.tied_with else "named", f.statistic, f.p_adjusted, f.evidence
        elif cause.id in tied:
            status, why = "tied", f"cannot be told from {tied[cause.id]} on these records"
        elif cause.id in seen and not seen[cause.id][0].low > 0.0:
            status, why = "not_significant", "detectable, but takes nothing off the free-run error for sure"
        elif cause.id in seen:
            share, reason = seen[cause.id]
            status, why = "explained_by", f"takes off {share.text} of the free-run error; not named: {reason}"
        elif cause.id in untestable:
            status, why = "not_testable", untestable[cause.id]
        elif cause.id in LEFT_OUT:
            status, why = "not_testable", "the base model's own numbers, which are uncertain, take its place"
        else:
            status, why = "not_significant", "no evidence beside the base model's own numbers"
        out.append(Entry(cause.id, status, statistic, p, None, why))
    return tuple(out)
