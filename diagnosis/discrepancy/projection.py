"""The likelihood as a function of the base model's numbers alone: everything else is maximised over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.noise_fit import CLIP
from ...estimation.filters.innovations.settings import Parameter
from ...models.coefficient_groups import stated_groups
from .quadratic import inflation, mode, quadratic
from .terms import NUMBERS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from .fit import Fitted


@dataclass(frozen=True)
class Profile:
    """Log likelihood of the numbers (m,) to second order, maximised over all else: matrix (m, m), slope (m,).

    inflation : how much more than the likelihood says the numbers scatter.  values : how many measured values count.
    """

    names: tuple[str, ...]
    matrix: np.ndarray
    slope: np.ndarray
    inflation: float
    values: int

    def gain(self, chosen: Sequence[int]) -> float:
        """Rise of the log likelihood by numbers of these places (eq. 19 of docs/mathematics/default-route.md)."""
        if not len(chosen):
            return 0.0
        pick = np.asarray(chosen)
        return 0.5 * float(self.slope[pick] @ np.linalg.solve(self.matrix[np.ix_(pick, pick)], self.slope[pick]))

    def best(self, size: int) -> list[int]:
        """The set of a size with the largest gain, of all sets."""
        sets = np.array(list(combinations(range(len(self.names)), size)))
        matrix, slope = self.matrix[sets[:, :, None], sets[:, None, :]], self.slope[sets]
        gains = np.einsum("ki,ki->k", slope, np.linalg.solve(matrix, slope[:, :, None])[:, :, 0])
        return sets[int(np.argmax(gains))].tolist()

    def without(self, chosen: Sequence[int], i: int) -> list[tuple[float, int]]:
        """Gain with each other number in the place of the i-th, the best first."""
        rest = [j for k, j in enumerate(chosen) if k != i]
        others = [j for j in range(len(self.names)) if j not in rest]
        return sorted(((self.gain([*rest, j]), j) for j in others), reverse=True)

    def best_addition(self, chosen: Sequence[int]) -> int:
        """The number that adds most to a set."""
        others = [j for j in range(len(self.names)) if j not in chosen]
        return max(others, key=lambda j: self.gain([*chosen, j]))

    def last(self, chosen: Sequence[int]) -> tuple[float, float]:
        """Value and standard deviation of the last number of a set."""
        pick = np.asarray(chosen)
        inverse = np.linalg.inv(self.matrix[np.ix_(pick, pick)])
        return float(inverse[-1] @ self.slope[pick]), float(np.sqrt(self.inflation * inverse[-1, -1]))

    def with_column(self, cross: np.ndarray, square: float, slope: float) -> Profile:
        """The same with one more column, the last (see `Projection.added`)."""
        matrix = np.block([[self.matrix, cross[:, None]], [cross[None, :], np.array([[square]])]])
        return replace(self, names=(*self.names, ""), matrix=matrix, slope=np.append(self.slope, slope))


class Added(NamedTuple):
    """Further columns (g): products with the numbers (g, m), with themselves (g,), and slopes (g,)."""

    cross: np.ndarray
    square: np.ndarray
    slope: np.ndarray


@dataclass(frozen=True, eq=False)
class Projection:
    """The likelihood in all parameters (M,): derivatives of the innovations (M, N*6), matrix and slope, and the
    innovations at zero parameters with negative sign (N*6,).

    precision (M,) : of the priors of what is maximised over.  names : of parameters that count as numbers.
    """

    rows: np.ndarray
    whole: np.ndarray
    pull: np.ndarray
    target: np.ndarray
    precision: np.ndarray
    names: dict[int, str]
    beside: np.ndarray
    inflation: float
    values: int

    @property
    def numbers(self) -> np.ndarray:
        """Places of the numbers."""
        return np.array([*self.names], int)

    @cached_property
    def inner(self) -> np.ndarray:
        """Matrix of what is maximised over, priors included."""
        return self.whole[np.ix_(self.beside, self.beside)] + np.diag(self.precision[self.beside])

    @cached_property
    def profile(self) -> Profile:
        """The numbers' own likelihood (eq. 18 of docs/mathematics/default-route.md)."""
        beside, numbers = self.beside, self.numbers
        across = self.whole[np.ix_(beside, numbers)]
        follow = np.linalg.solve(self.inner, np.column_stack([across, self.pull[beside]]))
        matrix = self.whole[np.ix_(numbers, numbers)] - across.T @ follow[:, :-1]
        slope = self.pull[numbers] - across.T @ follow[:, -1]
        ridge = 1e-9 * np.diag(np.maximum(np.diag(matrix), 1e-9))
        return Profile(tuple(self.names.values()), matrix + ridge, slope, self.inflation, self.values)

    @cached_property
    def _against(self) -> tuple[np.ndarray, np.ndarray]:
        """What further columns are multiplied with: rows of numbers, of what is maximised over, and the target; and
        the first and the last solved for what is maximised over."""
        beside, numbers = self.beside, self.numbers
        known = np.column_stack([self.whole[np.ix_(beside, numbers)], self.pull[beside]])
        return np.vstack([self.rows[[*numbers, *beside]], self.target]).T, np.linalg.solve(self.inner, known)

    def added(self, more: np.ndarray) -> Added:
        """Products of further columns more (g, N*6), all else maximised over."""
        against, follow = self._against
        products, m = more @ against, self.numbers.size
        own = products[:, m:-1]
        square = np.einsum("ij,ij->i", more, more) - np.einsum("ij,ji->i", own, np.linalg.solve(self.inner, own.T))
        return Added(products[:, :m] - own @ follow[:, :-1], square, products[:, -1] - own @ follow[:, -1])

    def scatter(self, column: np.ndarray, numbers: Sequence[int], owner: np.ndarray) -> float:
        """How much more than the likelihood says a column (N*6,) with numbers beside it scatters between records.

        Eq. 11 of docs/mathematics/default-route.md, by records.

        owner : (N,) record of each sample.
        """
        places = np.concatenate([self.beside, self.numbers[list(numbers)]])
        rows, precision = self.rows[places], np.diag(self.precision[places])
        known = np.column_stack([rows @ column, self.pull[places]])
        follow = np.linalg.solve(self.whole[np.ix_(places, places)] + precision, known)
        own, left = column - rows.T @ follow[:, 0], self.target - rows.T @ follow[:, 1]
        square = float(own @ column)
        parts = (own * (left - own * float(own @ left) / square)).reshape(owner.size, -1).sum(axis=1)
        scores = np.bincount(owner, parts)
        return float(scores @ scores) / square / max(1.0 - 1.0 / scores.size, 0.5)

    def with_number(self, place: int, name: str) -> Projection:
        """The same with a parameter as a number that was maximised over."""
        return replace(self, names={**self.names, place: name}, beside=self.beside[self.beside != place])


def projected(final: Fitted, kept: np.ndarray) -> Projection:
    """All numbers that a group of the family holds or a term of the discrepancy stands for.

    Eq. 18 of docs/mathematics/default-route.md.

    kept : places, among the causes' parameters of the fit, of causes that are none of the hull's; others count as
    numbers of the hull described in another way, and are left out.
    """
    base, terms, more = final.base, final.base.terms, _further(final.base.est, final)
    variant = (*final.variant, *more)
    x = np.concatenate([final.x, np.zeros(len(more))])
    rows = columns(base.est, final.setting, [*terms.parameters, *variant])
    now = final.now
    q = quadratic(rows, now.e, x, base.blocks, base.group(variant), now.log_likelihood, terms.least_side)
    held = {name for group in stated_groups(base.est.model) for name in group.sd}
    own = np.array([j for j in np.flatnonzero(terms.group == NUMBERS) if number_of(terms.parameters[j]) in held], int)
    names = tuple(map(number_of, (*(terms.parameters[j] for j in own), *more)))
    numbers = np.concatenate([own, np.arange(final.x.size, final.x.size + len(more))]).astype(int)
    other = np.setdiff1d(np.flatnonzero(q.group >= 0), own)
    beside = np.concatenate([other, len(terms.parameters) + np.asarray(kept, int)]).astype(int)
    precision = np.full(len(rows), 1e-9)
    precision[other] = 1.0 / final.variances[q.group[other]]
    at = mode(q, final.variances, final.free)
    places = np.flatnonzero(np.isin(at.active, own))
    inflated = inflation(q, at, places) if places.size else 1.0
    target = rows.T @ x - np.clip(now.e, -CLIP, CLIP).ravel()
    owners = dict(zip(numbers.tolist(), names, strict=True))
    return Projection(rows, *q.total, target, precision, owners, beside, inflated, int(np.count_nonzero(now.e)))


def number_of(p: Parameter) -> str:
    """The number that a term of the discrepancy stands for."""
    return p.name.partition(" ")[2]


def _further(est: Estimator, final: Fitted) -> list[Parameter]:
    """Numbers of the family's groups that are no term of the discrepancy, since a cause stands for them."""
    taken = set(map(number_of, final.base.terms.parameters))
    own = {*est.model.coordinates, *est.model.constant_names}
    sizes = {name: sd for g in stated_groups(est.model) for name, sd in g.every.items() if name in own - taken}
    return [Parameter(f"number {name}", "1", ((est.index[name], sd),)) for name, sd in sizes.items()]
