"""What a terminal shows of a leaderboard: how the runs ended, which method, and one ranking."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from .. import tables
from ..numbers import DEG, number, percent, r_squared
from ..tables import field, make_table
from .answer import answer
from .board import Leaderboard
from .columns import TIME, numeric
from .contest import RankedMethod
from .standings import COVERAGE

SHORT = partial(number, digits=2)
RANKING = (
    field("method"),
    numeric("rank", "rank_prediction", SHORT),
    numeric("parameters", "rel_error", SHORT),
    numeric("NRMSE", "nrmse", SHORT),
    numeric("RMSE", "rmse_yaw_rate_rad_s", SHORT, DEG),
    numeric("R2", "r2_yaw_rate", r_squared),
    TIME,
)
MEANING = (
    "rank: mean of the ranks in prediction; parameters: relative error, where the ship's own equations are fitted; "
    "NRMSE, and RMSE (deg/s) and R2 of the yaw rate: free run on held-out records; time: CPU time of a fit; medians "
    "over the problems."
)


def overview(ended: str, board: Leaderboard) -> str:
    """Plain text with one table, whose bars let a narrow terminal leave columns out.

    Parameters
    ----------
    ended : which suite, how many runs there are, and how they ended.
    """
    ranking = make_table(RANKING, board.overall.to_dict("records"))
    places = board.contest.order()
    told = "\n".join([MEANING, *_coverage(places), *_lost(places)])
    return "\n\n".join([ended, answer(board.contest), tables.markdown(ranking), told])


def _coverage(places: Sequence[RankedMethod]) -> list[str]:
    """On how many problems the methods were compared."""
    most = max((place.problems for place in places), default=0)
    fewer = [place for place in places if place.problems < most]
    if not places:
        return []
    if not fewer:
        return [f"Every method was compared on all {most} problems."]
    below = f" (less than {percent(COVERAGE)}: below the others)" if any(place.partial for place in fewer) else ""
    return [f"Compared on fewer of the {most} problems{below}: {_counted(fewer, 'problems')}."]


def _lost(places: Sequence[RankedMethod]) -> list[str]:
    """Methods without a finite prediction in some problems."""
    lost = [place for place in places if place.imputed]
    return [f"Problems in which it failed or diverged and ranks last: {_counted(lost, 'imputed')}."] if lost else []


def _counted(places: Sequence[RankedMethod], name: str) -> str:
    return ", ".join(f"{place.method} {getattr(place, name)}" for place in places)
