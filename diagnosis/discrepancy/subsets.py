"""The best small sets of the base model's numbers by the likelihood of the innovations.

Projection of the whole discrepancy on few numbers (Piironen and Vehtari 2017, doi 10.1007/s11222-016-9649-y): from the
quadratic at the fit with all numbers, everything but the chosen ones is maximised over; further forces keep their
prior.  A ridge spreads one wrong number over all that are correlated with it; the best set of one holds it alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...checks.statistics.tails import chi2_quantile
from ..selection.levels import TIE_NATS

if TYPE_CHECKING:
    from .projection import Profile

MOST, SEARCHED = 7, 3
"""Size of the largest set, and size up to which all sets are compared."""
SUFFICIENT, INVISIBLE = 0.998, 0.02
"""Share of what all numbers together gain, and mean square of what a set leaves in units of the noise, from and up to
which it leaves nothing of importance."""
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


def best_subsets(profile: Profile) -> tuple[Subset, ...]:
    """The best set of every size up to MOST.

    Eq. 20 of docs/mathematics/default-route.md.
    """
    whole = profile.gain(range(len(profile.names)))
    chance = 0.5 * profile.inflation * chi2_quantile(1.0 - CERTAIN, max(len(profile.names), 1))
    loss = max(chance, 0.5 * INVISIBLE * profile.values, (1.0 - SUFFICIENT) * whole)
    found, chosen = [], []
    for size in range(1, min(MOST, len(profile.names)) + 1):
        chosen = profile.best(size) if size <= SEARCHED else [*chosen, profile.best_addition(chosen)]
        chosen = _exchanged(profile, chosen)
        gain = profile.gain(chosen)
        sufficient = whole - gain < loss
        rivals = {profile.names[j]: _rivals(profile, chosen, i) for i, j in enumerate(chosen)}
        names = tuple(profile.names[j] for j in chosen)
        found.append(Subset(names, gain / whole if whole > 0.0 else 0.0, sufficient, rivals))
    return tuple(found)


def _exchanged(profile: Profile, chosen: list[int]) -> list[int]:
    """The set after exchanges of one number at a time as long as the gain rises."""
    reached = profile.gain(chosen)
    while True:
        trials = [(*profile.without(chosen, i)[0], i) for i in range(len(chosen))]
        gain, j, i = max(trials)
        if not gain > reached + 1e-9 * abs(reached):  # not a number: no set is better
            return chosen
        chosen, reached = [*chosen[:i], j, *chosen[i + 1 :]], gain


def _rivals(profile: Profile, chosen: Sequence[int], i: int) -> tuple[str, ...]:
    """Numbers that would do as well in the place of the i-th (eq. 21 of docs/mathematics/default-route.md)."""
    least = profile.gain(chosen) - TIE_NATS * profile.inflation
    return tuple(profile.names[j] for gain, j in profile.without(chosen, i) if gain > least and j != chosen[i])
