"""The best small sets of the base model's numbers by the likelihood of the innovations.

Projection of the whole discrepancy on few numbers (Piironen and Vehtari 2017, doi 10.1007/s11222-016-9649-y): from the
quadratic at the fit with all numbers, everything but the chosen ones is maximised over; further forces keep their
prior.  A ridge spreads one wrong number over all that are correlated with it; the best set of one holds it alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from ...checks.statistics.tails import chi2_quantile
from ...estimation.filters.innovations.settings import Parameter
from ...models.coefficient_groups import stated_groups
from .fit import expanded
from .quadratic import inflation, mode
from .terms import NUMBERS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from .fit import Fitted

MOST, SEARCHED = 7, 3
"""Size of the largest set, and size up to which all sets are compared."""
SUFFICIENT, INVISIBLE = 0.998, 0.02
"""Share of what all numbers together gain, and mean square of what a set leaves in units of the noise, from and up to
which it leaves nothing of importance."""
ALIKE = 4.6
"""Loss of log likelihood, times the inflation, up to which another number would do as well."""
CERTAIN = 0.99


@dataclass(frozen=True)
class Subset:
    """A set of numbers by name.

    share : of the rise of log likelihood that all numbers together give.  sufficient : whether the others add nothing
    of importance, or nothing that is significant.  rivals : for each number those that would do as well in its place.
    """

    names: tuple[str, ...]
    share: float
    sufficient: bool
    rivals: dict[str, tuple[str, ...]]


@dataclass(frozen=True)
class _Profile:
    """Log likelihood of the numbers (m,) to second order, maximised over all else: matrix (m, m), slope (m,)."""

    names: tuple[str, ...]
    matrix: np.ndarray
    slope: np.ndarray
    inflation: float

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


def number_of(p: Parameter) -> str:
    """The number that a term of the discrepancy stands for."""
    return p.name.partition(" ")[2]


def best_subsets(final: Fitted, kept: np.ndarray) -> tuple[Subset, ...]:
    """The best set of every size up to MOST.

    Eq. 20 of docs/mathematics/default-route.md.

    kept : places, among the causes' parameters of the fit, of causes that are none of the hull's; others count as
    numbers of the hull described in another way, and are left out.
    """
    profile = _profile(final, kept)
    whole = profile.gain(range(len(profile.names)))
    chance = 0.5 * profile.inflation * chi2_quantile(1.0 - CERTAIN, max(len(profile.names), 1))
    loss = max(chance, 0.5 * INVISIBLE * np.count_nonzero(final.now.e), (1.0 - SUFFICIENT) * whole)
    found, chosen = [], []
    for size in range(1, min(MOST, len(profile.names)) + 1):
        chosen = profile.best(size) if size <= SEARCHED else [*chosen, _best_addition(profile, chosen)]
        chosen = _exchanged(profile, chosen)
        gain = profile.gain(chosen)
        sufficient = whole - gain < loss
        rivals = {profile.names[j]: _rivals(profile, chosen, i) for i, j in enumerate(chosen)}
        names = tuple(profile.names[j] for j in chosen)
        found.append(Subset(names, gain / whole if whole > 0.0 else 0.0, sufficient, rivals))
    return tuple(found)


def _best_addition(profile: _Profile, chosen: Sequence[int]) -> int:
    others = [j for j in range(len(profile.names)) if j not in chosen]
    return max(others, key=lambda j: profile.gain([*chosen, j]))


def _exchanged(profile: _Profile, chosen: list[int]) -> list[int]:
    """The set after exchanges of one number at a time as long as the gain rises."""
    while True:
        trials = [(*profile.without(chosen, i)[0], i) for i in range(len(chosen))]
        gain, j, i = max(trials)
        if gain <= profile.gain(chosen) * (1.0 + 1e-9):
            return chosen
        chosen = [*chosen[:i], j, *chosen[i + 1 :]]


def _rivals(profile: _Profile, chosen: Sequence[int], i: int) -> tuple[str, ...]:
    """Numbers that would do as well in the place of the i-th (eq. 21 of docs/mathematics/default-route.md)."""
    least = profile.gain(chosen) - ALIKE * profile.inflation
    return tuple(profile.names[j] for gain, j in profile.without(chosen, i) if gain > least and j != chosen[i])


def _profile(final: Fitted, kept: np.ndarray) -> _Profile:
    """All numbers that a group of the family holds or a term of the discrepancy stands for.

    Eq. 18 of docs/mathematics/default-route.md.
    """
    terms, more = final.base.terms, _further(final.base.est, final)
    variant = (*final.variant, *more)
    q = expanded(final.base, final.setting, final.now, np.concatenate([final.x, np.zeros(len(more))]), variant)
    held = {name for group in stated_groups(final.base.est.model) for name in group.sd}
    own = np.array([j for j in np.flatnonzero(terms.group == NUMBERS) if number_of(terms.parameters[j]) in held], int)
    names = tuple(map(number_of, (*(terms.parameters[j] for j in own), *more)))
    numbers = np.concatenate([own, np.arange(final.x.size, final.x.size + len(more))]).astype(int)
    other = np.setdiff1d(np.flatnonzero(q.group >= 0), own)
    beside = np.concatenate([other, len(terms.parameters) + np.asarray(kept, int)]).astype(int)
    precision = np.concatenate([1.0 / final.variances[q.group[other]], np.full(len(kept), 1e-9)])
    whole, pull = q.total
    inner = whole[np.ix_(beside, beside)] + np.diag(precision)
    follow = np.linalg.solve(inner, np.column_stack([whole[np.ix_(beside, numbers)], pull[beside]]))
    matrix = whole[np.ix_(numbers, numbers)] - whole[np.ix_(numbers, beside)] @ follow[:, :-1]
    slope = pull[numbers] - whole[np.ix_(numbers, beside)] @ follow[:, -1]
    ridge = 1e-9 * np.diag(np.maximum(np.diag(matrix), 1e-9))
    at = mode(q, final.variances, final.free)
    places = np.flatnonzero(np.isin(at.active, own))
    return _Profile(names, matrix + ridge, slope, inflation(q, at, places) if places.size else 1.0)


def _further(est: Estimator, final: Fitted) -> list[Parameter]:
    """Numbers of the family's groups that are no term of the discrepancy, since a cause stands for them."""
    taken = set(map(number_of, final.base.terms.parameters))
    own = {*est.model.coordinates, *est.model.constant_names}
    sizes = {name: sd for g in stated_groups(est.model) for name, sd in g.every.items() if name in own - taken}
    return [Parameter(f"number {name}", "1", ((est.index[name], sd),)) for name, sd in sizes.items()]
