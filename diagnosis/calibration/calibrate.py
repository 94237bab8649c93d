"""The steps of a calibration: records, groups of numbers that move, what they take off the errors, what remains."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.result import NORMAL_90
from ...estimation.diagnosis_only.mixed_effects.left_out import jackknife, score_difference
from ...estimation.diagnosis_only.mixed_effects.problem import Problem, pooled
from ...estimation.results.fit import arithmetic_guard, blas_limited
from ...estimation.run.run import squares_of
from ...models.coefficient_groups import OWN, Group, groups_of, grown
from ...models.errors import BadInput, CannotFit
from ...models.instruments import combined
from ...models.linear_algebra import pinv
from ..causes.constant_force import ConstantForce
from ..causes.registry import causes_of
from ..gain.guard import WORSE
from ..gain.own import own_run
from ..one_bank.behind import behind_causes, in_flows, instruments_behind
from ..one_bank.diagnose import choice_and_diagnosis
from ..options import Options
from ..prepared import corrected_records
from ..report.verdict import by_share
from .advice import next_runs
from .attempts import LONG, Attempt, NamedGroup, Selection, attempt, loses, on_whole_records, whole_and_parts
from .every_number import every_number
from .held_out import HeldOut, with_held_out
from .ingredients import floor, ingredients
from .problems import FEWEST, columns_of, errors_of, problems_of
from .regimes import Proposal, confirmation
from .remaining import remaining
from .result import Calibration, Moved, RunEffect, Share, StepTold
from .traces import left_out_traces

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.diagnosis_only.mixed_effects.fit import Fitted
    from ...estimation.selection.selection import Entered
    from ...models.model import Model
    from ..one_bank.search import Choice
    from ..prepared import Prepared
    from .held_out import Errors
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


def _calibration(model: Model, train: Sequence[Record], held_out: Sequence[Record]) -> Calibration:
    if not train:
        raise BadInput("no training record", hint="give at least one")
    if not model.known:
        raise BadInput(f"model {model.id} has no coefficients to calibrate", hint="name a vessel or a model.json")
    options = Options().checked(model)
    records = corrected_records(model, train, held_out, options).behind_sensors(None)
    instruments = combined(model.instruments, records.instruments)
    try:
        choice, _ = choice_and_diagnosis(model, records, held_out, options, never=(ConstantForce.id,))
    except CannotFit:
        return _calibrated(_Sides.without_causes(records, held_out), model, instruments, None, options.threads)
    behind = replace(
        records, train=behind_causes(choice, records.train), held_out=behind_causes(choice, records.held_out)
    )
    held = HeldOut(held_out, [in_flows(record, choice) for record in held_out])
    instruments = combined(instruments, instruments_behind(choice))
    return _calibrated(_Sides(records, behind, held), model, instruments, choice, options.threads)


class _Sides(NamedTuple):
    """Records as they were corrected, without what known causes explain, and the held-out ones as they were read."""

    given: Prepared
    behind: Prepared
    held_out: HeldOut

    @classmethod
    def without_causes(cls, given: Prepared, recorded: Sequence[Record]) -> _Sides:
        """Records that no known cause is taken off; recorded : held-out ones as they were read."""
        return cls(given, given, HeldOut(recorded, recorded))


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


def _proposal(choice: Choice) -> Proposal | None:
    """The number in a regime that pieces name, with the numbers beside it."""
    local, final = choice.local, choice.selection.final
    if local is None or choice.beside:
        return None
    names = (n for c in choice.selection.candidates for n in c.names if choice.bank.places[n].kind == "model")
    sd = dict(zip((n.name for n in final.numbers), final.sd.tolist(), strict=True))[local.size]
    return Proposal(local, final.value(local.size), sd, tuple(names))


def _calibrated(
    records: _Sides, model: Model, instruments: dict[str, float], choice: Choice | None, threads: int
) -> Calibration:
    """The calibration on true motions by the choice of pieces; None: they cannot be made.

    instruments : of the model, of what was corrected and of known causes.
    threads : threads that run the fits; the results do not depend on them.
    """
    given, behind, held = records
    started, train, groups = time.perf_counter(), given.train, groups_of(model)
    whole = grown(model, groups)
    inside = outside = problems_of(whole, behind, threads)
    if behind is not given:
        outside = problems_of(whole, given, threads)
        outside = outside if outside.runs == inside.runs else inside
    selection = _selection(inside.train, groups, model, choice)
    base = selection.base if outside is inside else attempt(outside.train, (), None, LONG)
    if not selection.steps and loses(
        inside.train, base, selection.base
    ):  # causes that need numbers which are not confirmed
        plain = _Sides(given, given, HeldOut(held.recorded, held.recorded))
        return _calibrated(plain, model, combined(model.instruments, given.instruments), None, threads)
    local = None if choice is None else confirmation(inside.train, selection, groups, _proposal(choice))
    if local is not None:
        selection, groups = local.selection, [*groups, local.group]
        inside = inside.with_change(local.problem.local)
    shares = _shares(inside.train, base, selection)
    verdict, reason = _verdict(inside.train, base, selection, shares)
    if selection.steps and len(train) < FEWEST:
        reason = f"{reason}; they are judged by pieces of the same records, and other records may show other numbers"
    extended = _with_numbers(model, selection.final, "extended", {})
    moved = _moved(selection.final, groups)
    moved = moved if local is None else (*moved[:-1], local.told(moved[-1]))
    advised = next_runs(extended, whole, selection, groups)
    extended = replace(extended if local is None else local.extended(extended), instruments=instruments)
    sparse = local is not None or verdict == "adequate"
    wide = selection.final if sparse else every_number(inside.train, groups, selection)
    built = partial(_built, replace(whole, instruments=instruments), extended, selection.final, local)
    alone = errors_of(outside, base)
    before = with_held_out(alone, held.base_runs(model))
    after = with_held_out(errors_of(inside, selection.final), held.runs(built(selection.final)))
    wide_model = built(wide)
    predicted = after if wide is selection.final else with_held_out(errors_of(inside, wide), held.runs(wide_model))
    return Calibration(
        model=model,
        extended=extended,
        calibrated=extended if wide is selection.final else _with_numbers(model, wide, "calibrated", instruments),
        records=tuple([(r.name, "train") for r in train] + [(r.name, "held_out") for r in given.held_out]),
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
                *_both(with_held_out(errors_of(inside, s.attempt), held.runs(built(s.attempt)))),
            )
            for s in selection.steps
        ),
        before=before,
        after=after,
        shares=shares,
        remaining=remaining(inside.train, selection.final),
        runs=tuple(
            RunEffect(run.name, float(own[0]))
            for run, own in zip(inside.train.runs, selection.final.fitted.own, strict=True)
        ),
        traces=(
            *left_out_traces(outside.train, inside.train, selection.final),
            *held.traces(model, built(selection.final)),
        ),
        next_runs=advised,
        worse=tuple(c for c, (_, new) in after.items() if new is not None and new > WORSE * (before[c][1] or np.inf)),
        wall_s=time.perf_counter() - started,
        regime=None if local is None else local.stated,
        predicted=predicted,
        own=_own(held, model, wide_model, before),
        ingredients=ingredients(inside, alone, wide),
        floor=floor(inside, wide, groups),
    )


def _selection(problem: Problem, groups: Sequence[Group], model: Model, choice: Choice | None) -> Selection:
    """What pieces name, on whole records: some groups, or all of the model's own numbers where these predict left-out
    records better than few."""
    base = attempt(problem, (), None, LONG)
    if choice is None:
        return Selection(base, (), base)
    changes = choice.selection.final.point.values
    if not choice.beside:
        named = _named_groups(choice, choice.selection.entered, groups, model)
        return on_whole_records(problem, base, named, changes)
    few = on_whole_records(problem, base, _named_groups(choice, choice.few, groups, model), {})
    own = Group(OWN, "all of the model's own numbers", None, {n.name: n.sd for n in choice.bank.own})
    every = on_whole_records(problem, base, [NamedGroup(own)], changes)
    better = score_difference(problem, few.final.left_out, every.final.left_out).gain > 0.0
    return every if better else few


def _both(errors: Errors) -> tuple[dict[str, float], dict[str, float]]:
    held = {c: new for c, (_, new) in errors.items() if new is not None}
    return {c: old for c, (old, _) in errors.items()}, held


def _built(whole: Model, extended: Model, final: Attempt, local: Confirmation | None, attempt: Attempt) -> Model:
    """The model of an attempt: `whole`, which carries all groups, with its numbers; what differs in a regime only the
    extended model holds."""
    if local is not None and attempt is final:
        return extended
    theta, count = attempt.fitted.theta[: whole.theta.size], len(whole.coordinates)
    return replace(whole, coefficients=theta[:count], constants=theta[count:])


def _own(held: HeldOut, model: Model, moved: Model, columns: Errors) -> dict[str, tuple[float, float]]:
    """Column -> errors of base and calibrated model with every held-out record's own neutral angle and start."""
    both = [squares_of(held.base_runs(model, own_run)), squares_of(held.runs(moved, own_run))]
    return {c: (both[0][c].scores()[0], both[1][c].scores()[0]) for c in columns if all(c in side for side in both)}


def _with_numbers(model: Model, final: Attempt, kind: str, instruments: dict[str, float]) -> Model:
    """The base model behind some instruments with the extensions of the chosen groups only, and all numbers where the
    fit put them; kind : of the two models, in the name of the new one."""
    smallest = grown(replace(model, instruments=instruments), final.groups)
    known = dict(zip(final.fitted.problem.names, final.fitted.theta.tolist(), strict=True))
    coefficients = np.array([known[name] for name in smallest.coordinates])
    constants = np.array([known[name] for name in smallest.constant_names])
    name = f"{model.id}+{kind}" if final.groups else model.id
    return replace(smallest, id=name, coefficients=coefficients, constants=constants)


def _moved(final: Attempt, groups: Sequence[Group]) -> tuple[Moved, ...]:
    """Numbers with intervals of the larger of jackknife and model standard error.

    Eq. 9 of docs/mathematics/calibration.md.
    """
    fitted = final.fitted
    if not fitted.numbers:
        return ()
    covariance, without = pinv(fitted.normal), np.array([x.values for x in final.left_out])
    spread = np.maximum(np.sqrt(np.diag(covariance)), jackknife(without))
    owner = {name: group for group in groups for name in group.every}
    place = {n.name: j for j, n in enumerate(fitted.numbers)}
    out = []
    for n, value, sd in zip(fitted.numbers, fitted.values.tolist(), spread.tolist(), strict=True):
        percent = 100.0 * (value / n.mean - 1.0) if n.mean else None
        half, group, change = NORMAL_90 * sd, owner[n.name], (value - n.mean) / n.sd
        kept = group.ratio_to in place and _keeps_ratio(
            fitted, covariance, without, place[n.name], place[group.ratio_to]
        )
        out.append(
            Moved(n.name, group.id, n.mean, value, value - half, value + half, percent, change, in_proportion=kept)
        )
    return tuple(out)


def _keeps_ratio(fitted: Fitted, covariance: np.ndarray, without: np.ndarray, one: int, other: int) -> bool:
    """Whether the 90 % interval of the ratio of two numbers, from their places, holds that of the base model.

    without (R, p) : values by fits without each record.
    """
    a, b = fitted.values[[one, other]].tolist()
    if not (b and fitted.numbers[other].mean):
        return False
    before = fitted.numbers[one].mean / fitted.numbers[other].mean
    slope = np.array([1.0 / b, -a / b**2])
    pair = [one, other]
    sd = np.sqrt(slope @ covariance[np.ix_(pair, pair)] @ slope)
    sd = max(float(sd), float(jackknife(without[:, [one]] / without[:, [other]])[0]))
    return abs(a / b - before) <= NORMAL_90 * sd


def _shares(p: Problem, given: Attempt, found: Selection) -> dict[str, Share]:
    """Shares of the base model's squared free-run error, by column; given : the base model without known causes."""
    base, beside = (pooled([x.free for x in a.left_out]) ** 2 for a in (given, found.base))
    after = pooled([x.free for x in found.final.left_out]) ** 2
    adapted = np.minimum(pooled([x.adapted for x in found.final.left_out]) ** 2, after)
    noise = np.minimum(p.noise_variance, adapted)
    out = {}
    for c, column in enumerate(columns_of(p)):
        parts = (beside[c] - after[c], after[c] - adapted[c], noise[c], adapted[c] - noise[c], base[c] - beside[c])
        out[column] = Share(*(float(part / base[c]) for part in parts))
    return out


def _verdict(p: Problem, given: Attempt, found: Selection, shares: Mapping[str, Share]) -> tuple[str, str]:
    """The verdict, and the sentence that supports it (eq. 10 of docs/mathematics/calibration.md)."""
    base = pooled([x.adapted for x in given.left_out])
    matter = [c for c, motion in zip(p.state_places, p.motion, strict=True) if base[c] > ADEQUATE * motion]
    columns = columns_of(p)
    if not matter and not found.steps:
        limit = f"{100 * ADEQUATE:.0f} % of each channel's motion"
        return "adequate", f"but for the trim of single runs, free-run errors are below {limit}"
    counted = [shares[columns[c]] for c in matter] or list(shares.values())
    explained = float(np.mean([s.explained for s in counted]))
    return by_share("the numbers that moved take", explained)
