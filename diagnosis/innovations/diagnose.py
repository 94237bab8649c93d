"""The diagnosis from the innovations of the filter: the base model is exact, or free as the options say."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import adjusted, log_tail
from ...estimation.filters.innovations.estimator import estimator
from ...estimation.filters.innovations.settings import Parameter
from ..causes.registry import terms_for, testable
from ..gain.guard import worsens
from ..gain.runs import with_runs
from ..prepared import thinned
from ..report.bank import BY_RESIDUALS, DECIDED, of_fault
from ..report.verdict import diagnosis_of
from .as_model import extended_model, of_state
from .criterion import material, select, without
from .report import SMALL, bank_of, decide, findings_of, hypothesis_of, noise_of, undecidable
from .state import Candidate, State, Unmodelled, first_state
from .tests import LATER, Memory, noise_with_memory
from .unmodelled import unexplained

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...models.model import Model
    from ..causes.base import Cause
    from ..options import Options
    from ..prepared import Prepared
    from ..result import Diagnosis


PREDICTS_WORSE = "whole records are predicted worse with it"
IN_NOISE = "not significant where the sensors' noise has a memory"


@dataclass(frozen=True)
class Selected:
    """What the residuals show, before anything is predicted.

    left : what is not explained.  poor : why the records cannot decide anything.  cannot : causes that were not tested,
    with the reason.  small : causes below the size that matters.  rng : goes on with what follows.
    """

    state: State
    left: Candidate | None
    poor: str | None
    cannot: dict[Cause, str]
    small: frozenset[Cause]
    rng: np.random.Generator


def selected(model: Model, records: Prepared, options: Options) -> Selected:
    """Causes by forward selection, and what they leave unexplained."""
    rng = np.random.default_rng(options.seed)
    train = thinned(records.train, model)
    est = estimator(model, train, threads=options.threads, terms=terms_for(model))
    state, cannot = starting_state(est, options, records.decided)
    poor = undecidable(est, state.start)
    state = select(state, options.max_effects, rng) if poor is None else state
    left = unexplained(state, rng) if poor is None else None
    small: frozenset[Cause] = frozenset()
    if options.coefficient_sd != 0.0:  # of a model that is exactly known every effect counts
        state, small = material(state)
    return Selected(state, left, poor, cannot, small, rng)


def by_innovations(model: Model, records: Prepared, held_out: Sequence[Record], options: Options) -> Diagnosis:
    """The diagnosis; what worsens whole records is withdrawn, the last that entered first.

    records : as they were corrected.  held_out : as they were read.
    """
    choice = selected(model, records, options)
    without_gain: list[Cause] = []
    while True:
        outcome = concluded(model, records, options, choice, without_gain)
        diagnosis = with_runs(outcome, records.train, records.instruments, held_out, options.channels)
        kept = [cause for cause in choice.state.causes if cause not in without_gain]
        if not kept or not worsens(diagnosis):
            return diagnosis
        without_gain.append(kept[-1])


def concluded(
    model: Model, records: Prepared, options: Options, selected: Selected, without_gain: Collection[Cause] = ()
) -> Diagnosis:
    """The diagnosis with its extended model, without its gain.

    without_gain : causes that the extended model may not hold, as whole records are predicted worse with them.
    """
    state, rng, held_out = selected.state, selected.rng, thinned(records.held_out, model)
    exact = options.coefficient_sd == 0.0
    memory = noise_with_memory(state.est, state.now) if exact and selected.left is not None else []
    weak = _weak(state, memory)
    state = _without(state, weak)
    kept = _without(state, [cause for cause in state.causes if cause in without_gain])
    refused = _why(without_gain, PREDICTS_WORSE)
    left = _what_looks_like(refused, state) or selected.left
    immaterial = _why(selected.small, SMALL) | _why(weak, IN_NOISE)
    own = [f for f in findings_of(state, refused, rng) if f.cause not in immaterial]
    every = [*(of_fault(*f, records.few.get(f[0], ())) for f in records.faults.items()), *records.findings, *own]
    names_some = any(f.stage == BY_RESIDUALS for f in every)
    instead = names_some and left is not None and left is state.rival
    est = state.est
    outcome = diagnosis_of(
        (model, extended_model(est, kept.setting, kept.causes, records.instruments)),
        options,
        decide(selected.poor, left, instead, every),
        every,
        bank_of(state, selected.cannot, records.tested, immaterial, every),
        noise=noise_of(est, state.setting),
        poor=selected.poor,
        hypothesis=hypothesis_of(state, left, held_out),
        doubts=_doubts_of(memory),
    )
    return replace(outcome, of_held_out=of_state(kept, held_out))


def _weak(state: State, memory: Sequence[Memory]) -> list[Cause]:
    """Causes that are not significant where only so many samples count as noise with a memory makes independent."""
    if not memory:
        return []
    share = float(np.mean([channel.independent for channel in memory]))

    def significant(candidate: Candidate) -> bool:
        return adjusted(log_tail(share * candidate.statistic, len(candidate.variant)), state.n_effective) <= state.alpha

    return [cause for cause, a in zip(state.causes, state.accepted, strict=True) if not significant(a)]


def _doubts_of(memory: Sequence[Memory]) -> tuple[str, ...]:
    """What noise with a memory makes doubtful, in one sentence."""
    if not memory:
        return ()
    names = ", ".join(f"{one.channel} ({one.near:.2f} and {one.later:.2f})" for one in memory)
    said = f"residuals are correlated from sample to sample and hardly over {LATER} samples, as filtered noise is"
    return (f"{said}: {names}; likelihoods take noise as white and are too sure of small effects",)


def _without(state: State, causes: Collection[Cause]) -> State:
    for cause in causes:
        state = without(state, next(a for a in state.accepted if a.cause == cause))
    return state


def _why(causes: Iterable[Cause], reason: str) -> dict[str, str]:
    return {cause.id: reason for cause in causes}


def _what_looks_like(refused: Mapping[str, str], state: State) -> Candidate | None:
    """What fits the residuals and is refused by free runs, as an effect that is not known."""
    if not refused:
        return None
    label = f"{' and '.join(refused)}, or what looks like it here: {' and '.join(dict.fromkeys(refused.values()))}"
    return Candidate(Unmodelled(label), (), 0.0, 0.0, state.setting, state.now)


def starting_state(est: Estimator, options: Options, decided: Collection[str] = ()) -> tuple[State, dict]:
    """The first state of the selection, and the causes that cannot be tested with the reason.

    decided : causes that the sensors' channels have decided on without the model.
    """
    bank, cannot = testable(est)
    only = options.causes()
    cannot |= {cause: DECIDED for cause in bank if cause.id in decided}
    if only is not None:
        cannot |= {cause: "left out" for cause in bank if cause not in only}
    bank = {cause: variants for cause, variants in bank.items() if cause not in cannot}
    nuisance, prior = _free_coefficients(est, options)
    speed = _reference_speed(est)
    prior = None if prior is None else np.append(prior, np.zeros(len(speed)))
    return first_state(est, bank, options.alpha, (*nuisance, *speed), prior), cannot


def _reference_speed(est: Estimator) -> tuple[Parameter, ...]:
    """The speed on a straight course against which a response model's surge shows a loss: estimated along."""
    if "speed_loss_state" not in est.kernels.STATES or not est.channels[2]:
        return ()
    return (Parameter("reference speed", "m/s", ((est.index["reference_speed"], 1.0),)),)


def _free_coefficients(est: Estimator, options: Options) -> tuple[tuple[Parameter, ...], np.ndarray | None]:
    """Coefficients that are estimated along, with the precisions of their prior."""
    model = est.model
    if options.base_parameters == "file" and not options.coefficient_sd:
        return (), None
    pairs = zip(model.coordinates, model.coefficients.tolist(), strict=True)
    free = tuple(Parameter(name, "", ((est.index[name], abs(value)),)) for name, value in pairs if value != 0.0)
    if options.base_parameters == "identify":
        return free, None
    return free, np.full(len(free), (options.coefficient_sd or 1.0) ** -2.0)
