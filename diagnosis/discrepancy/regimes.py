"""Numbers of the base model that are wrong in a part of the runs only, by the likelihood of the innovations.

Every number of the family, times the indicator of a regime (rudder, yaw rate, drift or speed beyond a threshold, turns
to one side, late in a record), is one more column of the likelihood's derivatives: no run is made.  Sets with one such
column compete with sets of numbers that are wrong everywhere; each column has its price.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.statistics.tails import chi2_quantile
from ...estimation.filters.innovations.derivatives import gated
from ...models.coefficient_groups import LocalNumber, local_numbers
from ...models.regimes import Regime, regime, values_of

if TYPE_CHECKING:
    from .fit import Fitted
    from .projection import Profile, Projection
    from .subsets import Subset

QUANTILES, ANGLES = (0.25, 0.45, 0.65, 0.8, 0.92), (0.25, 0.4, 0.5, 0.6, 0.7, 0.85)
"""Shares of the samples, and of the largest rudder angle, which dwells at few values, where thresholds are screened."""
FINE, FINER = 24, 12
"""Thresholds of the profile of a leading regime: over the range of its variable, and about the best."""
PRICE, LOCAL = 6.0, 14.0 / 6.0
"""Nats, times the inflation, that a number costs, and prices of a number in a regime: what the best of all gains by
chance."""
NEGLIGIBLE = 0.002
"""Share of the largest gain that a number costs at least: to it the quadratic is not exact."""
LEADERS, MOST = 8, 4
"""Columns that are looked at with numbers beside them, and how many of these at most."""
PROPOSED = 3
OFFSET = "rudder_offset"
LEVEL, CERTAIN = 0.1, 0.01
"""Probabilities that an interval of a threshold leaves out, and below which records differ."""


@dataclass(frozen=True)
class Local:
    """A number that is wrong in a regime only.

    low, high : 90 % interval of the threshold.  size, sd : its change, and the standard deviation of that.
    beside : numbers that are wrong everywhere, beside it.
    lead : by how much the log likelihood with it, less the price of its columns, is above that of the best set without
    a regime; nats.  alike : whether all records say the same of it, so that this counts.
    """

    number: LocalNumber
    regime: Regime
    low: float
    high: float
    size: float
    sd: float
    beside: tuple[str, ...]
    lead: float
    alike: bool


class _Column(NamedTuple):
    """A number in a regime (None: everywhere): products with the numbers (m,), with itself, and its slope, all else
    maximised over."""

    number: LocalNumber
    regime: Regime | None
    cross: np.ndarray
    square: float
    slope: float

    @property
    def gain(self) -> float:
        """Rise of the log likelihood by it alone."""
        return 0.5 * self.slope**2 / max(self.square, 1e-12)


class _Trial(NamedTuple):
    """A column, places of the numbers beside it, and the log likelihood less the prices."""

    column: _Column
    beside: tuple[int, ...]
    worth: float

    @property
    def place(self) -> tuple[str, str]:
        """Number and variable."""
        return self.column.number.name, "" if self.column.regime is None else self.column.regime.variable


def local_errors(final: Fitted, projection: Projection, subsets: Sequence[Subset]) -> tuple[Local, ...]:
    """Numbers in regimes that explain more than any set of numbers without one, the best first.

    Eqs. 35, 36 of docs/mathematics/default-route.md.
    """
    held = len(final.base.terms.parameters)
    for j, p in enumerate(final.variant):
        if p.record is None and p.slots == ((final.base.est.index[OFFSET], 1.0),):  # the hull's own, or to one side
            projection = projection.with_number(held + j, OFFSET)
    profile, values = projection.profile, _values(final)
    numbers = [n for n in local_numbers(final.base.est.model) if n.change.keys() <= final.base.est.index.keys()]
    found = list(_columns(final, projection, numbers, list(_screened(values)), values))
    fit = _Screen(final, projection, values)
    refined = [fit.refined(c) for c in _leaders(found)]
    most = max([profile.gain(range(len(profile.names))), *(c.gain for c in refined)])
    price = max(PRICE * profile.inflation, NEGLIGIBLE * most)
    without = _worth_without(profile, subsets, [c.gain for c in found if c.regime is None], price)
    trials = sorted((_with_others(profile, c, price) for c in refined), key=lambda t: -t.worth)
    leading = [t for i, t in enumerate(trials) if t.worth > without and not _turned(t, trials[:i], profile.names)]
    return tuple(fit.profiled(t, without) for t in leading[:PROPOSED])


def _turned(trial: _Trial, better: Sequence[_Trial], names: Sequence[str]) -> bool:
    """Whether a better trial says the same: a number everywhere, but not in the regime, is one in the opposite
    regime."""
    own = trial.column.number.name
    return own in {names[j] for j in trial.beside} and any(t.place == trial.place for t in better)


def _leaders(found: Sequence[_Column]) -> list[_Column]:
    """The best column of each number, variable and side, of those the best."""
    first: dict[tuple[str, str, str], _Column] = {}
    for column in sorted((c for c in found if c.regime is not None), key=lambda c: -c.gain):
        assert column.regime is not None
        first.setdefault((column.number.name, column.regime.variable, column.regime.side), column)
    return list(first.values())[:LEADERS]


def _values(final: Fitted) -> Mapping[str, np.ndarray]:
    """Variables of regimes at all samples (N,)."""
    est = final.base.est
    names = list(est.kernels.STATES)
    states = {name: final.now.states[:, names.index(name)] for name in ("u", "v", "r") if name in names}
    return values_of(states, est.joined(lambda d: d.rudder), est.joined(lambda d: d.time))


def _screened(values: Mapping[str, np.ndarray]) -> Iterator[Regime]:
    """Each side, and beyond the thresholds of a grid."""
    for side in ("port", "starboard"):
        yield regime("side", side, 0.0, float(np.sqrt(np.mean(values["side"] ** 2))))
    for name in (n for n in values if n != "side"):
        for threshold in _grid(name, values[name]):
            yield regime(name, "above", threshold)


def _grid(variable: str, x: np.ndarray) -> list[float]:
    """Thresholds of the screen."""
    grid = float(np.max(x)) * np.array(ANGLES) if variable == "rudder" else np.unique(np.quantile(x, QUANTILES))
    return grid[grid > 0.0].tolist()


def _columns(
    final: Fitted, projection: Projection, numbers: Sequence[LocalNumber], regimes: Sequence[Regime],
    values: Mapping[str, np.ndarray],
) -> Iterator[_Column]:  # fmt: skip
    """Every number everywhere, in every regime, and below every threshold: what is everywhere less what is above."""
    gates = [np.ones(final.base.est.edges[-1]), *(r.inside(values[r.variable]) for r in regimes)]
    rows = gated(final.base.est, final.setting, [n.change for n in numbers], gates)
    above = [j for j, r in enumerate(regimes) if r.side == "above"]
    every = [None, *regimes, *(replace(regimes[j], side="below") for j in above)]
    for number, more in zip(numbers, rows, strict=True):
        added = projection.added(np.vstack([more, more[0] - more[1:][above]]))
        for r, cross, square, slope in zip(
            every, added.cross, added.square.tolist(), added.slope.tolist(), strict=True
        ):
            yield _Column(number, r, cross, square, slope)


def _worth_without(profile: Profile, subsets: Sequence[Subset], alone: Sequence[float], price: float) -> float:
    """Log likelihood less the prices of the best set without a regime; alone : gains of single numbers."""
    every = len(profile.names)
    whole = profile.gain(range(every))
    sets = [(s.share * whole, len(s.names)) for s in subsets]
    return max(gain - price * size for gain, size in [(0.0, 0), (whole, every), (max(alone), 1), *sets])


def _with_others(profile: Profile, column: _Column, price: float) -> _Trial:
    """The column with the numbers beside it that are worth their price.

    Eq. 36 of docs/mathematics/default-route.md.
    """
    whole, own = profile.with_column(*column[2:]), len(profile.names)
    chosen, best = [own], _Trial(column, (), -np.inf)
    for size in range(min(MOST, own) + 1):
        worth = whole.gain(chosen) - (LOCAL + size) * price
        if worth > best.worth:
            best = best._replace(beside=tuple(chosen[1:]), worth=worth)
        chosen = [*chosen, whole.best_addition(chosen)] if size < own else chosen
    return best


@dataclass(frozen=True, eq=False)
class _Screen:
    """What thresholds of one number in one variable are compared by."""

    final: Fitted
    projection: Projection
    values: Mapping[str, np.ndarray]

    def columns(self, number: LocalNumber, like: Regime, grid: np.ndarray) -> list[_Column]:
        """The number at other thresholds."""
        regimes = [regime(like.variable, like.side, t) for t in grid.tolist()]
        gates = [r.inside(self.values[like.variable]) for r in regimes]
        (rows,) = gated(self.final.base.est, self.final.setting, [number.change], gates)
        added = self.projection.added(rows)
        parts = zip(regimes, added.cross, added.square.tolist(), added.slope.tolist(), strict=True)
        return [_Column(number, *part) for part in parts]

    def refined(self, column: _Column) -> _Column:
        """The best of the column and its neighbours between the thresholds of the screen."""
        own = column.regime
        if own is None or own.variable == "side":
            return column
        x = self.values[own.variable]
        grid = np.array([float(np.min(x)), *_grid(own.variable, x), float(np.max(x))])
        below, above = grid[grid < own.threshold], grid[grid > own.threshold]
        low, high = (side[pick] if side.size else own.threshold for side, pick in ((below, -1), (above, 0)))
        near = np.linspace(low, high, FINER + 2)[1:-1]
        return max([column, *self.columns(column.number, own, near)], key=lambda c: c.gain)

    def profiled(self, trial: _Trial, without: float) -> Local:
        """The threshold of largest likelihood, with the interval in which that is not significantly smaller."""
        profile, own = self.projection.profile, trial.column.regime
        assert own is not None
        best, low, high = trial.column, own.threshold, own.threshold
        if own.variable != "side":
            grid = self._around(own)
            columns = self.columns(trial.column.number, own, grid)
            gains = np.array([profile.with_column(*c[2:]).gain([*trial.beside, -1]) for c in columns])
            at = int(np.argmax(gains))
            inside = np.flatnonzero(2.0 * (gains[at] - gains) < profile.inflation * chi2_quantile(LEVEL, 1))
            best, low, high = columns[at], *grid[[max(inside[0] - 1, 0), min(inside[-1] + 1, grid.size - 1)]].tolist()
        assert best.regime is not None
        size, sd = profile.with_column(*best[2:]).last([*trial.beside, -1])
        names = tuple(profile.names[j] for j in trial.beside)
        alike = self._alike(trial)
        return Local(best.number, best.regime, low, high, size, sd, names, trial.worth - without, alike)

    def _alike(self, trial: _Trial) -> bool:
        """Whether records do not differ significantly in what they say of a column."""
        own, est = trial.column.regime, self.final.base.est
        assert own is not None
        gates = [own.inside(self.values[own.variable])]
        ((row,),) = gated(est, self.final.setting, [trial.column.number.change], gates)
        scatter, freedom = self.projection.scatter(row, trial.beside, est.owner), est.n_records - 1
        return freedom < 1 or freedom * scatter < chi2_quantile(CERTAIN, freedom)

    def _around(self, own: Regime) -> np.ndarray:
        """Thresholds over the range of the variable, closer about the regime's own."""
        x = self.values[own.variable]
        first, last = np.quantile(x, (0.02, 0.99)).tolist()
        grid = np.linspace(first, last, FINE)
        finer = own.threshold + (grid[1] - grid[0]) * np.linspace(-1.0, 1.0, FINER + 1)
        grid = np.unique(np.concatenate([grid, finer]))
        return grid[(grid > 0.0) & (grid < float(np.max(x)))]
