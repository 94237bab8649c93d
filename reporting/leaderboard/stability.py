"""How stable a ranking is: it is made again from ships drawn with replacement."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..numbers import percent
from .contest import Contest
from .standings import BOOTSTRAP_DRAWS, BOOTSTRAP_SEED

FEWEST_SHIPS = 2
MENTIONED = 0.05
"""Share of draws from which on a method that comes first is named."""


@dataclass(frozen=True)
class Stability:
    """Method -> share of the draws in which it is first, the most frequent one first; `places` (low, high) of the
    first method's place at 90 %."""

    firsts: dict[str, float]
    ships: int
    places: tuple[int, int]

    def sentence(self, first: str) -> str:
        """What drawing the ships anew says of the first method of the ranking."""
        others = [f"{name} ({percent(share)})" for name, share in self.firsts.items() if name != first]
        told = f"; else {', '.join(others)}" if others else ""
        low, high = self.places
        place = f"place {low}" if low == high else f"places {low} to {high}"
        return (
            f"Of rankings from {self.ships} ships drawn with replacement, {first} is first in "
            f"{percent(self.firsts.get(first, 0.0))} ({place} in 90 %){told}."
        )


def stability(board: Contest, draws: int = BOOTSTRAP_DRAWS) -> Stability | None:
    """The stability of the first group of a contest; None for fewer than `FEWEST_SHIPS` ships or two methods."""
    full = [place for place in board.order() if not place.partial]
    ships = board.problems["vessel"].astype(str).to_numpy()
    names = list(dict.fromkeys(ships))
    if len(full) < 2 or len(names) < FEWEST_SHIPS:
        return None
    means = _mean_ranks(board.ranks()[:, [place.index for place in full]], ships == np.array(names)[:, None], draws)
    first = np.bincount(means.argmin(axis=1), minlength=len(full)) / draws
    place = np.sort(1 + (means < means[:, :1] - 1e-9).sum(axis=1))
    order = [i for i in np.argsort(-first, kind="stable") if first[i] >= MENTIONED or i == 0]
    firsts = {full[i].method: float(first[i]) for i in order}
    return Stability(firsts, len(names), (int(place[draws // 20]), int(place[-1 - draws // 20])))


def _mean_ranks(ranks: np.ndarray, of: np.ndarray, draws: int) -> np.ndarray:
    """Mean ranks (draws, m) of ranks (P, m) over ships drawn with replacement; of (s, P) says which ship's they are.

    Infinite where none of a method's ships is drawn.
    """
    known = ~np.isnan(ranks)
    sums, counts = of @ np.where(known, ranks, 0.0), of @ known.astype(float)
    n = len(of)
    weights = np.random.default_rng(BOOTSTRAP_SEED).multinomial(n, np.full(n, 1.0 / n), size=draws)
    with np.errstate(all="ignore"):
        means = (weights @ sums) / (weights @ counts)
    return np.where(np.isnan(means), np.inf, means)
