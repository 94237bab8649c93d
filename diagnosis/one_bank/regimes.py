"""A number that is wrong in a part of the runs only: beyond an angle, rate or speed, to one side, or after a time.

It competes with numbers that are wrong everywhere by the same criterion, and enters where left-out pieces are predicted
clearly better with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...estimation.selection.minimiser import minimise
from ...estimation.selection.number import Candidate, Number
from ...estimation.selection.score import fall
from ...estimation.selection.selection import (
    CLEAR,
    Entered,
    Rules,
    Selection,
    enters,
    fall_between,
    floor_squares,
    predictions,
    quantile,
    select,
)
from ...models.coefficient_groups import LocalNumber, local_numbers, names_of
from ...models.extend import extended
from ...models.families.extensions import OFFSET, RUDDER_FORCE, regime_parameters
from ...models.regimes import VARIABLES, Regime, regime, values_of
from ..free_runs.bank import Place
from .catalogue import HULL

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ...estimation.selection.minimiser import Fitted
    from ...models.model import Model
    from ..free_runs.problem import FreeRuns

QUANTILES, ANGLES = (0.25, 0.45, 0.65, 0.8, 0.92), (0.25, 0.4, 0.5, 0.6, 0.7, 0.85)
"""Shares of the samples, and of the largest rudder angle, which dwells at few values, where thresholds are screened."""
ONE_SIDED = (OFFSET, RUDDER_FORCE)
"""What may differ between turns to port and to starboard: a hull is alike to both sides."""
PROMISING = 0.6
"""Share of what the choice without a regime takes off the score that a number in one must be predicted to take off."""
AS_MUCH = 0.9
"""Share of what the choice without a regime takes off the score that a number in one has to take off alone, but for one
that differs between the sides: it was 1.1 to 2.8 of 28 true ones, .2 to .8 where nothing was wrong in a regime."""
LITTLE = 0.05
"""Fall of the score that is no matter between two thresholds."""
INSIDE, OUTSIDE = 0.05, 0.2
"""Shares of the samples that lie in a regime, and out of it, at least: a number that is wrong in nearly all is wrong
everywhere."""
LEADERS, FINE, FITTED, HALVINGS = 6, 9, 3, 2
"""Numbers in a variable whose thresholds are refined, thresholds between the neighbours of one, the kinds that are
fitted at their best one, and times that the steps about the best fit are halved."""


@dataclass(frozen=True)
class InRegime:
    """A number that is wrong in a regime only.

    low, high : thresholds between which left-out pieces are not predicted clearly worse.  size : name of the number of
    the fit that is its change there.
    """

    number: LocalNumber
    regime: Regime
    low: float
    high: float
    size: str

    @property
    def words(self) -> str:
        """Where it is, in words."""
        return self.regime.told(self.low, self.high)

    @property
    def facts(self) -> dict[str, Any]:
        """What is wrong and where, as results state it."""
        own, where = self.number, self.regime
        return {
            "number": own.name, "group": own.group, "variable": where.variable, "side": where.side,
            "threshold": where.threshold, "low": self.low, "high": self.high, "unit": VARIABLES[where.variable],
        }  # fmt: skip

    def extended(self, model: Model, size: float) -> Model:
        """The model with the number changed by `size` in the regime."""
        where = self.regime
        name = f"regime_{self.number.name}_{where.variable}_{where.side}"
        numbers = (size, where.threshold, where.width)
        return extended(model, name, dict(zip(regime_parameters(name), numbers, strict=True)))


class _Column(NamedTuple):
    """A number in a regime, as a candidate."""

    number: LocalNumber
    regime: Regime
    candidate: Candidate

    @property
    def kind(self) -> tuple[str, str, str]:
        """Number, variable and side."""
        return self.number.name, self.regime.variable, self.regime.side


def in_regime(
    runs: FreeRuns,
    selection: Selection,
    bank: Sequence[Candidate],
    rules: Rules,
    clear: float,
    promising: float,
) -> tuple[FreeRuns, Selection, InRegime] | None:
    """The runs, selection and number where a number in a regime, in the place of all that entered, predicts left-out
    pieces clearly better with what enters beside it; None where none does.

    bank, rules : what may enter beside it.  clear : level from which pieces are predicted clearly better.
    promising : share of what the choice takes off the score that a number in a regime must be predicted to take off.
    Eqs. 11, 12 of docs/mathematics/pieces.md.
    """
    base = selection.base
    values = _values(runs, base)
    columns = list(_columns(runs.bank.model, values))
    if not columns:
        return None
    runs = runs.with_numbers(_places(runs.bank.model, columns), {})
    best = _best(runs, base, columns, values, fall_between(runs, base, selection.final).gain, promising)
    if best is None:
        return None
    runs, column, fitted, low, high = best
    alone = fall_between(runs, base, fitted)
    if not enters(runs, rules, fitted, alone):
        return None
    own = column.candidate.numbers
    names = {n.name for n in own}
    others = [c for c in bank if not names & {*c.names}]
    rest = select(runs, others, rules, fitted, own)
    between, fewer = fall_between(runs, selection.final, rest.final), 1 + len(rest.entered) < len(selection.entered)
    if between.gain <= max(rules.least, (CLEAR if fewer else quantile(runs, clear)) * between.error):
        return None
    entered = Entered(column.candidate, alone)
    whole = Selection(selection.base, (entered, *rest.entered), rest.final)
    return runs, whole, InRegime(column.number, column.regime, low, high, own[0].name)


# ---- candidates
def _columns(model: Model, values: Mapping[str, np.ndarray]) -> Iterator[_Column]:
    """Every number to each side, and beyond the thresholds of a grid."""
    known = {*names_of(model)}
    numbers = [n for n in local_numbers(model) if {*n.change} <= known]
    for where in _screened(values):
        if _splits(where, values[where.variable]):
            yield from (_column(n, where) for n in numbers if where.variable != "side" or n.name in ONE_SIDED)


def _splits(where: Regime, x: np.ndarray) -> bool:
    """Whether enough of the samples (N,) of a variable lie in a regime, and out of it."""
    return INSIDE < float(np.mean(where.inside(x))) < 1.0 - OUTSIDE


def _screened(values: Mapping[str, np.ndarray]) -> Iterator[Regime]:
    for side in ("port", "starboard"):
        yield regime("side", side, 0.0, float(np.sqrt(np.mean(values["side"] ** 2))))
    for name in (n for n in values if n != "side"):
        for threshold in _grid(name, values[name]):
            yield regime(name, "above", threshold)


def _grid(variable: str, x: np.ndarray) -> list[float]:
    """Thresholds of the screen."""
    grid = float(np.max(x)) * np.array(ANGLES) if variable == "rudder" else np.unique(np.quantile(x, QUANTILES))
    return grid[grid > 0.0].tolist()


def _column(number: LocalNumber, where: Regime) -> _Column:
    name = f"{number.name} {where.variable} {where.side} {where.threshold:.9g}"
    return _Column(number, where, Candidate(name, (Number(name, number.sd),), HULL, of=number.group))


def _places(model: Model, columns: Sequence[_Column]) -> dict[str, Place]:
    return {c.candidate.id: place_in(model, c.number, c.regime) for c in columns}


def place_in(model: Model, number: LocalNumber, where: Regime) -> Place:
    """What a number in a regime moves."""
    names = names_of(model)
    return Place("regime", inside=tuple((names.index(n), x) for n, x in number.change.items()), regime=where)


def _values(runs: FreeRuns, fitted: Fitted) -> dict[str, np.ndarray]:
    """Variables of regimes at all samples (N,) of the runs of a fit."""
    states, names = runs.states_of(fitted.point), list(runs.bank.model.states)
    joined, unknown = np.concatenate(states), {"u", "v"} - {*runs.symbols}
    motion = {name: joined[:, names.index(name)] for name in ("u", "v", "r") if name in names and name not in unknown}
    rudder = np.concatenate([u.stretch.series.inputs[:, 0] for u in runs.units])
    time_s = np.concatenate([u.grid_s - u.record.time_s[0] for u in runs.units])
    return values_of(motion, rudder, time_s)


# ---- the best one
def _best(
    runs: FreeRuns,
    base: Fitted,
    columns: Sequence[_Column],
    values: Mapping[str, np.ndarray],
    without: float,
    promising: float,
) -> tuple[FreeRuns, _Column, Fitted, float, float] | None:
    """The column whose fit predicts left-out pieces best, its threshold refined, with an interval of that; None where
    none promises enough or takes off as much as the choice.

    without : fall of the score by the choice without a regime.
    """
    first = _screened_columns(runs, base, columns)
    if not first or fall(base.left_out, first[0][1], floor_squares(runs)).gain <= promising * without:
        return None
    leaders = _first_of_each(first)[:LEADERS]
    fine = [_column(c.number, where) for c in leaders for where in _between(c.regime, values[c.regime.variable])]
    runs = runs.with_numbers(_places(runs.bank.model, fine), {})
    refined = _screened_columns(runs, base, fine)
    trials = [(c, fit) for c in _first_of_each(refined)[:FITTED] if (fit := _fitted(runs, base, c)) is not None]
    if not trials:
        return None
    column, fitted = max(trials, key=lambda t: fall_between(runs, base, t[1]).gain)
    if column.regime.variable != "side" and fall_between(runs, base, fitted).gain < AS_MUCH * without:
        return None
    return _best_threshold(runs, base, [c for c, _ in refined if c.kind == column.kind], column)


def _best_threshold(
    runs: FreeRuns, base: Fitted, columns: Sequence[_Column], first: _Column
) -> tuple[FreeRuns, _Column, Fitted, float, float] | None:
    """The best of the fits of one kind at all thresholds, and of those that halve the steps beside it."""
    fits = {c.regime.threshold: (c, fit) for c in columns if (fit := _fitted(runs, base, c)) is not None}

    def best() -> float:
        return max(fits, key=lambda t: fall_between(runs, base, fits[t][1]).gain)

    for _ in range(HALVINGS if first.regime.variable != "side" else 0):
        own = sorted(fits)
        at = own.index(best())
        neighbours = [own[i] for i in (at - 1, at + 1) if 0 <= i < len(own)]
        middles = [0.5 * (own[at] + t) for t in neighbours]
        halves = [_column(first.number, regime(first.regime.variable, first.regime.side, t)) for t in middles]
        runs = runs.with_numbers(_places(runs.bank.model, halves), {})
        fits |= {c.regime.threshold: (c, fit) for c in halves if (fit := _fitted(runs, base, c)) is not None}
    column, fitted = fits[best()]
    return runs, column, fitted, *_interval(runs, column, [(c, fit.left_out) for c, fit in fits.values()])


def _screened_columns(runs: FreeRuns, base: Fitted, columns: Sequence[_Column]) -> list[tuple[_Column, np.ndarray]]:
    """Columns with the squares (K, C) of left-out pieces that are predicted with them, the best first."""
    by_name = {c.candidate.id: c for c in columns}
    predicted = predictions(runs, [c.candidate for c in columns], base)
    return [(by_name[one.candidate.id], one.left_out) for one in predicted]


def _first_of_each(columns: Sequence[tuple[_Column, np.ndarray]]) -> list[_Column]:
    """The first column of each kind."""
    first: dict[tuple[str, str, str], _Column] = {}
    for column, _ in columns:
        first.setdefault(column.kind, column)
    return list(first.values())


def _between(where: Regime, x: np.ndarray) -> list[Regime]:
    """The regime with thresholds up to its neighbours in the screen."""
    if where.variable == "side":
        return [where]
    grid = np.unique([float(np.min(x)), *_grid(where.variable, x), float(np.max(x))])
    at = int(np.argmin(np.abs(grid - where.threshold)))
    ends = grid[max(at - 1, 0)], grid[min(at + 1, grid.size - 1)]
    fine = {where.threshold, *np.linspace(*ends, FINE + 2)[1:-1].tolist()}
    every = [regime(where.variable, where.side, t) for t in sorted(fine) if t > 0.0]
    return [one for one in every if one.threshold == where.threshold or _splits(one, x)]


def _interval(runs: FreeRuns, column: _Column, profile: Sequence[tuple[_Column, np.ndarray]]) -> tuple[float, float]:
    """Thresholds just outside those with which left-out pieces are not predicted clearly worse."""
    every = sorted(((c.regime.threshold, left) for c, left in profile), key=lambda pair: pair[0])
    own = next(left for c, left in profile if c is column)
    floor = floor_squares(runs)
    falls = [fall(left, own, floor) for _, left in every]
    alike = [i for i, one in enumerate(falls) if one.gain <= max(one.error, LITTLE)]
    return every[max(alike[0] - 1, 0)][0], every[min(alike[-1] + 1, len(every) - 1)][0]


def _fitted(runs: FreeRuns, base: Fitted, column: _Column) -> Fitted | None:
    try:
        return minimise(runs, column.candidate.numbers, base.point.values, base.point.own)
    except np.linalg.LinAlgError:
        return None
