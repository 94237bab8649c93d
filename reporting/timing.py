"""The published timings: the rows that `tests/timing` measure, one JSON object a line, as a table of targets, costs
over size, and a drawing of each.

`python -m helmbench.reporting.timing ROWS FOLDER`, which `make timing` calls, writes them.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..bench.environment import environment
from ..methods.registry import methods
from ..models.data_file import json_of
from ..models.errors import BadInput
from ..models.folders import make_folder
from .numbers import MISSING, fixed, is_missing, number
from .plots import legend_beside, svg
from .report import write_files
from .tables import Column, make_table, markdown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AXES = ("samples", "parameters", "records")
"""What a cost grows with, and name of its drawing."""
IDLE = 0.5
"""Load average for each processor up to which a machine counts as idle."""
SIZE = (8.5, 6.0)


@dataclass(frozen=True)
class Row:
    """A measured pair, value or growing cost.

    what, unit : what is compared, in which unit.
    ours, other : medians of this package and of the other side, None where there is none.
    ratio, low, high, repeats : median, least and largest ratio of the repeats, and how many there were.
    target, reached : the target as text, and whether it is reached; None where nothing could be judged.
    remark, limit : what else is to be known; what keeps the figure from its target.
    axis, points : of a growing cost: 'samples', 'parameters' or 'records', and pairs (size, CPU s).
    run : of a tiny run of a suite: cpu_s, parent_cpu_s, start_cpu_s, stored_bytes, parent_bytes, fixed_bytes.
    code, load : version of the code, and the load average of the machine while it was measured.
    """

    what: str
    unit: str
    ours: float | None = None
    other: float | None = None
    ratio: float | None = None
    low: float | None = None
    high: float | None = None
    repeats: int = 0
    target: str = ""
    reached: bool | None = None
    remark: str = ""
    limit: str = ""
    axis: str = ""
    points: Sequence[Sequence[float]] = ()
    run: Mapping[str, float] | None = None
    code: str = ""
    load: float | None = None


NAMES = frozenset(entry.name for entry in fields(Row))


def read_rows(path: Path) -> list[Row]:
    """The rows of a file; of rows with the same `what` the last one counts.

    Raises
    ------
    BadInput : there is no such file, or a line is not a row.
    """
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise BadInput("cannot be read", file=path, hint="`make timing` writes it") from error
    found = {}
    for place, line in enumerate(lines, 1):
        row = _row(json_of(line, path, place), path, place)
        found[row.what] = row
    if not found:
        raise BadInput("holds no rows", file=path)
    return list(found.values())


def _row(facts: Any, path: Path, place: int) -> Row:
    if not isinstance(facts, dict) or not {"what", "unit"} <= facts.keys():
        raise BadInput("is not a row of timings", file=path, row=place)
    return Row(**{name: value for name, value in facts.items() if name in NAMES})


def verdict(row: Row) -> str:
    """Whether the target is reached, or else what limits the figure."""
    if not row.target:
        return MISSING
    if row.reached is None:
        return "not measured"
    return "reached" if row.reached else f"not reached: {row.limit or 'not yet explained'}"


def ratio(row: Row) -> str:
    """Median and range of the ratios, or the value where there is no pair."""
    if is_missing(row.ratio):
        return MISSING
    return f"{number(row.ratio)} ({number(row.low)} to {number(row.high)}, {row.repeats} repeats)"


COLUMNS = (
    Column("what", lambda row: row.what),
    Column("unit", lambda row: row.unit),
    Column("here", lambda row: number(row.ours), lambda row: row.ours),
    Column("other", lambda row: number(row.other), lambda row: row.other),
    Column("ratio: median (range)", ratio),
    Column("target", lambda row: row.target.replace(">=", "at least").replace("<=", "at most")),
    Column("verdict", verdict),
    Column("remark", lambda row: row.remark),
)


def readme(rows: Sequence[Row], environment: Mapping[str, Any]) -> str:
    """The page as Markdown."""
    judged = [row for row in rows if row.reached is not None]
    lines = [
        "# Speed and memory",
        "",
        "Made by `make timing`; the rows are in [rows.jsonl](rows.jsonl). Both sides of a pair are timed in turn in",
        "one process, by CPU time with one thread; the ratio of each repeat is taken, and the table shows their median",
        "and range. A ratio says how many times as much is done here as by the other side in the same time.",
        "",
        conditions(rows, environment),
        "",
        f"{sum(bool(row.reached) for row in judged)} of {len(judged)} targets are reached.",
        "",
        *slower(rows),
        "## Pairs and values",
        "",
        markdown(make_table(COLUMNS, [row for row in rows if not row.axis and not is_slower(row)])),
        "",
    ]
    for axis in AXES:
        own = [row for row in rows if row.axis == axis]
        if own:
            lines += [f"## Cost against {axis}", "", *growth(axis), "", f"![Cost against {axis}]({axis}.svg)", ""]
            lines += [markdown(make_table(COLUMNS, own)), ""]
    if left := unmeasured(rows):
        lines += [f"Not measured yet, `make timing` goes on: cost against samples of {', '.join(left)}.", ""]
    return "\n".join(lines)


def is_slower(row: Row) -> bool:
    """Whether the other side of a pair does more in the same time."""
    return row.ratio is not None and row.ratio < 1.0


def slower(rows: Sequence[Row]) -> list[str]:
    """The pairs in which the other side is faster, the worst one first."""
    pairs = sorted((row for row in rows if is_slower(row)), key=lambda row: row.ratio or 0.0)
    if not pairs:
        return ["Nothing is slower than what it is compared with.", ""]
    return ["## Slower than the other side", "", markdown(make_table(COLUMNS, pairs)), ""]


def unmeasured(rows: Sequence[Row]) -> list[str]:
    """The methods whose cost against samples is not among the rows."""
    measured = {row.what.rpartition(": ")[2] for row in rows if row.axis == "samples"}
    return [name for name in methods() if name not in measured]


def growth(axis: str) -> list[str]:
    """What the slopes of an axis are."""
    if axis == "parameters":
        return ["The slope is that of log time over log number of parameters, over all models."]
    return [f"The slope is that of log time over log number of {axis} in the last decade; 1 is linear."]


def conditions(rows: Sequence[Row], environment: Mapping[str, Any]) -> str:
    """Machine, code and load."""
    loads = [row.load for row in rows if row.load is not None]
    codes = sorted({row.code for row in rows if row.code})
    told = f"{environment['cpu']}, {environment['cpus']} processors, Python {environment['python']}, "
    told += f"code {', '.join(codes) or MISSING}."
    if loads and max(loads) > IDLE * environment["cpus"]:
        told += (
            f" The machine did other work meanwhile (load average {fixed(min(loads), 1)} to {fixed(max(loads), 1)}): "
        )
        told += "ratios of one run are fair, times are longer than on an idle machine."
    return told


def drawing(rows: Sequence[Row], axis: str) -> str:
    """Time over size of every row of an axis, as SVG."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for place, row in enumerate(rows):
            style = ("-", "--", ":")[place // 8 % 3]
            label = f"{row.what.rpartition(': ')[2]} ({fixed(row.ours, 2)})"
            axes.plot(*zip(*row.points, strict=True), style, marker="o", markersize=2.5, label=label)
        axes.set(xscale="log", yscale="log", xlabel=axis, ylabel="CPU time of a fit [s]")
        axes.set_title("the slope stands behind the method", fontsize="medium")
        legend_beside(axes)

    return svg(draw, (SIZE[0], max(4.0, 0.17 * len(rows) + 1.0)))


README, ROWS = "README.md", "rows.jsonl"


def publish(source: Path, folder: Path, machine: Mapping[str, Any]) -> tuple[Path, ...]:
    """Write README, rows and drawings into a folder; the paths.

    Raises
    ------
    BadInput : the file of rows cannot be used.
    """
    rows = sorted(read_rows(source), key=lambda row: row.what)
    texts = {README: readme(rows, machine), ROWS: "".join(json.dumps(asdict(row)) + "\n" for row in rows)}
    for axis in AXES:
        if own := [row for row in rows if row.axis == axis]:
            texts[f"{axis}.svg"] = drawing(own, axis)
    make_folder(folder)
    return write_files(folder, texts)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python -m helmbench.reporting.timing ROWS FOLDER")
    try:
        for path in publish(Path(sys.argv[1]), Path(sys.argv[2]), environment()):
            print(f"wrote {path}")
    except BadInput as error:
        print(f"helmbench: {error}", file=sys.stderr)
        sys.exit(2)
