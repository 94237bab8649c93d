"""Findings of the published leaderboard: sentences computed from stored results, each with the command that makes them.

A finding is None where the results do not hold what it needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..numbers import number, p_value
from .answer import two_digits
from .board import Leaderboard
from .contest import Contest
from .equivalence import LEVEL, log_ratios, signed_rank
from .standings import CELL, Frame, Series, median, of_own_models

# ---- Does the best grey box beat the best black box in free runs? A paired test over problems.

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
        f"{two_digits(found['ratio'])} times as much in the median, the grey box is better in {found['better']} of "
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


OUTLIERS, SLOW = "low,outliers=10%", 16
"""Levels that findings compare with the plain ones."""
Finding = tuple[str, str]
"""A sentence with its figures, and the command that makes the runs."""


def findings(main: Leaderboard, every: Leaderboard | None = None) -> list[Finding]:
    """All findings that the results allow, in reading order.

    Parameters
    ----------
    main : the main suite.
    every : all suites, for what is said of conditions; None: the main one.
    """
    every = every or main
    of_main = [grey_black_sentence(main.contest), *_other_models(main)]
    wind = next((level for level in every.contest.problems["disturbance"].unique() if level.startswith("wind")), None)
    conditions = [
        ("noise", _levels(every, "noise", "low", "high", ("low noise", "high noise"))),
        ("disturbances", _levels(every, "disturbance", "none", wind, ("calm water", f"{wind} while training"))),
        ("outliers", _levels(every, "noise", "low", OUTLIERS, ("no outliers", "10 % outliers"))),
        ("sampling", _levels(every, "thinning", 1, SLOW, ("all samples", f"every {SLOW}th sample"))),
        ("excitation", _excitation(every.contest)),
    ]
    made = [("default", text) for text in of_main] + conditions
    return [(text, command(suite)) for suite, text in made if text]


def command(suite: str) -> str:
    """The command that makes the runs of a suite."""
    return f"helmbench run --suite {suite} -o out/{suite}"


def beyond(board: Contest) -> list[Finding]:
    """The best grey box against the best black box where both predict something else than they were trained on.

    board : of the suite `generalise`.
    """
    text = grey_black_sentence(board, "Beyond the training records")
    return [(text, command("generalise"))] if text else []


def _first(board: Contest) -> tuple[str, int] | None:
    return next(((place.method, place.index) for place in board.order() if not place.partial), None)


def _other_models(of: Leaderboard) -> list[str | None]:
    """Grey against black box where the grey box cannot be exact, and what a simpler model costs the first method on
    the vessels that were fitted with both."""
    board = of.contest
    own, vessels = of_own_models(board.problems, of.parameters), board.problems["vessel"].astype(str)
    boxes = None if own.all() else grey_black_sentence(board.kept(~own), "Where the fitted model is not the ship's own")
    first, both = _first(board), sorted(set(vessels[own]) & set(vessels[~own]))
    if first is None or not both:
        return [boxes]
    error, at = board.errors[:, first[1]], vessels.isin(both).to_numpy()
    exact, simple = median(error[at & own]), median(error[at & ~own])
    if np.isnan(exact) or np.isnan(simple):
        return [boxes]
    cost = (
        f"With response models instead of the ship's own equations {first[0]} errs {number(simple)} instead of "
        f"{number(exact)} in the median ({', '.join(both)})."
    )
    return [boxes, cost]


def _excitation(board: Contest) -> str | None:
    """The manoeuvre from which most is learned, where several are compared on the same held-out records."""
    problems = board.problems
    alone = problems[~problems["train"].str.contains(r"\+[A-Za-z_]", regex=True)]
    shared = alone.groupby(["vessel", "model", "held_out"], observed=True)["train"].nunique()
    blocks = shared[shared > 2].index
    if not len(blocks):
        return None
    keep = problems.set_index(["vessel", "model", "held_out"]).index.isin(blocks) & problems.index.isin(alone.index)
    own = board.kept(keep)
    levels = _medians_by(own.problems["excitation"], own.errors)
    order = sorted(levels, key=lambda text: levels[text])
    return (
        f"Of single manoeuvres, {order[0]} teaches most (median prediction error {number(levels[order[0]])} over all "
        f"methods), {order[-1]} least ({number(levels[order[-1]])})."
    )


def _medians_by(levels: Series, errors: np.ndarray) -> dict[str, float]:
    """Median error of the problems (P, ...) at each level; nan where nothing is known."""
    return {str(level): median(errors[(levels == level).to_numpy()]) for level in levels.unique()}


def _levels(of: Leaderboard, factor: str, plain: object, other: object, words: tuple[str, str]) -> str | None:
    """Which method predicts best at a level of a factor, and at the plain one; `words` name the plain and the other."""
    block = [name for name in CELL if name != factor]
    cells: Frame = of.cells[of.cells["nrmse"].notna()]
    one, two = (cells.loc[cells[factor] == level, [*block, "label", "nrmse"]] for level in (plain, other))
    both = one.merge(two, on=[*block, "label"], suffixes=("_a", "_b"))
    both = both[np.isfinite(both["nrmse_a"]) & (both["nrmse_a"] > 0.0)]
    most = both.groupby("label", observed=True).size()
    if not len(most) or len(most[most >= 0.9 * most.max()]) < 3:
        return None
    kept = both[both["label"].isin(most[most >= 0.9 * most.max()].index)]
    errors = kept.groupby("label", observed=True)[["nrmse_a", "nrmse_b"]].median()
    best, calm = errors["nrmse_b"].idxmin(), errors["nrmse_a"].idxmin()
    return (
        f"With {words[1]}, {best} predicts best: median error {number(errors.loc[best, 'nrmse_b'])} against "
        f"{number(errors.loc[best, 'nrmse_a'])} with {words[0]} ({int(most.max())} problems; with {words[0]}, {calm} "
        f"is best with {number(errors.loc[calm, 'nrmse_a'])})."
    )
