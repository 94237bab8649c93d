"""What a check of records says: findings with their sizes, and what could not be checked."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from ..models.errors import BadInput
from .diagnosis.words import cause, scale, size
from .numbers import MISSING, number
from .page import FAIR, GOOD, Drawing, Section, Verdict, items, result_page
from .plots import COLOURS, SOFT, svg
from .tables import Column, Table, make_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..checks.result import Check, CheckFinding, Size
    from .page import Page

ALL, INTERVALS = "all records", "Sizes with their 90 % intervals, over all records and in each"
NOTHING = "The channels agree with each other, and the samples show no fault."
SHOWN = 3
"""Records that are named one by one."""
TITLES = ("Findings", "What matters", "What could not be checked", "To be sure")
READING = (
    "No model of the ship is used. A finding of the file is read off the samples of each record. A finding of the "
    "sensors comes from channels that must agree for any ship: the heading is the integral of the yaw rate, positions "
    "are the integral of surge and sway turned by the heading. Intervals: 90 %, from the scatter of twelve blocks of "
    "each record; where sizes differ between records beyond chance, from the scatter between records (Hartung and "
    "Knapp), and the finding says so. A finding matters where its size is above a floor: half a percent of a scale, "
    "half a degree, half a sampling step or two percent of the time in which the ship changes its turn. Causes joined "
    "by 'or' leave the same traces in these records."
)


def page(result: Check) -> Page:
    """The page of a check."""
    material, small = ([one for one in result.findings if one.material is wanted] for wanted in (True, False))
    panels = _panels(result)
    drawn = partial(svg, partial(_draw, panels), _extent(panels))
    return result_page(
        "Check of records",
        f"{len(result.records)} record{'s' if len(result.records) != 1 else ''}; no model is used",
        Verdict(FAIR if material else GOOD, *_sentences(result, material)),
        seen=[_findings(result), Drawing("sizes", INTERVALS, drawn) if panels else None],
        changed=[items([(name(one), one.evidence) for one in material])],
        remains=[items(result.not_checked)],
        following=[items(_to_be_sure(material))],
        details=[
            Section("Sizes by record", (_by_record(result),)),
            Section("Findings that do not matter", (items([(name(one), one.evidence) for one in small]),)),
            Section("Records", (items(result.records),)),
            Section("How to read it", (READING,)),
        ],
        titles=TITLES,
    )


def _sentences(result: Check, material: Sequence[CheckFinding]) -> tuple[str, tuple[str, ...]]:
    """How many findings there are and which, and what supports it."""
    if not result.findings and result.not_checked:
        return "No finding in what could be checked. What could not is named below.", ()
    n, m = len(result.records), len(material)
    rest = len(result.findings) - m
    told = f"{m} finding{'s' if m != 1 else ''}" if m else "nothing that matters"
    small = f", {rest} detectable but too small to matter" if rest else ""
    named = f": {', '.join(_names(material))}" if m else ""
    said = f"{n} record{'s' if n != 1 else ''}: {told}{named}{small}."
    return said, () if result.findings else (NOTHING,)


def _names(findings: Sequence[CheckFinding]) -> list[str]:
    """Every cause once, with all columns that it is of: `outliers (north_m, east_m)`."""
    columns: dict[str, list[str]] = {}
    for f in findings:
        columns.setdefault(_alone(f), []).extend(_columns(f))
    return [f"{alone} ({', '.join(dict.fromkeys(own))})" if own else alone for alone, own in columns.items()]


def _to_be_sure(findings: Sequence[CheckFinding]) -> list[tuple[str, str]]:
    """Every cause once, with what would tell it from others."""
    return list(dict.fromkeys((_alone(f), f.separate_by) for f in findings if f.separate_by))


# ---- tables


def _findings(result: Check) -> Table:
    """One row a finding: cause, whether it matters, size over all records, records."""
    columns = [
        Column("finding", name),
        Column("matters", lambda f: "yes" if f.material else "no"),
        Column("size [90 %]", whole_sizes),
        Column("records", lambda f: _records(f, len(result.records))),
    ]
    return make_table(columns, result.findings)


def _by_record(result: Check) -> Table:
    """One row a record and size."""
    rows = [(f, s) for f in result.findings for s in f.sizes if s.record is not None and f.stage == "sensors"]
    columns = [
        Column("finding", lambda row: cause(row[0].cause)),
        Column("record", lambda row: row[1].record),
        Column("size [90 %]", lambda row: size(row[1]).removesuffix(f" in {row[1].record}"), lambda row: row[1].value),
    ]
    return make_table(columns, rows)


def name(f: CheckFinding) -> str:
    """The cause with those that cannot be told from it, and the columns of a file's fault."""
    return _names([f])[0]


def _alone(f: CheckFinding) -> str:
    """The cause with those that cannot be told from it."""
    return " or ".join(map(cause, (f.cause, *f.tied_with)))


def _columns(f: CheckFinding) -> list[str]:
    """The columns of a file's fault."""
    return [c for c in f.channels if c != "time_s"] if f.stage == "file" else []


def whole_sizes(f: CheckFinding) -> str:
    """Sizes over all records, or of the one record."""
    whole = [s for s in f.sizes if s.record is None] or (list(f.sizes) if len(f.records) == 1 else [])
    return "; ".join(_short(s).partition(" in ")[0] for s in whole) or MISSING


def _short(s: Size) -> str:
    if s.low != s.high:
        return size(s)
    factor, unit = scale(s)
    return f"{s.parameter} {number(factor * s.value)} {unit}".strip()


def _records(f: CheckFinding, total: int) -> str:
    """The records concerned, or how many they are."""
    if len(f.records) == total and total > 1:
        return f"all {total}"
    return ", ".join(f.records) if len(f.records) <= SHOWN else f"{len(f.records)} of {total}"


# ---- the figure

Panels = list[tuple[str, str, list["Size"]]]


def figure_of(result: Check) -> Figure:
    """A panel a size of a finding: its value over all records and in each, with the 90 % intervals; BadInput where no
    finding has a size."""
    from ..models.figure import ShownFigure

    panels = _panels(result)
    if not panels:
        raise BadInput("no finding of the check has a size to draw", hint="`findings` holds what was found")
    figure = ShownFigure(*_extent(panels))
    _draw(panels, figure)
    return figure


def _panels(result: Check) -> Panels:
    """Cause, parameter and sizes of each panel."""
    return [
        (one.cause, parameter, [size for size in one.sizes if size.parameter == parameter])
        for one in result.findings
        for parameter in dict.fromkeys(size.parameter for size in one.sizes)
    ]


def _extent(panels: Panels) -> tuple[float, float]:
    return 7.5, 0.6 * len(panels) + 0.28 * sum(0.5 + len(sizes) for _, _, sizes in panels)


def _draw(panels: Panels, figure: Figure) -> None:
    heights = [0.5 + len(sizes) for _, _, sizes in panels]
    axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
    for panel, (which, parameter, sizes) in zip(axes, panels, strict=True):
        for place, one in enumerate(sizes):
            colour = COLOURS[0] if one.record is None else SOFT
            factor = scale(one)[0]
            panel.hlines(place, factor * one.low, factor * one.high, color=colour)
            panel.plot(factor * one.value, place, "o", color=colour, markersize=4)
        unit = scale(sizes[0])[1]
        panel.axvline(0.0, color=SOFT, linewidth=0.7)
        panel.set_yticks(range(len(sizes)), [one.record or ALL for one in sizes])
        panel.set(ylim=(len(sizes) - 0.5, -0.5), xlabel=f"{cause(which)}: {parameter}, {unit}".rstrip(", "))
