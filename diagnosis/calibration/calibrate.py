"""The steps of a calibration: records, groups of numbers that move, what they take off the errors, what remains."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import NORMAL_90
from ...estimation.results.fit import arithmetic_guard, blas_limited
from ...estimation.run.run import squares_of
from ...estimation.selection.score import jackknife
from ...estimation.selection.selection import mean_squares
from ...models.coefficient_groups import OWN, Group, groups_of, grown, with_values
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.instruments import combined
from ..causes.missing_terms import ConstantForce
from ..causes.registry import causes_of
from ..free_runs.units import FEWEST, names_of_units
from ..gain.guard import WORSE
from ..gain.runs import own_run, trace_of
from ..one_bank.answer import in_wind
from ..one_bank.behind import behind_causes, in_flows, instruments_behind
from ..one_bank.diagnose import choice_and_diagnosis
from ..options import Options
from ..prepared import corrected_records
from ..report.verdict import by_share
from .group_fits import (
    GroupFit,
    GroupSteps,
    HeldOut,
    NamedGroup,
    columns_of_states,
    errors_of,
    every_number,
    fit_groups,
    loses,
    on_whole_records,
    runs_along,
    score_fall,
    states_of,
    whole_and_parts,
    whole_records,
    with_held_out,
)
from .regimes import confirmation, places_of
from .result import Calibration, Moved, RunEffect, Share, StepTold
from .what_remains import floor, ingredients, left_out_traces, next_runs, remaining

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.selection import Entered
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from ..one_bank.search import Choice
    from ..prepared import Prepared
    from .group_fits import Errors, WholeRecords
    from .regimes import Confirmation


ADEQUATE = 0.05
"""Share of a channel's own motion below which its free-run error is no matter."""


def calibrate(model: Model, train: Sequence[Record], held_out: Sequence[Record] = ()) -> Calibration:
    """Say which numbers of a model are wrong and by how much, by free runs of records that were left out.

    Parameters
    ----------
    model : 3-DOF model with coefficients, whose family states groups of coefficients.
    train, held_out : records in SI units; held-out records take no part but that what worsens them is withdrawn, as by
        `diagnose`.

    Raises
    ------
    BadInput : no training record, a model without coefficients, or a family that states no groups.
    CannotFit : the records lack what free runs need, or are too short to leave a part out.
    FitFailed : the model cannot be run with the records, or the arithmetic fails.
    """
    with arithmetic_guard(), blas_limited():
        return _calibration(model, train, held_out)


def corrected_particulars(ship: Model, train: Sequence[Record]) -> tuple[Model, list[str]]:
    """A simulation of a craft's particulars with the numbers that the training records move under their priors, and
    what must be known: why it is as it was given."""
    try:
        return calibrate(ship, train).calibrated, []
    except (CannotFit, FitFailed) as reason:
        return ship, [f"The simulation of the particulars is as it was given: {reason}."]


def _calibration(model: Model, train: Sequence[Record], held_out: Sequence[Record]) -> Calibration:
    if not train:
        raise BadInput("no training record", hint="give at least one")
    if not model.known:
        raise BadInput(f"model {model.id} has no coefficients to calibrate", hint="name a vessel or a model.json")
    options = Options().checked(model)
    records = corrected_records(model, train, held_out, options).behind_sensors(None)
    instruments = combined(model.instruments, records.instruments)
    try:
        choice = choice_and_diagnosis(model, records, held_out, options, never=(ConstantForce.id,)).choice
    except CannotFit:
        return _calibrated(records, records, HeldOut(held_out, held_out), model, instruments, None)
    behind = replace(
        records, train=behind_causes(choice, records.train), held_out=behind_causes(choice, records.held_out)
    )
    held = HeldOut(held_out, [in_flows(record, choice) for record in held_out])
    instruments = combined(instruments, instruments_behind(choice))
    return _calibrated(records, behind, held, in_wind(model, choice), instruments, choice)


def _named_groups(
    choice: Choice, entered: Sequence[Entered], groups: Sequence[Group], model: Model
) -> list[NamedGroup]:
    """The groups of numbers that pieces name, those of terms that the model lacks by their causes."""
    known, by_id = causes_of(model), whole_and_parts(groups)
    by_cause = {known[g.id]: g for g in groups if g.id in known}
    out = []
    for one in entered:
        group = by_id.get(one.candidate.id) or by_cause.get(choice.bank.cause_of(one.candidate))
        if group is not None:
            out.append(NamedGroup(group, tuple(c.of for c in one.tied_with)))
    return out


def _calibrated(
    corrected: Prepared,
    behind: Prepared,
    held: HeldOut,
    model: Model,
    instruments: dict[str, float],
    choice: Choice | None,
) -> Calibration:
    """The calibration on true motions by the choice of pieces; None: they cannot be made.

    corrected, behind : records as they were corrected, and without what known causes explain.  instruments : of the
    model, of what was corrected and of known causes.
    """
    started, train, groups = time.perf_counter(), corrected.train, groups_of(model)
    whole = grown(model, groups)
    inside = outside = whole_records(whole, behind)
    if behind is not corrected:
        outside = whole_records(whole, corrected)
        outside = outside if _names(outside) == _names(inside) else inside
    selection = _selection(inside.train, groups, model, choice)
    base = selection.base if outside is inside else fit_groups(outside.train, ())
    if not selection.steps and loses(inside.train, base, selection.base):  # causes need numbers that are not confirmed
        plain, own = HeldOut(held.recorded, held.recorded), combined(model.instruments, corrected.instruments)
        return _calibrated(corrected, corrected, plain, model, own, None)
    local = None if choice is None else confirmation(inside.train, selection, groups, choice)
    if local is not None:
        selection, groups = local.selection, [*groups, local.group]
        inside = inside.with_numbers(places_of(local.local, whole))
    shares = _shares(inside.train, base, selection)
    verdict, reason = _verdict(inside.train, base, selection, shares)
    if selection.steps and len(train) < FEWEST:
        reason = f"{reason}; they are judged by pieces of the same records, and other records may show other numbers"
    extended = _with_numbers(model, inside.train, selection.final, "extended", {})
    moved = _moved(inside.train, selection.final, groups)
    moved = moved if local is None else (*moved[:-1], local.told(moved[-1]))
    advised = next_runs(extended, inside.train, selection, groups)
    extended = replace(extended if local is None else local.extended(extended), instruments=instruments)
    sparse = local is not None or verdict == "adequate"
    wide = selection.final if sparse else every_number(inside.train, groups, selection)
    built = partial(_built, inside.train, instruments, extended, selection.final, local)
    alone = errors_of(outside, base)
    base_runs, final_runs = runs_along(model, held.recorded), runs_along(built(selection.final), held.explained)
    before, after = with_held_out(alone, base_runs), with_held_out(errors_of(inside, selection.final), final_runs)

    def errors(fit: GroupFit) -> Errors:
        return with_held_out(errors_of(inside, fit), runs_along(built(fit), held.explained))

    predicted, calibrated = after, extended
    if wide is not selection.final:
        predicted, calibrated = errors(wide), _with_numbers(model, inside.train, wide, "calibrated", instruments)
    return Calibration(
        model=model,
        extended=extended,
        calibrated=calibrated,
        records=tuple([(r.name, "train") for r in train] + [(r.name, "held_out") for r in corrected.held_out]),
        verdict=verdict,
        reason=reason,
        moved=moved,
        steps=tuple(
            StepTold(
                s.group.of,
                s.group.title,
                s.fall.gain,
                s.fall.error,
                s.tied_with,
                *_both(errors(s.fit)),
            )
            for s in selection.steps
        ),
        before=before,
        after=after,
        shares=shares,
        remaining=remaining(inside.train, selection.final),
        runs=tuple(
            RunEffect(name, float(own[0]))
            for name, own in zip(_names(inside), selection.final.fitted.point.own, strict=True)
        ),
        traces=(
            *left_out_traces(outside.train, inside.train, selection.final),
            *(trace_of(old, new, "held_out") for old, new in zip(base_runs, final_runs, strict=True)),
        ),
        next_runs=advised,
        worse=tuple(c for c, (_, new) in after.items() if new is not None and new > WORSE * (before[c][1] or np.inf)),
        wall_s=time.perf_counter() - started,
        regime=None if local is None else local.stated,
        predicted=predicted,
        own=_own(held, model, built(wide), before),
        ingredients=ingredients(inside, alone, wide),
        floor=floor(inside, wide, groups),
    )


def _names(records: WholeRecords) -> list[str]:
    return names_of_units(records.train.units)


def _selection(runs: FreeRuns, groups: Sequence[Group], model: Model, choice: Choice | None) -> GroupSteps:
    """What pieces name, on whole records: some groups, or all of the model's own numbers where these predict left-out
    records better than few."""
    base = fit_groups(runs, ())
    if choice is None:
        return GroupSteps(base, (), base)
    changes = choice.selection.final.point.values
    if not choice.beside:
        by_pieces = _named_groups(choice, choice.selection.entered, groups, model)
        return on_whole_records(runs, base, by_pieces, changes)
    entered = () if choice.few is None else choice.few.entered
    few = on_whole_records(runs, base, _named_groups(choice, entered, groups, model), {})
    own = Group(OWN, "all of the model's own numbers", None, {n.name: n.sd for n in choice.bank.own})
    every = on_whole_records(runs, base, [NamedGroup(own)], changes)
    return every if score_fall(runs, few.final, every.final).gain > 0.0 else few


def _both(errors: Errors) -> tuple[dict[str, float], dict[str, float]]:
    held = {c: new for c, (_, new) in errors.items() if new is not None}
    return {c: old for c, (old, _) in errors.items()}, held


def _built(
    runs: FreeRuns,
    instruments: dict[str, float],
    extended: Model,
    final: GroupFit,
    local: Confirmation | None,
    fit: GroupFit,
) -> Model:
    """The model of a fit, which carries all groups, with its numbers; what differs in a regime only the extended
    model holds."""
    if local is not None and fit is final:
        return extended
    return with_values(replace(runs.bank.model, instruments=instruments), _values(runs, fit))


def _values(runs: FreeRuns, fit: GroupFit) -> dict[str, float]:
    """Number of the model -> its value by a fit."""
    return {name: x + fit.fitted.value(name) for name, x in runs.bank.values.items()}


def _own(held: HeldOut, model: Model, moved: Model, columns: Errors) -> dict[str, tuple[float, float]]:
    """Column -> errors of base and calibrated model with every held-out record's own neutral angle and start."""
    pairs = (model, held.recorded), (moved, held.explained)
    both = [squares_of(runs_along(one, records, own_run)) for one, records in pairs]
    return {c: (both[0][c].scores()[0], both[1][c].scores()[0]) for c in columns if all(c in side for side in both)}


def _with_numbers(model: Model, runs: FreeRuns, final: GroupFit, kind: str, instruments: dict[str, float]) -> Model:
    """The base model behind some instruments with the extensions of the chosen groups only, and all numbers where the
    fit put them; kind : of the two models, in the name of the new one."""
    smallest = grown(replace(model, instruments=instruments), final.groups)
    name = f"{model.id}+{kind}" if final.groups else model.id
    return replace(with_values(smallest, _values(runs, final)), id=name)


def _moved(runs: FreeRuns, final: GroupFit, groups: Sequence[Group]) -> tuple[Moved, ...]:
    """Numbers with intervals of the larger of jackknife and model standard error.

    Eq. 3 of docs/mathematics/calibration.md.
    """
    fitted = final.fitted
    owner = {name: group for group in groups for name in group.every}
    place = {n.name: j for j, n in enumerate(fitted.numbers)}
    out = []
    for n, sd in zip(fitted.numbers, fitted.sd.tolist(), strict=True):
        change, before, half = fitted.value(n.name), runs.bank.values.get(n.name, 0.0), NORMAL_90 * sd
        percent, after, group = 100.0 * change / before if before else None, before + change, owner[n.name]
        kept = group.ratio_to in place and _keeps_ratio(runs, fitted, n.name, group.ratio_to)
        out.append(
            Moved(
                n.name, group.id, before, after, after - half, after + half, percent, change / n.sd, in_proportion=kept
            )
        )
    return tuple(out)


def _keeps_ratio(runs: FreeRuns, fitted: Fitted, one: str, other: str) -> bool:
    """Whether the 90 % interval of the ratio of two numbers holds that of the base model."""
    names, base = [n.name for n in fitted.numbers], runs.bank.values
    a, b = (base[n] + fitted.value(n) for n in (one, other))
    if not (b and base[other]):
        return False
    pair, slope = [names.index(one), names.index(other)], np.array([1.0 / b, -a / b**2])
    sd = np.sqrt(slope @ fitted.covariance[np.ix_(pair, pair)] @ slope)
    ratios = np.array([(base[one] + w[one]) / (base[other] + w[other]) for w in fitted.without])
    return abs(a / b - base[one] / base[other]) <= NORMAL_90 * max(float(sd), float(jackknife(ratios)))


def _shares(runs: FreeRuns, fit: GroupFit, selection: GroupSteps) -> dict[str, Share]:
    """Shares of the base model's squared free-run error, by column; given : the base model without known causes."""
    base, with_causes, after = (mean_squares(runs, a.blind) for a in (fit, selection.base, selection.final))
    adapted = np.minimum(mean_squares(runs, selection.final.fitted.left_out), after)
    noise = np.minimum(runs.noise, adapted)
    out = {}
    for c, column in enumerate(runs.channels):
        parts = (
            with_causes[c] - after[c],
            after[c] - adapted[c],
            noise[c],
            adapted[c] - noise[c],
            base[c] - with_causes[c],
        )
        out[column] = Share(*(float(part / base[c]) for part in parts))
    return out


def _verdict(runs: FreeRuns, fit: GroupFit, selection: GroupSteps, shares: Mapping[str, Share]) -> tuple[str, str]:
    """The verdict, and the sentence that supports it (eq. 4 of docs/mathematics/calibration.md)."""
    beyond_noise = np.maximum(mean_squares(runs, fit.fitted.left_out) - runs.noise, 0.0)
    large = states_of(runs, np.sqrt(beyond_noise) > ADEQUATE * runs.motion)
    matter = [column for column, is_large in zip(columns_of_states(runs), large, strict=True) if is_large]
    if not matter and not selection.steps:
        limit = f"{100 * ADEQUATE:.0f} % of each channel's motion"
        return "adequate", f"but for the trim of single runs, free-run errors are below {limit}"
    counted = [shares[column] for column in matter] or list(shares.values())
    explained = float(np.mean([s.explained for s in counted]))
    return by_share("the numbers that moved take", explained)
