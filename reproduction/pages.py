"""Markdown pages of a reproduction: one a paper and an index, from claims and stored results alone."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from ..bench.store import write_atomic
from . import results as stored
from .claims import Paper
from .figures import file_of
from .results import Results
from .summary import DIGITS, Spread
from .verdict import NO_VALUE, REPRODUCED, VERDICTS, Judged, number, within

INDEX = "README.md"
NOTHING = "–"
BOUNDS = {"at_most": "≤ ", "at_least": "≥ "}


def write(papers: Sequence[Paper], directory: Path) -> list[Path]:
    """Pages and index from the results that are stored in the directory."""
    found = [(paper, stored.read(paper.paper, directory)) for paper in papers]
    texts = {f"{paper.paper}.md": page(paper, results) for paper, results in found}
    texts[INDEX] = index(found)
    for name, text in texts.items():
        write_atomic(directory / name, text.encode())
    return [directory / name for name in texts]


def page(paper: Paper, results: Results) -> str:
    """The page of one paper."""
    judged = results.judged(paper)
    parts = [
        f"# {paper.title}",
        f"Paper {paper.paper}: {paper.citation}",
        f"**{counts_line(judged)}**",
        "Intervals are those in which a single further run would lie with a probability of 95 %; a published value "
        "agrees with ours where it lies in the interval, widened by the tolerance. [How to read this](README.md)",
        *paper.notes,
        *_items(judged),
        *_figures(paper, results),
        *_errata(paper),
        *_checks(paper, results),
    ]
    return "\n\n".join(parts) + "\n"


def index(found: Sequence[tuple[Paper, Results]]) -> str:
    """The first page: what was found, in numbers, and how to read the others."""
    rows = []
    for paper, results in found:
        counts = Counter(claim.verdict for claim in results.judged(paper))
        cells = [f"[{paper.paper}]({paper.paper}.md)", paper.title, str(len(paper.claims))]
        rows.append([*cells, *(str(counts[verdict]) for verdict in VERDICTS)])
    totals = [str(sum(int(row[k]) for row in rows)) for k in range(2, 3 + len(VERDICTS))]
    rows.append(["", "all", *totals])
    table = _table(["paper", "title", "claims", *VERDICTS], rows, numbers=range(2, 3 + len(VERDICTS)))
    return "\n\n".join([_INTRODUCTION, table, _LEGEND]) + "\n"


_INTRODUCTION = """# Five papers, computed again

Every table of five papers on the identification of manoeuvring models, and every number that their texts and figures
claim: the published value, ours under the corrected equations, ours under the equations as printed, and a verdict.
These pages are written by `helmbench reproduce`; every number of ours on them comes from the results beside them."""

_LEGEND = """## How to read the pages

- **reproduced**: the printed equations give the published value; where only one form of them exists, that one does.
- **reproduced with correction**: the corrected equations give it, the printed ones do not.
- **not reproducible**: it cannot be computed from what the paper says, or such records do not tell it: the interval of
  our runs is so wide that it would hold almost any value.
- **contradicted**: neither form gives it; the published value lies outside the interval of our runs.

Where a paper has noise we repeat its experiment with other noise. The number given is the median of the runs, and the
interval behind it is the one in which a single further run, like the one that the authors made, would lie with a
probability of 95 % (order statistics from 39 runs on; below, Student's t, for errors of their logarithms). The
published value counts as equal where it lies in the interval, widened by a tolerance that each claim states and that
covers rounding in print. Bounds ("at most") need only a part of the interval on the right side; a statement counts as
true where it is true in at least half of the runs. A run that diverges, or whose time constants come out complex,
gives no number; "no finite value" stands where more than half of the runs do so."""


def _items(judged: Sequence[Judged]) -> Iterable[str]:
    order = {item: place for place, item in reversed(list(enumerate(j.claim.item for j in judged)))}
    for item, group in groupby(sorted(judged, key=lambda j: order[j.claim.item]), key=lambda j: j.claim.item):
        yield from _item(item, list(group))


def _item(item: str, judged: Sequence[Judged]) -> Iterable[str]:
    """A table or section of the paper: our table and, below it, how each number was computed."""
    protocols = list(dict.fromkeys(j.claim.protocol for j in judged if j.claim.protocol))
    printed = any(j.claim.as_printed for j in judged)
    yield f"## {item}"
    titles = ["quantity", "published", "corrected", *(["as printed"] if printed else []), "verdict", "reason"]
    yield _table(titles, [_row(j, printed, protocols) for j in judged])
    if protocols:
        yield "How computed:\n\n" + "\n".join(f"{place}. {text}" for place, text in enumerate(protocols, start=1))


def titles_and_rows(judged: Sequence[Judged]) -> tuple[list[str], list[list[str]]]:
    """Every claim as one table of plain cells, the item first, then as on the pages."""
    titles = ["item", "quantity", "published", "corrected", "as printed", "verdict", "reason"]
    return titles, [[j.claim.item, *(cell.strip("*") for cell in _row(j, True, [j.claim.protocol]))] for j in judged]


def _row(judged: Judged, printed: bool, protocols: Sequence[str]) -> list[str]:
    claim = judged.claim
    note = f" ({protocols.index(claim.protocol) + 1})" if claim.protocol else ""
    bound = BOUNDS.get(claim.kind, "")
    unit = f" {claim.unit}" if claim.unit and not isinstance(claim.published, bool | str) else ""
    cells = [claim.quantity + note, f"{bound}{number(claim.published, 5)}{unit}{_tolerance(judged)}"]
    cells.append(_spread(judged, judged.corrected) if claim.corrected else NOTHING)
    if printed:
        cells.append(_spread(judged, judged.as_printed) if claim.as_printed else NOTHING)
    wrong = f" Wrong: {_equations(claim.equation)}." if claim.equation and judged.verdict != REPRODUCED else ""
    return [*cells, f"**{judged.verdict}**", judged.reason + wrong]


def _tolerance(judged: Judged) -> str:
    claim = judged.claim
    if claim.kind == "holds" or not claim.study or not (slack := claim.tolerance.around(float(claim.published))):
        return ""
    return f" ± {number(slack, 2)}"


def _spread(judged: Judged, found: Spread) -> str:
    if judged.claim.kind == "holds":
        return _share(judged, found)
    if not found.known:
        return NO_VALUE if found.n else NOTHING
    lost = f", no value in {found.n - found.finite} of {found.n}" if found.finite < found.n else ""
    width = found.high - found.low
    if not width > max(abs(found.low), abs(found.high)) * 10.0 ** (2 - DIGITS):
        return number(found.median) + lost
    digits = max(3, 2 + math.ceil(math.log10(max(abs(found.low), abs(found.high)) / width)))
    return f"{number(found.median, max(digits, 4))} [{number(found.low, digits)}, {number(found.high, digits)}]{lost}"


def _share(judged: Judged, found: Spread) -> str:
    """Of a statement: whether it is true, and in how many of the runs."""
    if not found.known:
        return NOTHING
    if found.n == 1:
        return number(bool(found.median))
    return f"true in {found.mean:.0%} of {found.n} runs"


def _figures(paper: Paper, results: Results) -> Iterable[str]:
    drawn = [figure for figure in paper.figures if figure.id in results.figures]
    if drawn:
        yield "## Figures"
    for figure in drawn:
        yield f"### {figure.title}"
        yield f"![{figure.title}]({file_of(paper.paper, figure)})"
        yield figure.caption


def _errata(paper: Paper) -> Iterable[str]:
    if not paper.errata:
        return
    yield "## Errata"
    rows = []
    for erratum in paper.errata:
        shown = f" Shown by: {', '.join(_quantity(paper, name) for name in erratum.claims)}." if erratum.claims else ""
        rows.append([erratum.equation, erratum.printed, erratum.corrected, erratum.consequence + shown])
    yield _table(["equation", "printed", "corrected", "consequence"], rows)


def _quantity(paper: Paper, name: str) -> str:
    claim = next(claim for claim in paper.claims if claim.id == name)
    return f"{claim.item}, {claim.quantity}"


def _checks(paper: Paper, results: Results) -> Iterable[str]:
    checks = paper.checks()
    if not checks:
        return
    yield "## Checks against an independent computation"
    rows = []
    for check in checks:
        found = results.found(check)
        unit = f" {check.unit}" if check.unit else ""
        slack = number(check.tolerance.around(check.value), 2)
        agreed = ("yes" if within(check, found) else "**no**") + (f"; {check.note}" if check.note else "")
        bound = BOUNDS.get(check.kind, "")
        expected = f"{bound}{number(check.value, 7)}{unit} ± {slack}"
        rows.append([check.quantity, expected, number(found.median, 7), agreed])
    agreeing = sum(within(check, results.found(check)) for check in checks)
    yield f"Of {len(checks)} quantities that other code computed before, {agreeing} agree within the tolerance."
    yield "<details><summary>All of them</summary>"
    yield _table(["quantity", "independent", "ours", "agrees"], rows)
    yield "</details>"


def counts_line(judged: Sequence[Judged]) -> str:
    """How many claims there are and how they ended."""
    counts = Counter(j.verdict for j in judged)
    told = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    return f"{len(judged)} claims: {told}."


def _equations(text: str) -> str:
    return f"eq. {text}" if text.startswith("(") else text


def _table(titles: Sequence[str], rows: Iterable[Sequence[str]], numbers: Iterable[int] = ()) -> str:
    right = set(numbers)
    lines = ["| " + " | ".join(titles) + " |"]
    lines.append("|" + "|".join("---:" if k in right else "---" for k in range(len(titles))) + "|")
    lines += ["| " + " | ".join(_cell(cell) for cell in row) + " |" for row in rows]
    return "\n".join(lines)


def _cell(text: str) -> str:
    """One line in which a bar does not end the cell."""
    return " ".join(text.split()).replace("|", "\\|")
