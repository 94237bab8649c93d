"""Report of a run directory: leaderboard.md, leaderboard.csv and leaderboard.html, from stored results alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...bench.store import read_manifest, read_tables
from ...bench.traces import read_traces
from ...models.errors import BadInput
from .. import tables
from ..numbers import DEG, SHORT, percent, r_squared
from ..report import Report, environment_rows, reservations, write_files
from ..tables import field, make_table, numeric
from ..templating import render
from . import standings
from .answer import answer, stability_sentences
from .board import Leaderboard, build
from .contest import RankedMethod
from .findings import grey_black_sentence
from .page_data import as_script, page_data
from .standings import COVERAGE, Frame
from .tables import (
    TIME,
    failure_table,
    overall_table,
    record_table,
    uncertainty_table,
)
from .tuners import budgets, tuner_table

# ---- What a terminal shows of a leaderboard: how the runs ended, which method, and one ranking.

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
    """Plain text with one table, of which a narrow terminal leaves columns out.

    Parameters
    ----------
    ended : which suite, how many runs there are, and how they ended.
    """
    ranking = make_table(RANKING, board.overall.to_dict("records"))
    places = board.contest.order()
    told = "\n".join([MEANING, *_coverage(places), *_lost(places)])
    return "\n\n".join([ended, answer(board.contest), tables.console(ranking, fit=True), told])


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


READING = (
    "A cell is one vessel, fitted model, manoeuvres, noise, disturbance and sampling; the seeds are repeated runs in "
    "it. Rank: mean over the cells in which at least two methods are compared, over parameter error where the true "
    "parameters are given and over held-out prediction. "
    "Parameter error: median over the identifiable parameters of a run, then over seeds, then over cells; a parameter "
    "is identifiable if its Cramer-Rao bound is below half its value at low noise. "
    "NRMSE: mean over channels of sqrt(1 - R2) in free run on held-out records. "
    f"[intervals]: {standings.LEVEL:.0%} percentile bootstrap over cells, {standings.BOOTSTRAP_DRAWS} draws, "
    f"seed {standings.BOOTSTRAP_SEED}. Efficiency: Cramer-Rao variance (rudder exactly known) over mean squared "
    f"error, from {standings.EFFICIENCY_SEEDS} seeds on. A failed run ranks last and counts as an infinite error, a "
    "diverged run as an infinite prediction error; runs that are not applicable are counted, not ranked. Time: CPU "
    "time of a fit. Medians are over the cells in which methods are compared, or over all cells where there are none."
)


def write_report(directory: str | Path) -> Report:
    """Aggregate the stored runs of a directory and write the three files beside them.

    Raises
    ------
    BadInput : the directory holds no run, nothing is finished yet, or a file cannot be read.
    """
    directory = Path(directory)
    manifest = read_manifest(directory)
    results, parameters = read_tables(directory)
    if results.empty:
        raise BadInput("no run is finished yet", file=directory, hint="continue with helmbench run --resume")
    board = build(results, parameters)
    data = as_script(page_data(board, read_traces(directory)))
    shown = shown_of(manifest, results, board)
    texts = {
        "leaderboard.md": markdown(shown, board),
        "leaderboard.csv": tables.csv(tables.from_frame(board.overall)),
        "leaderboard.html": html(shown, data),
    }
    paths = write_files(directory, texts)
    told = overview(f"Suite {shown['suite']}, {shown['headline']}", board)
    return Report(texts["leaderboard.md"], told, paths, shown["complete"], tuple(board.overall.to_dict("records")))


def shown_of(manifest: Mapping[str, Any], results: Frame, board: Leaderboard) -> dict[str, Any]:
    """What the report says, by the names that the page has for it."""
    return {
        "suite": manifest["suite"],
        "title": manifest.get("title", ""),
        "headline": headline(manifest, results),
        "complete": len(results) >= manifest["planned"],
        "statements": statements(board),
        "overall": overall_table(board.overall),
        "tuners": tuner_table(board.contest),
        "by_record": record_table(results),
        "uncertainty": uncertainty_table(results),
        "failures": failure_table(board.failures),
        "reading": READING,
        "environment": environment_rows(manifest),
    }


def markdown(shown: Mapping[str, Any], board: Leaderboard) -> str:
    """The report as Markdown text."""
    parts = [f"# Leaderboard: suite {tables.in_markdown(shown['suite'])}", shown["headline"]]
    parts += [f"**{tables.in_markdown(line)}**" for line in answer(board.contest).splitlines()]
    parts += map(tables.in_markdown, shown["statements"])
    every = ("overall", "tuners", "uncertainty", "failures")
    parts += [part for name in every for part in tables.section(shown[name])]
    made_with = tables.listed(shown["environment"])
    return "\n\n".join([*parts, "## How to read it", READING, "## Made with", made_with]) + "\n"


def html(shown: Mapping[str, Any], data: str, main: str = "", advice: str = "") -> str:
    """The report as one self-contained page.

    Parameters
    ----------
    data : what `page_data.as_script` gave.
    main : the suite that the board is of, where the results are of several.
    advice : what the test of the advice says.
    """
    return render("leaderboard.html.j2", **shown, data=data, main=main, advice=advice)


def statements(board: Leaderboard) -> list[str]:
    """Grey against black boxes, tuners at equal budgets, and how stable the ranking is, in sentences."""
    boxes = grey_black_sentence(board.contest)
    return [
        *([boxes] if boxes else []),
        *(own.sentence() for own in budgets(board.contest)),
        *stability_sentences(board.contest),
    ]


def headline(manifest: Mapping[str, Any], results: Frame) -> str:
    """How many runs there are and how they ended."""
    counts = results["status"].value_counts()
    by_status = [f"{int(counts.get(name, 0))} {name.replace('_', ' ')}" for name in ("ok", "failed", "not_applicable")]
    diverged = int(results["diverged"].eq(True).sum())
    text = f"{len(results)} runs: {', '.join(by_status)}; {diverged} diverged in free run."
    return reservations(manifest, len(results)) + text
