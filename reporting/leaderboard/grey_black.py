"""Does the best grey box beat the best black box in free runs?  A paired test over problems."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..numbers import p_value
from .answer import number
from .contest import Contest
from .paired import LEVEL, log_ratios, signed_rank
from .standings import median

FEWEST = 6
"""Pairs below which a Wilcoxon test cannot become significant at 5 %."""


def grey_black_sentence(board: Contest, where: str = "") -> str | None:
    """What `grey_against_black` finds, in one sentence, which may begin with words on the problems."""
    found = grey_against_black(board)
    if found is None:
        return None
    if found["p"] >= LEVEL:
        verdict = "no difference is shown between"
    else:
        verdict = "the grey box beats the black box:" if found["ratio"] > 1.0 else "the black box beats the grey box:"
    p = "< 0.001" if found["p"] < 0.001 else f"= {p_value(found['p'])}"
    begin = f"{where}, in free runs" if where else "In free runs"
    return (
        f"{begin} {verdict} {found['grey']} (best grey box) and {found['black']} (best black box); the black box errs "
        f"{number(found['ratio'])} times as much in the median, the grey box is better in {found['better']} of "
        f"{found['pairs']} problems (Wilcoxon p {p})."
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


def grey_against_black(board: Contest) -> dict[str, Any] | None:
    """The best grey box against the best black box; None where they share fewer than six problems.

    A run that failed or diverged has an infinite error; methods that do not apply have none.

    Returns
    -------
    grey, black : the first method of each kind in the ranking, which is of the same runs.
    ratio, p : median of their errors' ratio, black over grey, and the two-sided p of Wilcoxon's signed-rank test on its
        logarithm; better : in how many of the `pairs`, the shared problems, the grey box has the smaller error.
    """
    kinds = kinds_of(board.methods)
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
    p = signed_rank(log_ratios(one, two))
    found = {"grey": grey.method, "black": black.method, "ratio": ratio, "pairs": len(one), "p": p}
    return found | {"better": int((one < two).sum())}
