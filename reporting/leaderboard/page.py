"""Report of a run directory: leaderboard.md, leaderboard.csv and leaderboard.html, from stored results alone."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

from ...bench.store import TIMING, read_manifest, read_tables, write_atomic
from ...models.errors import BadInput
from . import standings as leaderboard
from .standings import Frame

DEG = 180.0 / math.pi
NOTHING = "–"
SHARED = ("model", "train", "held out", "noise", "disturbance")
"""Columns of the table of all cells that are told once where they are the same in every row."""
FACTORS = {
    "noise": "noise",
    "disturbance": "disturbance",
    "thinning": "every n-th sample",
    "length": "share of the records",
    "train": "training records",
    "held_out": "held-out records",
    "model": "fitted model",
    "vessel": "vessel",
}
"""What the factors of `leaderboard.FACTORS` are called."""
CRITERIA = {"rel_error": "Parameter error", "nrmse": "Held-out NRMSE"}
NEAR = 1.5
"""A method counts as good where its prediction error is below this multiple of the best."""
DRAWN = 8
"""Methods in a chart: the best by mean rank."""


@dataclass(frozen=True)
class Column:
    """One shown column: heading, how a row becomes text, and the value it is sorted by (None: the text)."""

    title: str
    text: Callable[[Mapping[str, Any]], str]
    sort: Callable[[Mapping[str, Any]], Any] | None = None


@dataclass(frozen=True)
class Table:
    """A titled table of texts; `sort` holds what each cell is sorted by."""

    title: str
    note: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    sort: tuple[tuple[Any, ...], ...]
    best: frozenset[tuple[int, int]] = frozenset()
    """(row, column) of the cells that are set off."""


@dataclass(frozen=True)
class Report:
    """What `write_report` wrote."""

    markdown: str
    paths: tuple[Path, ...]
    complete: bool
    standings: tuple[dict[str, Any], ...]

    def as_dict(self) -> dict[str, Any]:
        """Plain values for `--json`."""
        files = [str(path) for path in self.paths]
        return {"complete": self.complete, "files": files, "leaderboard": list(self.standings)}


def write_report(directory: str | Path, timing: str | Path | None = None) -> Report:
    """Aggregate the stored runs of a directory and write the three files beside them.

    Parameters
    ----------
    timing : output of `pytest --benchmark-json`; default `timing.json` in the directory, where there is one.

    Raises
    ------
    BadInput : the directory holds no run, nothing is finished yet, or a file cannot be read.
    """
    directory = Path(directory)
    manifest = read_manifest(directory)
    results, parameters = read_tables(directory)
    if results.empty:
        raise BadInput("no run is finished yet", file=directory, hint="continue with helmbench run --resume")
    board = leaderboard.build(results, parameters)
    timings = read_timing(Path(timing) if timing else directory / TIMING, required=timing is not None)
    texts = {
        "leaderboard.md": markdown(manifest, results, board, timings),
        "leaderboard.csv": board.table().to_csv(index=False, lineterminator="\n"),
        "leaderboard.html": html(manifest, results, board, timings),
    }
    for name, text in texts.items():
        write_atomic(directory / name, text.encode())
    paths = tuple(directory / name for name in texts)
    standings = tuple(board.overall.to_dict("records"))
    return Report(texts["leaderboard.md"], paths, len(results) >= manifest["planned"], standings)


def markdown(
    manifest: Mapping[str, Any], results: Frame, board: leaderboard.Leaderboard, timings: Sequence[dict]
) -> str:
    """The report as Markdown text; cells are listed where there is no truth to rank by, as in measured sets."""
    parts = [f"# Leaderboard: suite {manifest['suite']}", headline(manifest, results)]
    unknown = board.detail["rel_error"].isna().groupby(board.detail["vessel"]).transform("all")
    details = detail_tables(board.detail[unknown])
    tail = [failure_table(board.failures), timing_table(timings)]
    for table in [overall_table(board), choice_table(board), *matrices(board), *details, *tail]:
        if table.rows:
            parts += [f"## {table.title}", *([table.note] if table.note else []), markdown_table(table)]
    return "\n\n".join([*parts, "## How to read it", READING, "## Made with", made_with(manifest)]) + "\n"


def html(manifest: Mapping[str, Any], results: Frame, board: leaderboard.Leaderboard, timings: Sequence[dict]) -> str:
    """The report as one self-contained page."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    loader = FileSystemLoader(Path(__file__).parents[1] / "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return page.get_template("leaderboard.html.j2").render(
        suite=manifest["suite"],
        title=manifest.get("title", ""),
        headline=headline(manifest, results),
        complete=len(results) >= manifest["planned"],
        charts=[(title, Markup(svg)) for title, svg in charts(board)],
        overall=overall_table(board),
        choice=choice_table(board),
        matrices=matrices(board),
        levels=level_tables(board),
        details=detail_tables(board.detail),
        failures=failure_table(board.failures),
        timings=timing_table(timings),
        reading=READING,
        environment=environment_rows(manifest),
    )


READING = (
    "Rank: mean over cells (vessel, fitted model, manoeuvres, noise, disturbance, sampling) in which at least two "
    "methods compete, over parameter error where the truth is given and over held-out prediction. "
    "Parameter error: median over identifiable parameters of a run, over seeds, over cells; identifiable means a "
    "Cramer-Rao bound below half the value at low noise. "
    "NRMSE: mean over channels of sqrt(1 - R2) in free run on held-out records. "
    f"[intervals]: {leaderboard.LEVEL:.0%} percentile bootstrap over cells, {leaderboard.BOOTSTRAP_DRAWS} draws, "
    f"seed {leaderboard.BOOTSTRAP_SEED}. Efficiency: Cramer-Rao variance (rudder exactly known) over mean squared "
    f"error, from {leaderboard.EFFICIENCY_SEEDS} seeds on. A failed run ranks last and counts as an infinite error, a "
    "diverged one as an infinite prediction error; what is not applicable is counted, not ranked. Medians are over "
    "compared cells only, or over all where nothing is compared. Levels of a factor are compared over the same other "
    "conditions; the best of a column is set off."
)


def headline(manifest: Mapping[str, Any], results: Frame) -> str:
    """How many runs there are and how they ended."""
    counts = results["status"].value_counts()
    told = [f"{int(counts.get(status, 0))} {status.replace('_', ' ')}" for status in ("ok", "failed", "not_applicable")]
    diverged = int(results["diverged"].eq(True).sum())
    text = f"{len(results)} runs: {', '.join(told)}; {diverged} diverged in free run."
    if len(results) < manifest["planned"]:
        text = f"INCOMPLETE: {len(results)} of {manifest['planned']} runs are finished. {text}"
    return text


def overall_table(board: leaderboard.Leaderboard) -> Table:
    """The standings over all cells."""
    return _table("Overall", "", STANDING, board.overall)


def level_tables(board: leaderboard.Leaderboard) -> list[Table]:
    """The standings at every level of every factor."""
    return [
        _table(f"{FACTORS[factor].capitalize()}: {level}", "", STANDING, frame[frame["group"] == level])
        for factor, frame in board.by.items()
        for level in dict.fromkeys(frame["group"])
    ]


def matrices(board: leaderboard.Leaderboard) -> list[Table]:
    """Methods, best first, against the levels of each factor: the parameter error and the prediction error."""
    found = [
        _matrix(board, factor, name, f"{title} by {FACTORS[factor]}")
        for factor in board.by
        for name, title in CRITERIA.items()
    ]
    return [table for table in found if len(table.columns) > 1]


def _matrix(board: leaderboard.Leaderboard, factor: str, name: str, title: str) -> Table:
    frame = board.by[factor]
    levels = list(dict.fromkeys(frame["group"]))
    most = frame.groupby("group")["cells"].max()
    rows = []
    for method in [method for method in board.overall["method"] if method in set(frame["method"])]:
        own = {row["group"]: row for row in frame[frame["method"] == method].to_dict("records")}
        found = {level: (row[name], int(row["cells"]), int(most[level])) for level, row in own.items()}
        if not all(_missing(value) for value, *_ in found.values()):
            rows.append({"method": method} | found)
    columns = [Column("method", lambda row: row["method"]), *(_compared(level) for level in levels)]
    return _least_marked(rows_table(title, "", columns, rows))


def _compared(level: str) -> Column:
    """A column of (value, cells, most cells), with the cells told where they are fewer than the most."""

    def text(row: Mapping[str, Any]) -> str:
        value, cells, most = row.get(level, (None, 0, 0))
        return number(value) if cells == most or _missing(value) else f"{number(value)} ({cells} of {most})"

    return Column(level, text, lambda row: row.get(level, (None,))[0])


def _least_marked(table: Table) -> Table:
    """The table with the least number of every column after the first set off; those of fewer cells do not count."""
    best = set()
    for column in range(1, len(table.columns)):
        texts = [row[column] for row in table.rows]
        keys = [
            math.inf if keys[column] == "" or " of " in text else float(keys[column])
            for keys, text in zip(table.sort, texts, strict=True)
        ]
        least = min(keys)
        best |= {(row, column) for row, key in enumerate(keys) if key == least and math.isfinite(least)}
    return replace(table, best=frozenset(best))


def choice_table(board: leaderboard.Leaderboard) -> Table:
    """For every level of every factor: what estimated best, what predicted best, and the cheapest good one.

    Only methods take part that were compared in as many cells as any other there.
    """
    rows = [
        {"records": f"{FACTORS[factor]} {level}", **_choices(frame[frame["group"] == level])}
        for factor, frame in board.by.items()
        for level in dict.fromkeys(frame["group"])
    ]
    columns = [Column(title, lambda row, key=key: row[key]) for key, title in CHOICES.items()]
    note = (
        f"The three with the best mean rank, with their median errors; and the fastest with a prediction error below "
        f"{NEAR:g} times the least. Only methods that were compared in every cell there."
    )
    return rows_table("Which method", note, columns, rows)


CHOICES = {
    "records": "records",
    "rel_error": "estimated best (parameter error)",
    "nrmse": "predicted best (NRMSE)",
    "fast": "fastest good one (NRMSE, time)",
}


def _choices(frame: Frame, most: int = 3) -> dict[str, str]:
    """Texts of one row of `choice_table`."""
    everywhere = frame[(frame["cells"] == frame["cells"].max()) & (frame["cells"] > 0)].to_dict("records")
    told = {}
    for rank, name in leaderboard.CRITERIA.items():
        known = sorted((row for row in everywhere if not _missing(row[rank])), key=lambda row: row[rank])
        told[name] = ", ".join(f"{row['method']} {number(row[name])}" for row in known[:most])
    errors = [row["nrmse"] for row in everywhere if not _missing(row["nrmse"])]
    good = [row for row in everywhere if not _missing(row["nrmse"]) and row["nrmse"] <= NEAR * min(errors)]
    fast = min(good, key=lambda row: row["cpu_s"], default=None)
    text = f"{fast['method']} {number(fast['nrmse'])}, {seconds(fast['cpu_s'])}" if fast else ""
    return told | {"fast": text}


def detail_tables(detail: Frame) -> list[Table]:
    """Every cell, one table a vessel."""
    vessels = list(dict.fromkeys(detail["vessel"]))
    return [_detail_table(vessel, detail[detail["vessel"] == vessel].to_dict("records")) for vessel in vessels]


def _detail_table(vessel: str, rows: Sequence[Mapping[str, Any]]) -> Table:
    shared = {column.title: {column.text(row) for row in rows} for column in DETAIL if column.title in SHARED}
    told = {title: texts.pop() for title, texts in shared.items() if len(texts) == 1}
    note = ", ".join(f"{title} {text}" for title, text in told.items())
    columns = [column for column in DETAIL if column.title not in told]
    return rows_table(f"All cells of {vessel}", f"All with {note}." if note else "", columns, rows)


def failure_table(failures: Frame) -> Table:
    """What failed, did not apply or did not converge, and why."""
    return _table("Failed, not applicable, not converged", "", FAILURE, failures)


def timing_table(timings: Sequence[dict]) -> Table:
    """Timings of the benchmark tests."""
    columns = (
        Column("what", lambda row: row["name"]),
        Column("median", lambda row: seconds(row["median"]), lambda row: row["median"]),
        Column("quartiles", lambda row: f"{seconds(row['q1'])} .. {seconds(row['q3'])}", lambda row: row["q3"]),
        Column("rounds", lambda row: str(row["rounds"]), lambda row: row["rounds"]),
    )
    return rows_table("Timings", "Wall time; measured apart from this run.", columns, timings)


def read_timing(path: Path, required: bool = False) -> list[dict[str, Any]]:
    """Name, median, quartiles and rounds from a benchmark JSON file; empty where there is none."""
    if not path.exists() and not required:
        return []
    try:
        found = json.loads(path.read_bytes())["benchmarks"]
        pick = ("median", "q1", "q3", "rounds")
        return sorted(
            ({"name": entry["name"], **{key: entry["stats"][key] for key in pick}} for entry in found),
            key=lambda entry: entry["name"],
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(f"is not a benchmark JSON file ({type(error).__name__}: {error})", file=path) from None


def charts(board: leaderboard.Leaderboard) -> list[tuple[str, str]]:
    """Median errors of the best methods over the levels of noise and sampling, as SVG."""
    from ..plots import by_level

    found = []
    for factor in [factor for factor in ("noise", "thinning", "length") if factor in board.by]:
        frame = board.by[factor]
        levels = list(dict.fromkeys(frame["group"]))
        drawn = [method for method in board.overall["method"] if method in set(frame["method"])][:DRAWN]
        for column, name in CRITERIA.items():
            values = frame.pivot(index="method", columns="group", values=column)
            series = {method: [float(value) for value in values.loc[method, levels]] for method in drawn}
            title = f"{name} by {FACTORS[factor]}" + (f", best {DRAWN} methods" if len(values) > DRAWN else "")
            found.append((title, by_level(series, _short(levels), title)))
    return [(title, svg) for title, svg in found if svg]


def _short(levels: Sequence[str]) -> list[str]:
    """Levels without what the first and others have before a comma."""
    head = levels[0].partition(",")[0] + ","
    return [level.removeprefix(head) for level in levels]


def environment_rows(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the run was made with, as pairs of texts."""
    packages = ", ".join(f"{name} {version}" for name, version in (manifest.get("packages") or {}).items() if version)
    chosen = {name: value for name, value in (manifest.get("selection") or {}).items() if value}
    told = [f"{name} {' '.join(value) if isinstance(value, list) else value}" for name, value in chosen.items()]
    seeds = ", ".join(map(str, manifest.get("seeds", [])))
    return [
        ("version", str(manifest["version"])),
        ("selection", ", ".join(told)),
        ("seeds", f"{seeds}; held-out records {manifest.get('held_out_seed')}"),
        ("threads per worker", str(manifest.get("threads_per_worker"))),
        ("Python", f"{manifest.get('python')} ({manifest.get('platform')})"),
        ("processor", f"{manifest.get('cpu')}, {manifest.get('cpus')} usable"),
        ("packages", packages),
    ]


def made_with(manifest: Mapping[str, Any]) -> str:
    """`environment_rows` as a Markdown list."""
    return "\n".join(f"- {name}: {value}" for name, value in environment_rows(manifest))


# cells


def number(value: Any, digits: int = 3) -> str:
    """A short number; a dash where there is none, `inf` where it is infinite."""
    if _missing(value):
        return NOTHING
    value = float(value)
    if math.isinf(value):
        return "inf"
    return f"{value:.1e}" if value and not 1e-3 <= abs(value) < 1e5 else f"{value:.{digits}g}"


def r_squared(value: Any) -> str:
    """R^2 with three decimals, coarse where it is far below zero."""
    return NOTHING if _missing(value) else f"{float(value):.3f}" if float(value) > -10.0 else f"{float(value):.1e}"


def seconds(value: Any) -> str:
    """A duration with a fitting unit."""
    if _missing(value):
        return NOTHING
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


def _missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and math.isnan(value))


def _with_interval(name: str) -> Callable[[Mapping[str, Any]], str]:
    def text(row: Mapping[str, Any]) -> str:
        middle, low, high = (number(row[key]) for key in (name, f"{name}_low", f"{name}_high"))
        return middle if middle in (NOTHING, "inf") and low == middle else f"{middle} [{low}, {high}]"

    return text


def _numeric(title: str, name: str, form: Callable[[Any], str] = number, scale: float = 1.0) -> Column:
    def value(row: Mapping[str, Any]) -> Any:
        return None if _missing(row[name]) else float(row[name]) * scale

    return Column(title, lambda row: form(value(row)), value)


def _counts(row: Mapping[str, Any]) -> str:
    return f"{row['failed']} / {row['not_applicable']} / {row['runs']}"


def _if_changed(name: str) -> Column:
    """A column that is empty where it says 1."""
    return Column(name, lambda row: NOTHING if row[name] == 1 else number(row[name]), lambda row: row[name])


SAMPLING = (_if_changed("thinning"), _if_changed("length"))
STANDING = (
    Column("method", lambda row: row["method"]),
    _numeric("mean rank", "mean_rank"),
    _numeric("by parameters", "rank_parameters"),
    _numeric("by prediction", "rank_prediction"),
    Column("parameter error [95 %]", _with_interval("rel_error"), lambda row: row["rel_error"]),
    Column("NRMSE [95 %]", _with_interval("nrmse"), lambda row: row["nrmse"]),
    _numeric("yaw rate RMSE (deg/s)", "rmse_yaw_rate_rad_s", scale=DEG),
    _numeric("yaw rate R2", "r2_yaw_rate", r_squared),
    _numeric("heading R2", "r2_heading", r_squared),
    _numeric("efficiency", "efficiency"),
    Column("failed / n.a. / runs", _counts, lambda row: row["failed"]),
    Column("diverged", lambda row: str(row["diverged"]), lambda row: row["diverged"]),
    Column("cells", lambda row: str(row["cells"]), lambda row: row["cells"]),
    _numeric("time", "wall_s", seconds),
)
DETAIL = (
    Column("model", lambda row: row["model"]),
    Column("train", lambda row: row["train"]),
    Column("held out", lambda row: row["held_out"]),
    Column("noise", lambda row: row["noise"]),
    Column("disturbance", lambda row: row["disturbance"]),
    *SAMPLING,
    Column("method", lambda row: row["label"]),
    _numeric("parameter error", "rel_error"),
    _numeric("error / CRB", "crb_z"),
    _numeric("NRMSE", "nrmse"),
    _numeric("yaw rate R2", "r2_yaw_rate", r_squared),
    _numeric("yaw rate RMSE (deg/s)", "rmse_yaw_rate_rad_s", scale=DEG),
    _numeric("heading R2", "r2_heading", r_squared),
    _numeric("heading RMSE (deg)", "rmse_heading_rad", scale=DEG),
    Column("estimates", lambda row: row["estimates"]),
    Column("failed / n.a. / runs", _counts, lambda row: row["failed"]),
    Column("diverged", lambda row: str(row["diverged"]), lambda row: row["diverged"]),
    _numeric("time", "wall_s", seconds),
)
FAILURE = (
    Column("status", lambda row: row["status"].replace("_", " ")),
    Column("method", lambda row: row["label"]),
    Column("vessel", lambda row: row["vessel"]),
    Column("model", lambda row: row["model"]),
    Column("train", lambda row: row["train"]),
    Column("noise", lambda row: row["noise"]),
    Column("disturbance", lambda row: row["disturbance"]),
    *SAMPLING,
    Column("runs", lambda row: str(row["runs"]), lambda row: row["runs"]),
    Column("seeds", lambda row: row["seeds"]),
    Column("reason", lambda row: row["error"]),
)


def _table(title: str, note: str, columns: Sequence[Column], frame: Frame) -> Table:
    return rows_table(title, note, columns, frame.to_dict("records"))


def rows_table(title: str, note: str, columns: Sequence[Column], rows: Sequence[Mapping[str, Any]]) -> Table:
    """The table without columns that are empty throughout, such as efficiency from a single seed."""
    texts = [[column.text(row) for column in columns] for row in rows]
    keep = [i for i in range(len(columns)) if any(text[i] not in (NOTHING, "") for text in texts)]
    keys = [[_key(columns[i], row, text[i]) for i in keep] for row, text in zip(rows, texts, strict=True)]
    names = tuple(columns[i].title for i in keep)
    return Table(title, note, names, tuple(tuple(t[i] for i in keep) for t in texts), tuple(map(tuple, keys)))


def _key(column: Column, row: Mapping[str, Any], text: str) -> Any:
    if column.sort is None:
        return text
    value = column.sort(row)
    return "" if _missing(value) else "1e999" if value == math.inf else value


def markdown_table(table: Table) -> str:
    """A table as Markdown, columns aligned, the best of a column set off."""
    body = [
        [f"**{text}**" if (i, j) in table.best else text for j, text in enumerate(row)]
        for i, row in enumerate(table.rows)
    ]
    rows = [[_cell(text) for text in row] for row in (table.columns, *body)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(table.columns))]
    padded = [" | ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)) for row in rows]
    head, *body = (f"| {line} |" for line in padded)
    return "\n".join([head, "|" + "|".join("-" * (width + 2) for width in widths) + "|", *body])


def _cell(text: str) -> str:
    return escape(text, quote=False).replace("|", "\\|")
