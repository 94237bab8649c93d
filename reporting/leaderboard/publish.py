"""The published leaderboard: results of several suites as one page, a README and Parquet files.

`python -m helmbench.reporting.leaderboard.publish RESULTS... FOLDER`, which `make reports` calls; with FOLDER alone,
which `make board-pages` calls, README and page are written anew from the tables that lie there.
"""

from __future__ import annotations

import io
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...bench.kinds import IDENTIFICATION
from ...bench.kinds.identification.columns import PARAMETERS, RESULTS
from ...bench.store import MANIFEST, read_manifest, read_tables
from ...bench.traces import read_traces
from ...models.data_file import load
from ...models.errors import BadInput
from ...models.folders import make_folder
from .. import tables
from ..report import write_files
from . import tuners
from .answer import begin, headlines, stability_sentences
from .board import Leaderboard, build
from .contest import Contest
from .findings import Finding, beyond, command, findings
from .page import headline, html, shown_of
from .page_data import MEASURED, as_script, page_data
from .standings import CELL, STATUSES, Frame
from .tables import overall_table, uncertainty_finding, uncertainty_table
from .tuners import tuner_table

README, PAGE, PICTURE, ADVICE = "README.md", "leaderboard.html", "ranking.svg", "advice.md"
TABLE = "problems.csv"
"""What a method of somebody's own is compared with: a row a problem and method, small enough for the repository."""
TABLE_COLUMNS = ("case", *CELL, "label", "runs", *STATUSES[1:], "diverged", "nrmse", "rel_error", "cpu_s")
DIGITS = "%.4g"
SLOW = "minutes"
"""Folder, in that of the leaderboard, of the suite whose methods may take minutes: its problems are those of the first
suite, and on one board some of them would be won by methods that others were not run with."""
SLOW_BOARD = "is a board of its own: it has other methods and fewer problems, so that places cannot be compared."
DATA = '<script type="application/json" id="data">'
SHOWN = (
    "method",
    "mean rank",
    "by prediction",
    "NRMSE [95 %]",
    "parameter error [95 %]",
    "failed / n.a. / runs",
    "time",
)
"""Columns of the README's ranking."""


def publish(directories: Sequence[str | Path], folder: str | Path) -> tuple[Path, ...]:
    """Write the leaderboard of several result directories into a folder; the paths.

    Raises
    ------
    BadInput : a directory holds no finished identification run.
    """
    sources, folder = [Path(name) for name in directories], Path(folder)
    manifests = [read_manifest(source) for source in sources]
    for source, manifest in zip(sources, manifests, strict=True):
        if manifest.get("kind", IDENTIFICATION) != IDENTIFICATION:
            raise BadInput("holds no results of an identification suite", file=source)
    results, parameters = together([read_tables(source) for source in sources])
    if results.empty:
        raise BadInput("no run is finished yet", file=sources[0])
    make_folder(folder)
    traces = [entry for source in sources for entry in read_traces(source)]
    manifest = combined(manifests)
    written = {RESULTS: _parquet(results), PARAMETERS: _parquet(parameters), MANIFEST: _json(manifest)}
    return write_files(folder, written | pages(folder, manifest, results, parameters, traces))


def publish_again(folder: str | Path) -> tuple[Path, ...]:
    """README, page and picture of a published folder anew, from its tables and the runs that its page, if any, holds.

    Raises
    ------
    BadInput : a table of the folder is missing or cannot be read.
    """
    import pandas as pd

    folder = Path(folder)
    manifest = load(folder / MANIFEST)
    try:
        results, parameters = (pd.read_parquet(folder / name) for name in (RESULTS, PARAMETERS))
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({error})", file=folder) from None
    page = folder / PAGE
    old = json.loads(page.read_text().partition(DATA)[2].partition("</script>")[0]) if page.is_file() else None
    return write_files(folder, pages(folder, manifest, results, parameters, (), old))


def _tested(folder: Path) -> str:
    """What the test of the advice says that lies in the folder (`helmbench advice`); empty without one."""
    if not (folder / ADVICE).is_file():
        return ""
    return (folder / ADVICE).read_text(encoding="utf-8").split("\n\n")[1]


def pages(
    folder: Path,
    manifest: Mapping[str, Any],
    results: Frame,
    parameters: Frame,
    traces: Sequence[Mapping[str, Any]],
    old: Mapping[str, Any] | None = None,
) -> dict[str, str]:
    """README, page, picture and table of problems by name.

    The ranking is that of the first suite, in which all methods are compared on the same problems.

    Parameters
    ----------
    folder : of which the test of the advice and the board of fits that may take minutes are told, where it holds any.
    old : data of an earlier page of the same results, whose curves are kept.
    """
    every, tuning = boards(results, parameters)
    first = str(every.runs["suite"].iloc[0])
    main, several = every.in_problems_of(first), every.runs["suite"].nunique() > 1
    shown = page_data(every, traces, first)
    if old and all(old[name] == shown[name] for name in ("problems", "methods")):
        shown["runs"] = old["runs"]
    advice = _tested(folder)
    return {
        README: readme(manifest, results, main, every, tuning, advice, (folder / SLOW / README).is_file()),
        PAGE: html(shown_of(manifest, results, main), as_script(shown), first if several else "", advice),
        PICTURE: main.picture(),
        TABLE: problem_table(every.cells),
    }


def ranked_and_tuning(results: Frame) -> tuple[Frame, Frame | None]:
    """The runs that methods are ranked by, and those of the suite `tuners` where there are both.

    Its methods with every tuner and seed would fill the ranking with copies of a few methods.
    """
    own = results["suite"] == tuners.SUITE
    if not own.any() or own.all():
        return results, None
    return results[~own].reset_index(drop=True), results[own].reset_index(drop=True)


def boards(results: Frame, parameters: Frame) -> tuple[Leaderboard, Contest | None]:
    """The board of the runs that methods are ranked by, and the contest of the tuners' runs."""

    def board(own: Frame) -> Leaderboard:
        return build(own, parameters[parameters["suite"].isin(own["suite"].unique())].reset_index(drop=True))

    runs, tuning = ranked_and_tuning(results)
    return board(runs), None if tuning is None else board(tuning).contest


def headline_lines(main: Contest, every: Contest) -> list[str]:
    """A line for each case of what is known, from the main suite; for cases that it lacks, from `MEASURED`."""
    found = dict(headlines(main))
    found |= {case: text for case, text in headlines(every.where({"suite": MEASURED})) if case and case not in found}
    return [f"{begin(case)}: {text}" if case else text for case, text in found.items()]


def told(main: Leaderboard, every: Leaderboard, tuning: Contest | None) -> list[Finding]:
    """All findings, of the main suite's ranking and of the conditions of all suites."""
    stated = uncertainty_finding(every.runs)
    generalise = every.runs[every.runs["suite"] == "generalise"]
    return [
        *findings(main, every),
        *([(stated, command("default"))] if stated else []),
        *(beyond(Leaderboard(generalise, every.parameters).contest) if len(generalise) else []),
        *((own.sentence(), command(tuners.SUITE)) for own in (tuners.budgets(tuning) if tuning else [])),
    ]


def readme(
    manifest: Mapping[str, Any],
    results: Frame,
    board: Leaderboard,
    every: Leaderboard,
    tuning: Contest | None,
    advice: str,
    slow: bool,
) -> str:
    """The headline as GitHub renders it: answer, picture, ranking, findings with their commands."""
    suites = every.runs["suite"]
    main, where = suites.iloc[0], f" in the suite {suites.iloc[0]}" if suites.nunique() > 1 else ""
    ranking = overall_table(board.overall)
    keep = [i for i, name in enumerate(ranking.columns) if name in SHOWN]
    rows = tuple(tuple(row[i] for i in keep) for row in ranking.rows)
    shown = tables.Table(tuple(ranking.columns[i] for i in keep), rows)
    listed = [
        f"{n}. {tables.in_markdown(text)}\n   `{made_by}`"
        for n, (text, made_by) in enumerate(told(board, every, tuning), start=1)
    ]
    return "\n\n".join(
        [
            "# Leaderboard",
            *(f"**{tables.in_markdown(line)}**" for line in headline_lines(board.contest, every.contest)),
            *([f"{advice} See [{ADVICE}]({ADVICE})."] if advice else []),
            *([f"[Where a fit may take minutes]({SLOW}/{README}) {SLOW_BOARD}"] if slow else []),
            f"Suites {manifest['suite']}. {headline(manifest, results)}",
            f"`{PAGE}` chooses by vessel, excitation, noise, disturbance, channels and time, and shows every run; the "
            f"runs are in `{RESULTS}` and `{PARAMETERS}`. These files are in the archive `helmbench-reports` of a "
            "release (`make asset`), and not in the repository; `make reports` makes all of it anew. "
            f"[{TABLE}]({TABLE}) has the medians over seeds of every problem and method.",
            "Times are CPU times of a fit; they hardly depend on what else the machine does.",
            f"![Median prediction error of every method with its interval]({PICTURE})",
            f"## Ranking{where}",
            tables.markdown(shown),
            *tables.section(uncertainty_table(results[results["suite"] == main]), where),
            "## Suites",
            tables.markdown(_suites(manifest, results)),
            *(["## Findings", "\n".join(listed)] if listed else []),
            *(tables.section(tuner_table(tuning)) if tuning else []),
            "## Statistics",
            *map(tables.in_markdown, stability_sentences(board.contest)),
        ]
    ) + "\n"  # fmt: skip


def _suites(manifest: Mapping[str, Any], results: Frame) -> tables.Table:
    """Runs and CPU time of fits by suite; a run that several suites have counts in the first."""
    groups = results.groupby("suite", observed=True)["cpu_s"]
    runs, seconds = groups.size(), groups.sum()
    names = [name for name in str(manifest["suite"]).split(", ") if name in runs.index]
    rows = [{"suite": name, "runs": int(runs[name]), "minutes": float(seconds[name]) / 60.0} for name in names]
    minutes = tables.numeric("CPU time of fits (min)", "minutes", "{:.1f}".format)
    return tables.make_table([tables.field("suite"), tables.numeric("runs", "runs", str), minutes], rows)


def problem_table(cells: Frame) -> str:
    """The medians over seeds of every problem and method as CSV text."""
    table = cells[[*TABLE_COLUMNS]].rename(columns={"label": "method"})
    return str(table.to_csv(index=False, float_format=DIGITS, lineterminator="\n"))


def together(found: Sequence[tuple[Frame, Frame]]) -> tuple[Frame, Frame]:
    """The tables of several folders as one; a run that several suites have is taken once."""
    import pandas as pd

    keys = [*CELL, "method", "variant", "seed"]
    results, parameters = (pd.concat(parts, ignore_index=True) for parts in zip(*found, strict=True))
    first = results.drop_duplicates(keys)
    kept = parameters.merge(first[[*keys, "suite"]], on=[*keys, "suite"])
    return first.reset_index(drop=True), kept[list(parameters.columns)]


def combined(manifests: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One manifest for several."""
    first = manifests[0]
    names = [str(manifest["suite"]) for manifest in manifests]
    complete = sum(int(manifest["planned"]) for manifest in manifests) if len(manifests) == 1 else 0
    titles = "; ".join(str(manifest.get("title", "")) for manifest in manifests)
    seeds = ", ".join(sorted({str(manifest["seeds"]) for manifest in manifests if "seeds" in manifest}))
    return {**first, "suite": ", ".join(names), "title": titles, "planned": complete, "seeds": seeds, "selection": {}}


def _json(value: Mapping[str, Any]) -> bytes:
    return json.dumps(value, indent=1, sort_keys=True).encode() + b"\n"


def _parquet(frame: Frame) -> bytes:
    buffer = io.BytesIO()
    frame.to_parquet(buffer, index=False, compression="zstd")
    return buffer.getvalue()


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: python -m helmbench.reporting.leaderboard.publish [RESULTS...] FOLDER")
    try:
        *given, target = sys.argv[1:]
        for path in publish(given, target) if given else publish_again(target):
            print(f"wrote {path}")
    except BadInput as error:
        sys.exit(f"helmbench: {error}")
