"""How stable a ranking is: it is made again from ships drawn with replacement."""

from __future__ import annotations

import numpy as np

from ..numbers import percent
from .answer import begin
from .contest import Contest
from .standings import BOOTSTRAP_DRAWS, BOOTSTRAP_SEED, CASES

FEWEST_SHIPS = 2
MENTIONED = 0.05
"""Share of draws from which on a method that comes first is named."""


def stability(board: Contest, draws: int = BOOTSTRAP_DRAWS) -> tuple[dict[str, float], int, tuple[int, int]] | None:
    """How stable the first group of a contest is; None for fewer than `FEWEST_SHIPS` ships or two methods.

    Returns
    -------
    Method -> share of the draws in which it is first, the most frequent one first; the number of ships; the place
    (low, high) of the first method at 90 %.
    """
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
    return firsts, len(names), (int(place[draws // 20]), int(place[-1 - draws // 20]))


def stability_sentences(board: Contest) -> list[str]:
    """What drawing the ships anew says of the first method, for every case of what is known with several ships."""
    told = []
    for case in CASES:
        own = board.where({"case": case})
        if (found := stability(own)) is None:
            continue
        (shares, ships, (low, high)), first = found, own.order()[0].method
        others = [f"{name} ({percent(share)})" for name, share in shares.items() if name != first]
        place = f"place {low}" if low == high else f"places {low} to {high}"
        told.append(
            f"{begin(case)}: Of rankings from {ships} ships drawn with replacement, {first} is first in "
            f"{percent(shares.get(first, 0.0))} ({place} in 90 %){'; else ' * bool(others)}{', '.join(others)}."
        )
    return told


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
