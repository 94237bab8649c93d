"""Does the best grey box beat the best black box in free runs?  A paired test over problems."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..numbers import p_value
from .answer import number
from .contest import Contest
from .paired import LEVEL, log_ratios, signed_rank
from .standings import median

FEWEST = 6
"""Pairs below which a Wilcoxon test cannot become significant at 5 %."""


@dataclass(frozen=True)
class GreyBlack:
    """The first method of each kind in the ranking, and their errors' ratio (black over grey) over shared problems.

    `ratio` is the median, `better` the number of `pairs` in which the grey box has the smaller error, `p` the two-sided
    p-value of Wilcoxon's signed-rank test on the logarithms of the ratios.  The methods are chosen on the same runs.
    """

    grey: str
    black: str
    ratio: float
    better: int
    pairs: int
    p: float

    def sentence(self, where: str = "") -> str:
        """The result in one sentence, which may begin with words on the problems."""
        if self.p >= LEVEL:
            verdict = "no difference is shown between"
        else:
            verdict = "the grey box beats the black box:" if self.ratio > 1.0 else "the black box beats the grey box:"
        p = "< 0.001" if self.p < 0.001 else f"= {p_value(self.p)}"
        begin = f"{where}, in free runs" if where else "In free runs"
        return (
            f"{begin} {verdict} {self.grey} (best grey box) and {self.black} (best black box); the black box errs "
            f"{number(self.ratio)} times as much in the median, the grey box is better in {self.better} of "
            f"{self.pairs} problems (Wilcoxon p {p})."
        )


def kinds_of(labels: Sequence[str]) -> dict[str, str]:
    """Label of a contest -> kind of its method; methods that are not installed here are left out."""
    from ...methods.registry import find
    from ...models.errors import BadInput

    found = {}
    for label in labels:
        name = label.partition(" (")[0].partition(",")[0]
        try:
            found[label] = find(name).kind if ".py:" not in name else ""
        except BadInput:
            continue
    return found


def grey_against_black(board: Contest, kinds: Mapping[str, str] | None = None) -> GreyBlack | None:
    """The best grey box against the best black box; None where they share fewer than six problems.

    A run that failed or diverged has an infinite error; methods that do not apply have none.

    Parameters
    ----------
    kinds : label -> kind of its method; default: `kinds_of` the contest's.
    """
    kinds = kinds_of(board.methods) if kinds is None else kinds
    places = board.order()
    grey, black = (
        next((place for place in places if kinds.get(place.method) == kind), None) for kind in ("grey box", "black box")
    )
    if grey is None or black is None:
        return None
    one, two = board.errors[:, grey.index], board.errors[:, black.index]
    both = ~np.isnan(one) & ~np.isnan(two) & (np.isfinite(one) | np.isfinite(two))
    one, two = one[both], two[both]
    if len(one) < FEWEST:
        return None
    ratio = float(np.exp(median(log_ratios(two, one))))
    return GreyBlack(
        grey.method, black.method, ratio, int((one < two).sum()), len(one), signed_rank(log_ratios(one, two))
    )
