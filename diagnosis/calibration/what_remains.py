"""What a calibration tells beside its numbers: runs of records that were left out, where the remaining error lies, what
the prediction owes to each of its ingredients, the error that stays whatever the numbers are, and which manoeuvre would
tell most about the numbers that the records leave open.

An ingredient is left out, all numbers are fitted again, and the squared error that comes back is what it removes.  The
floor is the error of held-out records that the model is fitted to themselves: what stays there no change of its numbers
takes off, so that an error at the floor is the structure's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.generator import record_run
from ...datasets.manoeuvres import parse_manoeuvre
from ...estimation.information.design import information_gain
from ...estimation.records.series import MEASURED
from ...estimation.selection.number import distinct
from ...models.model import CHANNELS
from ..free_runs.bank import numbers_of
from ..free_runs.units import Lane, names_of_units, whole_unit
from ..result import Trace
from .group_fits import (
    SHORT,
    Errors,
    GroupSteps,
    columns_of_states,
    errors_of,
    fit_groups,
    root_mean_squares,
    whole_and_parts,
)
from .result import Ingredient, NextRun, Remaining

if TYPE_CHECKING:
    from ...estimation.selection.minimiser import Point
    from ...estimation.selection.number import Number
    from ...models.coefficient_groups import Group
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns
    from .group_fits import GroupFit, WholeRecords


def left_out_traces(plain: FreeRuns, explained: FreeRuns, final: GroupFit) -> tuple[Trace, ...]:
    """Training records; the run after the calibration is by the fit that left the record out, with what known causes
    explain in `explained`, and told as the record's own sensors would show it."""
    names = names_of_units(plain.units)
    return tuple(_trace(plain, explained, k, names[k], values) for k, values in enumerate(final.fitted.without))


def _trace(plain: FreeRuns, explained: FreeRuns, k: int, name: str, values: Mapping[str, float]) -> Trace:
    series, columns = plain.units[k].stretch.series, columns_of_states(plain)
    measured = plain.measured[k][:, : len(columns)]
    before = measured - blind_error(plain, k, {})
    after = measured - blind_error(explained, k, values)
    time = series.dt * (series.index + series.part)
    sides = [dict(zip(columns, part.T, strict=True)) for part in (measured, before, after)]
    return Trace(name, "train", time, series.observe(series.inputs[:, 0]), *sides)


def blind_error(runs: FreeRuns, k: int, values: Mapping[str, float]) -> np.ndarray:
    """Errors (N, S) of the states of a unit at values of the numbers, without own effects; 0 where nothing is
    measured."""
    error = runs.errors([Lane(k, values, runs.no_own[k])])[0][: len(runs.symbols), 0]
    return error.T


STANDS_OUT = 1.5
"""Share of the error over share of the time from which a condition is told."""
MOST_OF_IT = 0.3
"""Share of the error from which a condition is told."""


def remaining(runs: FreeRuns, final: GroupFit) -> tuple[Remaining, ...]:
    """Conditions that hold more of a channel's squared error than of the time, the most telling first."""
    each = [blind_error(runs, k, values) ** 2 for k, values in enumerate(final.fitted.without)]
    squares, conditions = np.concatenate(each), [_conditions(runs, k) for k in range(len(runs.units))]
    out = []
    for column, square in zip(columns_of_states(runs), squares.T, strict=True):
        for name in conditions[0]:
            chosen = np.concatenate([part[name] for part in conditions])
            share, time = float(square[chosen].sum() / max(square.sum(), 1e-300)), float(chosen.mean())
            if time > 0.0 and share > max(STANDS_OUT * time, MOST_OF_IT):
                out.append(Remaining(column, name, share, time))
    return tuple(sorted(out, key=lambda entry: entry.share_of_time - entry.share_of_error))


def _conditions(runs: FreeRuns, k: int) -> dict[str, np.ndarray]:
    """Condition -> where it holds (N,)."""
    own = dict(zip(runs.symbols, runs.measured[k].T, strict=False))
    series = runs.units[k].stretch.series
    out = {"rudder angles above 15 deg": np.abs(series.observe(series.inputs[:, 0])) > np.deg2rad(15.0)}
    if "r" in own:
        out |= {"turns to starboard": own["r"] > 0.0, "turns to port": own["r"] < 0.0}
    if "u" in own and "v" in own:
        u, v = own["u"], own["v"]
        out |= {"drift angles above 5 deg": np.abs(np.arctan2(-v, u)) > np.deg2rad(5.0)}
        out |= {"speeds below 85 % of the approach speed": u < 0.85 * u[np.isfinite(u)][:1]}
    return out


FLOWS = {"measured current": (0, 1), "measured wind": (2, 3)}
"""Columns of each measured flow behind the model's own inputs (`series.with_weather`)."""
VARIES = 0.02
"""Standard deviation of the revolutions, as a share of their size, from which they are an ingredient."""
Inputs = Callable[[np.ndarray], np.ndarray]


def ingredients(on: WholeRecords, before: Errors, final: GroupFit) -> tuple[Ingredient, ...]:
    """What every measured input, and the numbers that moved, remove of the squared error: that of held-out records,
    of left-out training records where none are held out.

    Eq. 7 of docs/mathematics/calibration.md.

    before : errors of the base model.
    """
    whole = _squared(errors_of(on, final))
    out = []
    for what, change in _without(on):
        changed = on.with_inputs(change)
        with suppress(np.linalg.LinAlgError):
            trial = fit_groups(changed.train, final.groups, final.fitted, steps=SHORT)
            out.append(Ingredient(what, _removed(whole, _squared(errors_of(changed, trial)))))
    if final.groups:
        out.append(Ingredient("numbers that moved", _removed(whole, _squared(before))))
    return tuple(out)


def floor(on: WholeRecords, final: GroupFit, groups: Sequence[Group]) -> dict[str, float]:
    """Column -> root mean square error of the held-out records by the fit of all numbers, and of every record's own
    neutral rudder angle and start, to these records; nothing where none are held out."""
    runs = on.held_out
    if runs is None:
        return {}
    fitted = fit_groups(runs, [*final.groups, *groups], None, final.fitted.point.values, SHORT).fitted
    return root_mean_squares(runs, fitted.point.squares)


def _squared(errors: Errors) -> dict[str, float]:
    return {column: (own if held is None else held) ** 2 for column, (own, held) in errors.items()}


def _removed(whole: Mapping[str, float], without: Mapping[str, float]) -> dict[str, float]:
    return {column: 1.0 - whole[column] / value for column, value in without.items() if value > 0.0}


def _without(on: WholeRecords) -> Iterator[tuple[str, Inputs]]:
    """Every measured input that varies, and what takes it, or its variation, out of the inputs of a run."""
    own, inputs = len(on.train.model.inputs), [unit.stretch.series.inputs for unit in on.train.units]
    for what, columns in FLOWS.items():
        places = [own + c for c in columns]
        if any(u.shape[1] > own and np.any(u[:, places]) for u in inputs):
            yield what, _constant(places, lambda values: np.zeros(values.shape[1]))
            yield f"variation of the {what}", _constant(places, lambda values: values.mean(axis=0))
    if "n" in on.train.model.inputs:
        places = [on.train.model.inputs.index("n")]
        if any(_varies(u[:, places]) for u in inputs):
            yield "variation of the revolutions", _constant(places, lambda values: values[0])


def _varies(values: np.ndarray) -> bool:
    return bool(np.std(values) > VARIES * np.abs(values).mean())


def _constant(places: Sequence[int], to: Callable[[np.ndarray], np.ndarray]) -> Inputs:
    """What puts columns of inputs at a constant."""

    def changed(inputs: np.ndarray) -> np.ndarray:
        out = inputs.copy()
        if inputs.shape[1] > max(places):
            out[:, places] = to(inputs[:, places])
        return out

    return changed


CANDIDATES = {
    "zigzag:10/10": "a 10/10 zigzag",
    "zigzag:20/20": "a 20/20 zigzag",
    "zigzag:35/5": "a 35/5 zigzag",
    "turn:20": "a turning circle with 20 deg of rudder to starboard",
    "turn:35": "a turning circle with 35 deg of rudder to starboard",
    "turn:35:port": "a turning circle with 35 deg of rudder to port",
    "straight": "a straight run",
}
"""Manoeuvres that are compared, and their words."""
DURATION, STEP = 20.0, 0.03
"""Length and step of a candidate run, in ship lengths sailed."""
SHOWN = 3


def next_runs(extended: Model, runs: FreeRuns, selection: GroupSteps, groups: Sequence[Group]) -> tuple[NextRun, ...]:
    """The candidates that add most information (`estimation.information.design`) on the numbers that moved, and that
    were tied.

    extended : makes the candidates.  runs : of the training records.
    """
    open_ids = {g.id for g in selection.final.groups} | {tied for s in selection.steps for tied in s.tied_with}
    chosen = [g for i, g in whole_and_parts(groups).items() if i in open_ids]
    numbers, point = distinct(n for g in chosen for n in numbers_of(g, runs.bank.values)), selection.final.fitted.point
    now = _information(runs, point, point.own, numbers) + np.eye(len(numbers))
    unmeasured = {CHANNELS[symbol]: None for symbol in MEASURED if symbol not in runs.symbols}
    out = []
    for text in CANDIDATES:
        duration_s, dt_s = DURATION * runs.length_s, STEP * runs.length_s
        record = record_run(extended, parse_manoeuvre(text), duration_s=duration_s, dt_s=dt_s)
        record = record.with_channels(**unmeasured)
        one = runs.along([whole_unit(runs.bank.model, record, runs.length_s)])
        out.append(NextRun(text, information_gain(now, _information(one, point, one.no_own, numbers))))
    return tuple(sorted(out, key=lambda run: -run.information)[:SHOWN])


def _information(runs: FreeRuns, point: Point, own: np.ndarray, numbers: Sequence[Number]) -> np.ndarray:
    """Information (p, p) on numbers in units of their prior standard deviations, at the error sizes of a point."""
    size = point.size[: len(runs.channels)]
    normal = runs.quadratic(point.values, own, numbers).normal(size)
    scale = np.array([n.sd for n in numbers])
    return normal.matrix.sum(axis=0) * np.outer(scale, scale)
