"""What a calibration tells beside its numbers: what the prediction owes to each of its ingredients, the error that
stays whatever the numbers are, and which manoeuvre would tell most about the numbers that the records leave open.

An ingredient is left out, all numbers are fitted again, and the squared error that comes back is what it removes.  The
floor is the error of held-out records that the model is fitted to themselves: what stays there no change of its numbers
takes off, so that an error at the floor is the structure's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.generator import record_run
from ...datasets.manoeuvres import parse_manoeuvre
from ...estimation.information.design import information_gain
from ...estimation.records.series import MEASURED
from ...estimation.selection.minimiser import minimise
from ...estimation.selection.number import distinct
from ...estimation.selection.selection import mean_squares
from ...models.model import CHANNELS
from ..free_runs.problem import FreeRuns
from ..free_runs.units import whole_unit
from .result import Ingredient, NextRun

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.minimiser import Point
    from ...estimation.selection.number import Number
    from ...models.model import Model
    from ..one_bank.search import Choice

SHORT = 4
"""Gauss-Newton steps of a fit that only compares."""
FLOWS = {"measured current": (0, 1), "measured wind": (2, 3)}
"""Columns of each measured flow behind the model's own inputs (`series.with_weather`)."""
VARIES = 0.02
"""Standard deviation of the revolutions, as a share of their size, from which they are an ingredient."""
Inputs = Callable[[np.ndarray], np.ndarray]


def ingredients(choice: Choice) -> tuple[Ingredient, ...]:
    """What every measured input, and what was chosen, remove of the squared error of left-out pieces.

    Eq. 4 of docs/mathematics/calibration.md.
    """
    runs, final = choice.runs, choice.selection.final
    whole = mean_squares(runs, final.left_out)

    def removes(squares: np.ndarray) -> dict[str, float]:
        each = zip(runs.channels, whole.tolist(), mean_squares(runs, squares).tolist(), strict=True)
        return {column: 1.0 - own / without for column, own, without in each if without > 0.0}

    out = []
    for what, change in _without(runs):
        with suppress(np.linalg.LinAlgError):
            trial = minimise(_changed(runs, change), final.numbers, final.point.values, final.point.own, SHORT)
            out.append(Ingredient(what, removes(trial.left_out)))
    if final.numbers:
        out.append(Ingredient("numbers that moved", removes(choice.selection.base.left_out)))
    return tuple(out)


def floor(choice: Choice, held_out: Sequence[Record]) -> dict[str, float]:
    """Column -> root mean square error of the held-out records by the fit of all of the model's numbers, and of every
    record's own neutral rudder angle and start, to these records; nothing where none are held out.

    held_out : behind their sensors.
    """
    bank, length_s, final = choice.bank, choice.runs.length_s, choice.selection.final
    if not held_out:
        return {}
    units = [replace(whole_unit(bank.model, r, length_s), number=i) for i, r in enumerate(held_out)]
    runs = FreeRuns(bank, units, length_s, whole=True)
    values = {name: x for name, x in final.point.values.items() if bank.places[name].record is None}
    numbers = distinct((*bank.own, *(n for n in final.numbers if n.name in values)))
    fitted = minimise(runs, numbers, values, runs.no_own, SHORT)
    return dict(zip(runs.channels, np.sqrt(mean_squares(runs, fitted.point.squares)).tolist(), strict=True))


def _without(runs: FreeRuns) -> Iterator[tuple[str, Inputs]]:
    """Every measured input that varies, and what takes it, or its variation, out of the inputs of a run."""
    own, inputs = len(runs.model.inputs), [unit.stretch.series.inputs for unit in runs.units]
    for what, columns in FLOWS.items():
        places = [own + c for c in columns]
        if any(u.shape[1] > own and np.any(u[:, places]) for u in inputs):
            yield what, _constant(places, lambda values: np.zeros(values.shape[1]))
            yield f"variation of the {what}", _constant(places, lambda values: values.mean(axis=0))
    if "n" in runs.model.inputs:
        places = [runs.model.inputs.index("n")]
        if any(np.std(u[:, places]) > VARIES * np.abs(u[:, places]).mean() for u in inputs):
            yield "variation of the revolutions", _constant(places, lambda values: values[0])


def _constant(places: Sequence[int], to: Callable[[np.ndarray], np.ndarray]) -> Inputs:
    """What puts columns of inputs at a constant."""

    def changed(inputs: np.ndarray) -> np.ndarray:
        out = inputs.copy()
        if inputs.shape[1] > max(places):
            out[:, places] = to(inputs[:, places])
        return out

    return changed


def _changed(runs: FreeRuns, change: Inputs) -> FreeRuns:
    """The same with the inputs (M + 1, nu) of every run changed."""
    stretches = [u.stretch for u in runs.units]
    series = [replace(s.series, inputs=change(s.series.inputs)) for s in stretches]
    parts = zip(runs.units, stretches, series, strict=True)
    return runs.along([replace(u, stretch=replace(s, series=own)) for u, s, own in parts])


CANDIDATES = (
    *("zigzag:10/10", "zigzag:20/20", "zigzag:35/5"),
    *("turn:20", "turn:35", "turn:35:port", "straight"),
)
"""Manoeuvres that are compared."""
DURATION, STEP = 20.0, 0.03
"""Length and step of a candidate run, in ship lengths sailed."""
SHOWN = 3


def next_runs(extended: Model, choice: Choice) -> tuple[NextRun, ...]:
    """The manoeuvres that add most information (`estimation.information.design`) on the numbers of the model that
    moved, and that were tied; none where there are none.

    extended : makes the runs, without instruments of the records.
    """
    runs, selection = choice.runs, choice.selection
    tied = (n for one in selection.entered for c in one.tied_with for n in c.numbers)
    every = distinct((*selection.final.numbers, *tied))
    numbers = [n for n in every if choice.bank.places[n.name].kind == "model"]
    if not numbers:
        return ()
    point = selection.final.point
    now = _information(runs, point, point.own, numbers) + np.eye(len(numbers))
    unmeasured = {CHANNELS[symbol]: None for symbol in MEASURED if symbol not in runs.symbols}
    out = []
    for text in CANDIDATES:
        duration_s, dt_s = DURATION * runs.length_s, STEP * runs.length_s
        record = record_run(extended, parse_manoeuvre(text), duration_s=duration_s, dt_s=dt_s)
        one = runs.along([whole_unit(runs.bank.model, record.with_channels(**unmeasured), runs.length_s)])
        out.append(NextRun(text, information_gain(now, _information(one, point, one.no_own, numbers))))
    return tuple(sorted(out, key=lambda run: -run.information)[:SHOWN])


def _information(runs: FreeRuns, point: Point, own: np.ndarray, numbers: Sequence[Number]) -> np.ndarray:
    """Information (p, p) on numbers in units of their prior standard deviations, at the error sizes of a point."""
    size = point.size[: len(runs.channels)]
    normal = runs.quadratic(point.values, own, numbers).normal(size)
    scale = np.array([n.sd for n in numbers])
    return normal.matrix.sum(axis=0) * np.outer(scale, scale)
