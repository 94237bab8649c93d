"""A calibration: what free runs of left-out pieces say of a model, told number by number.

Records, bank, choice and errors are those of `diagnose`: causes of rudder, sensors and weather compete with the numbers
of the model, so that no number takes their place, and stand in the extended model as instruments.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import NORMAL_90, Size
from ...estimation.results.fit import arithmetic_guard, blas_limited
from ...estimation.run.run import squares_of
from ...estimation.run.stretch import stretches_of
from ...estimation.selection.score import jackknife
from ...estimation.selection.selection import fall_between, mean_squares, with_only
from ...models.coefficient_groups import OWN, Group, groups_of, values_of
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.families.extensions import OFFSET
from ..causes.base_coefficients import BaseCoefficients
from ..causes.registry import causes_of
from ..causes.steering_gear import RudderOffset
from ..diagnose import through_the_water
from ..gain.guard import WORSE
from ..gain.runs import own_effects, pairs_of, without_instruments
from ..one_bank.answer import extended_model, model_values
from ..one_bank.diagnose import by_pieces
from ..one_bank.search import half_intervals, interval_factor
from ..options import Options
from ..prepared import ready_records
from ..report.bank import BY_FREE_RUNS
from ..report.verdict import where_wrong
from ..result import CHANGE
from .result import Calibration, Moved, Remaining, RunEffect, Share, StatedRegime, StepTold
from .what_remains import floor, ingredients, next_runs

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Candidate
    from ...models.model import Model
    from ..one_bank.search import Choice
    from ..result import Diagnosis, Finding, Trace

ALL = "all of the model's own numbers"
STANDS_OUT, MOST_OF_IT = 1.5, 0.3
"""Share of the error over share of the time, and share of the error, from which a condition is told."""


def calibrate(model: Model, train: Sequence[Record], held_out: Sequence[Record] = ()) -> Calibration:
    """Say which numbers of a model are wrong and by how much, by free runs of pieces of records that were left out.

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
    _groups(ship)
    options = Options().checked(ship)
    try:
        with arithmetic_guard(), blas_limited():
            said = by_pieces(ship, ready_records(ship, train, (), options)[0], (), options).diagnosis
    except (CannotFit, FitFailed) as reason:
        return ship, [f"The simulation of the particulars is as it was given: {reason}."]
    return said.calibrated or said.extended, []


def _groups(model: Model) -> tuple[Group, ...]:
    """The groups of a model's numbers; BadInput where it has no numbers, or its family states no groups."""
    if not model.known:
        raise BadInput(f"model {model.id} has no coefficients to calibrate", hint="name a vessel or a model.json")
    return groups_of(model)


def _calibration(model: Model, train: Sequence[Record], held_out: Sequence[Record]) -> Calibration:
    started, groups, options = time.perf_counter(), _groups(model), Options().checked(model)
    records, aside = ready_records(model, train, held_out, options)
    behind = records.behind_sensors(None)
    held = behind.put_back(records.recorded)
    choice, wide, said, _ = by_pieces(model, records, held, through_the_water(options, records))
    runs, selection, widest = choice.runs, choice.selection, choice if wide is None else wide
    gain, wide_gain = said.gain, said.calibrated_gain or said.gain

    def errors(fitted: Fitted, of_held_out: Mapping[str, float]) -> dict[str, tuple[float, float | None]]:
        """Column -> errors of left-out pieces and of held-out records."""
        own = np.sqrt(mean_squares(runs, fitted.left_out)).tolist()
        return {c: (error, of_held_out.get(c)) for c, error in zip(runs.channels, own, strict=True)}

    before = errors(selection.base, {c: g.rmse_before for c, g in gain.items()})
    after = errors(selection.final, {c: g.rmse_after for c, g in gain.items()})
    alike = [record for record in behind.train if record.name not in said.apart]
    plain = without_instruments(said.extended, {*model.instruments, *behind.instruments})
    return Calibration(
        model=model,
        extended=said.extended,
        calibrated=said.calibrated or said.extended,
        records=tuple([(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]),
        verdict=said.verdict,
        reason="; ".join([said.reason, *_other_causes(said), *_few_alone(choice, said)]),
        moved=tuple(_moved(choice, said, groups)),
        steps=tuple(_steps(choice, said, groups, behind.instruments, held)),
        before=before,
        after=after,
        shares=_shares(choice),
        remaining=tuple(_remaining(runs.channels, [t for t in said.traces if t.role == "train"])),
        runs=tuple(_own_angles(plain, alike)),
        traces=said.traces,
        next_runs=next_runs(plain, choice),
        worse=tuple(c for c, (_, new) in after.items() if new is not None and new > WORSE * (before[c][1] or np.inf)),
        wall_s=time.perf_counter() - started,
        regime=_regime(choice),
        predicted=errors(widest.selection.final, {c: g.rmse_after for c, g in wide_gain.items()}),
        own={c: (gain[c].own_before, wide_gain[c].own_after) for c in before if c in gain},
        ingredients=ingredients(widest),
        floor=floor(widest, behind.held_out),
        doubts=(*aside, *said.doubts),
    )


def _other_causes(said: Diagnosis) -> Iterator[str]:
    """The causes that are no numbers of the model, in words."""
    of_numbers = {BaseCoefficients.id, *causes_of(said.model).values()}
    others = [f.cause.replace("_", " ") for f in said.causes if f.cause not in of_numbers]
    if others:
        yield f"beside numbers of the model: {', '.join(others)}"


def _few_alone(choice: Choice, said: Diagnosis) -> Iterator[str]:
    """Where all of the model's own numbers are uncertain and none of them is named: the few that were chosen without
    all."""
    if choice.few is None or not any(f.cause == BaseCoefficients.id and not f.sizes for f in said.causes):
        return
    final, values = choice.few.final, choice.bank.values
    few = [name for candidate in choice.few.candidates for name in candidate.names if name in values]
    if few:
        yield f"few numbers alone would be {', '.join(f'{n} {values[n] + final.value(n):.3g}' for n in few)}"


# ---- numbers that moved
def _moved(choice: Choice, said: Diagnosis, groups: Sequence[Group]) -> Iterator[Moved]:
    """The numbers of the model that the diagnosis names, with its sizes and intervals."""
    owner = {name: group for group in groups for name in group.every}
    before = {**choice.bank.values, **values_of(said.model)}
    for finding in (f for f in said.causes if f.stage == BY_FREE_RUNS):
        if choice.local is not None and "regime" in finding.details:
            yield _moved_in_regime(choice, next(s for s in finding.sizes if s.parameter.startswith(CHANGE)))
        elif finding.cause == RudderOffset.id:
            yield _neutral_angle(finding, owner[OFFSET].id if OFFSET in owner else finding.cause)
        for size in finding.sizes or _all_sizes(choice, finding):
            name, group = size.parameter, owner.get(size.parameter)
            if group is not None and name in before:
                old, change = before[name], size.value - before[name]
                percent, sds = 100.0 * change / old if old else None, change / group.every[name]
                kept = _keeps_ratio(choice, name, group.ratio_to)
                yield Moved(name, group.id, old, size.value, size.low, size.high, percent, sds, in_proportion=kept)


def _all_sizes(choice: Choice, finding: Finding) -> list[Size]:
    """The sizes of all of the model's own numbers, where these are what is named."""
    if finding.cause != BaseCoefficients.id:
        return []
    values, halves = model_values(choice), half_intervals(choice.runs, choice.selection.final, choice.beside)
    both = [(n.name, values[n.name], halves[n.name]) for n in choice.bank.own]
    return [Size(name, value, value - half, value + half, "1") for name, value, half in both]


def _neutral_angle(finding: Finding, group: str) -> Moved:
    """The neutral rudder angle, rad; of those of single records the mean, whose interval holds their spread."""
    values, halves = np.array([(s.value, 0.5 * (s.high - s.low)) for s in finding.sizes]).T
    mean, spread = float(values.mean()), NORMAL_90 * values.std(ddof=1) if values.size > 1 else 0.0
    half = float(np.sqrt((np.mean(halves**2) + spread**2) / values.size))
    return Moved(OFFSET, group, 0.0, mean, mean - half, mean + half, None, mean / RudderOffset.prior.sd)


def _moved_in_regime(choice: Choice, size: Size) -> Moved:
    """A number as it is inside the regime; its size is a share of it, rad of the neutral rudder angle."""
    local = choice.local
    assert local is not None
    number, sds = local.number, size.value / local.number.sd
    if number.name == OFFSET:
        return Moved(OFFSET, number.group, 0.0, size.value, size.low, size.high, None, sds, local.words)
    old = next(iter(number.change.values())) if len(number.change) == 1 else 1.0
    low, high = sorted((old * (1.0 + size.low), old * (1.0 + size.high)))
    after, percent = old * (1.0 + size.value), 100.0 * size.value
    return Moved(number.name, number.group, old, after, low, high, percent, sds, local.words)


def _regime(choice: Choice) -> StatedRegime | None:
    if choice.local is None:
        return None
    share = choice.runs.share_taken(choice.selection.base, choice.selection.final)
    return StatedRegime(**choice.local.facts, share_of_error=share)


def _keeps_ratio(choice: Choice, one: str, other: str) -> bool:
    """Whether both numbers moved, and the 90 % interval of their ratio holds that of the base model.

    Eq. 2 of docs/mathematics/calibration.md.
    """
    fitted, base = choice.selection.final, choice.bank.values
    names = [n.name for n in fitted.numbers]
    if not {one, other} <= {*names} or not base[other]:
        return False
    a, b = (base[n] + fitted.value(n) for n in (one, other))
    pair, slope = [names.index(one), names.index(other)], np.array([1.0 / b, -a / b**2])
    sd = np.sqrt(slope @ fitted.covariance[np.ix_(pair, pair)] @ slope)
    ratios = np.array([(base[one] + w[one]) / (base[other] + w[other]) for w in fitted.without])
    widest = interval_factor(choice.runs) * max(float(sd), float(jackknife(ratios)))
    return abs(a / b - base[one] / base[other]) <= widest


# ---- steps and shares
def _steps(
    choice: Choice,
    said: Diagnosis,
    groups: Sequence[Group],
    corrected: Mapping[str, float],
    held_out: Sequence[Record],
) -> Iterator[StepTold]:
    """What entered, in its order, with the errors up to it; first all of the model's own numbers, where it is beside
    them.

    corrected : instruments that were corrected in the records.  held_out : as they were read.
    """
    runs, selection, own = choice.runs, choice.selection, choice.bank.own if choice.beside else ()
    group_of = {cause: group for group, cause in causes_of(said.model).items()}
    titles = {g.id: g.title for g in groups} | dict(choice.bank.titles) | {OWN: ALL}

    def name_of(candidate: Candidate) -> str:
        return group_of.get(choice.bank.cause_of(candidate), candidate.of)

    entered = [(name_of(e.candidate), tuple(dict.fromkeys(map(name_of, e.tied_with)))) for e in selection.entered]
    told = [*([(OWN, ())] if own else []), *entered]
    before = selection.base
    for i, (name, tied) in enumerate(told, 1):
        count = i - bool(own)
        part = selection if i == len(told) else with_only(runs, selection, selection.entered[:count], own)
        by, before = fall_between(runs, before, part.final), part.final
        left_out = np.sqrt(mean_squares(runs, part.final.left_out)).tolist()
        extended = extended_model(said.model, replace(choice, selection=part), corrected)
        pairs = pairs_of(said.model, extended, held_out, said.of_held_out, runs.channels, own=False)
        held = {c: sums.scores()[0] for c, sums in squares_of([pair.after for pair in pairs]).items()}
        errors = dict(zip(runs.channels, left_out, strict=True)), {c: held[c] for c in runs.channels if c in held}
        yield StepTold(name, titles.get(name, name.replace("_", " ")), by.gain, by.error, tied, *errors)


def _shares(choice: Choice) -> dict[str, Share]:
    """Shares of the base model's squared free-run error, by column.

    Eq. 3 of docs/mathematics/calibration.md.
    """
    runs, fits = choice.runs, (choice.selection.base, choice.selection.final)
    base, after = (mean_squares(runs, runs.squares(one.without, runs.no_own)) for one in fits)
    adapted = np.minimum(mean_squares(runs, choice.selection.final.left_out), after)
    noise = np.minimum(runs.noise, adapted)
    parts = np.stack([base - after, after - adapted, noise, adapted - noise]) / np.maximum(base, 1e-300)
    return {column: Share(*part) for column, part in zip(runs.channels, parts.T.tolist(), strict=True)}


# ---- what remains of single records
def _remaining(columns: Sequence[str], traces: Sequence[Trace]) -> list[Remaining]:
    """Conditions that hold more of a channel's squared error than of the time, the most telling first."""
    rows = [Remaining(**row) for column in columns for row in where_wrong(column, traces, lambda t: t.after)]
    large = [r for r in rows if r.share_of_error > max(STANDS_OUT * r.share_of_time, MOST_OF_IT)]
    return sorted(large, key=lambda r: r.share_of_time - r.share_of_error)


def _own_angles(extended: Model, records: Sequence[Record]) -> Iterator[RunEffect]:
    """The neutral rudder angle of each record about the common one: the mean over its stretches."""
    for record in records:
        with suppress(CannotFit):
            angles = [own_effects(stretch)[0] for stretch in stretches_of(extended, record)]
            yield RunEffect(record.name, float(np.mean(angles)))
