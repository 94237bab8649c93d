"""Markdown pages of a reproduction: one a paper and an index, from claims and stored results alone.

`python -m helmbench.reproduction.pages.markdown FOLDER` writes them anew from the results in the folder, which
`make reproduction-pages` calls.
"""

from __future__ import annotations

import hashlib
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any

from ...models.folders import make_folder, write_atomic
from ...reporting.numbers import MISSING, interval_digits, percent
from ...reporting.plots import svg
from ...reporting.tables import Column, Table, make_table
from ...reporting.tables import markdown as table_text
from ...reporting.templating import render
from .. import results as stored
from ..claims.claim import DERIVED, KINDS, RESULT, Erratum, Figure, Paper, Reference, ShownTable
from ..claims.files import ACROSS, everything, load
from ..papers.study import StudyResult, drawing
from ..results import Results
from ..verdicts import DIGITS, NO_VALUE, NOTHING, REPRODUCED, VERDICTS, Judged, Spread, shown, within
from . import across

INDEX = "README.md"
MARKERS = ("<!-- headline: begin -->", "<!-- headline: end -->")
"""What encloses the headline table of the first page."""
BOUNDS = {"at_most": "≤ ", "at_least": "≥ "}


def write(papers: Sequence[Paper], directory: Path) -> list[Path]:
    """Pages and index from the results that are stored in the directory."""
    found = [(paper, stored.read(paper.paper, directory)) for paper in papers]
    texts = texts_of(found)
    make_folder(directory)
    for name, text in texts.items():
        write_atomic(directory / name, text.encode())
    return [directory / name for name in texts]


def texts_of(found: Sequence[tuple[Paper, Results]]) -> dict[str, str]:
    """File name -> text of every page."""
    others = next((results for paper, results in found if paper.paper == ACROSS), None)
    own = [(paper, results) for paper, results in found if paper.paper != ACROSS]
    texts = {f"{paper.paper}.md": page(paper, results, others) for paper, results in own}
    texts |= {f"{ACROSS}.md": across.page(paper, results) for paper, results in found if paper.paper == ACROSS}
    return texts | {INDEX: index(own, others)}


def page(paper: Paper, results: Results, others: Results | None = None) -> str:
    """The page of one paper; `others` are the results of all vessels, where they were computed."""
    judged, checks = results.judged(paper), paper.checks()
    text = render(
        "reproduction_paper.md.j2",
        paper=paper,
        answer=across.answer(paper, results, others),
        counts=counts_line(judged),
        items=_items(judged),
        tables=_shown(paper, results),
        figures=[(figure, file_of(paper.paper, figure)) for figure in paper.figures if figure.id in results.figures],
        errata=_errata(paper) if paper.errata else "",
        checks=checks,
        agreeing=sum(within(check, results.found(check)) for check in checks),
        checked=_checked(checks, results),
    )
    return text.rstrip() + "\n"


def index(found: Sequence[tuple[Paper, Results]], others: Results | None = None) -> str:
    """The first page: what the papers claim and whether it holds, numbers of claims, how to read the other pages."""
    judged = [(paper, results.judged(paper)) for paper, results in found]
    rows = [
        {"paper": f"[{paper.paper}]({paper.paper}.md)", "title": paper.title} | _numbers(own, RESULT)
        for paper, own in judged
    ]
    whole = [j for _, own in judged for j in own]
    text = render(
        "reproduction_index.md.j2",
        answers="" if others is None else across.table(found, others),
        markers=MARKERS,
        slight=across.SLIGHT,
        material=across.studies.MATERIAL,
        results=_by_verdict(rows, "results"),
        kinds=_by_verdict([{"kind": kind} | _numbers(whole, kind) for kind in KINDS], "claims"),
    )
    return text + "\n"


def _by_verdict(rows: list[dict[str, Any]], counted: str) -> str:
    """A table of numbers by verdict with a line for the sum."""
    names = [name for name in rows[0] if name not in ("claims", *VERDICTS)] if rows else []
    sums = {name: sum(row[name] for row in rows) for name in ("claims", *VERDICTS)}
    rows = [*rows, dict.fromkeys(names, "") | ({names[-1]: "all"} if names else {}) | sums]
    columns = [_ready(name, itemgetter(name)) for name in names]
    for name in ("claims", *VERDICTS):
        heading = counted if name == "claims" else name
        columns.append(Column(heading, lambda row, name=name: str(row[name]), itemgetter(name)))
    return table_text(make_table(columns, rows))


def _numbers(judged: Iterable[Judged], kind: str) -> dict[str, int]:
    """How many claims of a kind there are, and how many by verdict."""
    counts = Counter(j.verdict for j in judged if j.claim.kind == kind)
    return {"claims": counts.total()} | {name: counts[name] for name in VERDICTS}


def _ready(title: str, text: Callable[[Any], str]) -> Column:
    """A column of texts that are Markdown already: links, formulas, bold type."""
    return Column(title, text, markdown=text)


def _items(judged: Sequence[Judged]) -> Iterator[tuple[str, str, list[str]]]:
    """Tables and sections of the paper in order: our table of each, and how its numbers were computed."""
    for item in dict.fromkeys(j.claim.item for j in judged):
        own = [j for j in judged if j.claim.item == item]
        protocols = list(dict.fromkeys(j.claim.protocol for j in own if j.claim.protocol))
        yield item, table_text(make_table(_claim_columns(protocols), own)), protocols


def claim_table(judged: Sequence[Judged]) -> Table:
    """Every claim with its item, as on the pages; the kind of a row is its verdict."""
    columns = [Column("item", lambda j: j.claim.item), *_claim_columns([])]
    return make_table(columns, judged, kind=lambda j: j.verdict)


def _claim_columns(protocols: Sequence[str]) -> list[Column]:
    """Columns of judged claims; a quantity has the number of its protocol behind it."""

    def quantity(judged: Judged) -> str:
        claim = judged.claim
        number = f" ({protocols.index(claim.protocol) + 1})" if claim.protocol in protocols else ""
        return claim.quantity + number

    return [
        _ready("quantity", quantity),
        Column("kind", lambda j: j.claim.kind),
        _ready("published", lambda j: MISSING if j.claim.kind == DERIVED else _published(j)),
        _ready("from printed numbers", lambda j: _published(j) if j.claim.kind == DERIVED else MISSING),
        _ready("corrected", lambda j: _spread(j, j.corrected) if j.claim.corrected else MISSING),
        _ready("as printed", lambda j: _spread(j, j.as_printed) if j.claim.as_printed else MISSING),
        Column("verdict", lambda j: j.verdict, markdown=lambda j: f"**{j.verdict}**"),
        _ready("reason", _reason),
    ]


def _published(judged: Judged) -> str:
    claim = judged.claim
    unit = f" {claim.unit}" if claim.unit and not isinstance(claim.published, bool | str) else ""
    return f"{BOUNDS.get(claim.form, '')}{shown(claim.published)}{unit}{_tolerance(judged)}"


def _reason(judged: Judged) -> str:
    equation = judged.claim.equation if judged.verdict != REPRODUCED else ""
    wrong = f"eq. {equation}" if equation.startswith("(") else equation
    return judged.reason + (f" Wrong: {wrong}." if wrong else "")


def _tolerance(judged: Judged) -> str:
    claim = judged.claim
    if claim.form == "holds" or not claim.study or not (slack := claim.tolerance.around(float(claim.published))):
        return ""
    return f" ± {shown(slack, 2)}"


def _spread(judged: Judged, found: Spread) -> str:
    if judged.claim.form == "holds":
        return _share(judged, found)
    if not found.known:
        return NO_VALUE if found.n else MISSING
    lost = f", no value in {found.n - found.finite} of {found.n}" if found.finite < found.n else ""
    if not found.high - found.low > max(abs(found.low), abs(found.high)) * 10.0 ** (2 - DIGITS):
        return shown(found.median) + lost
    digits = interval_digits(0.0, found.low, found.high, least=3)
    return f"{shown(found.median, max(digits, 4))} [{shown(found.low, digits)}, {shown(found.high, digits)}]{lost}"


def _range(found: Spread) -> str:
    """Median of the runs, with the least and the largest."""
    if not found.known:
        return NO_VALUE if found.n else MISSING
    if found.smallest == found.largest:
        return shown(found.median)
    return f"{shown(found.median, 3)} [{shown(found.smallest, 3)}, {shown(found.largest, 3)}]"


def _share(judged: Judged, found: Spread) -> str:
    """Of a statement: whether it is true, and in how many of the runs."""
    if not found.known:
        return MISSING
    if found.n == 1:
        return shown(bool(found.median))
    return f"true in {percent(found.mean)} of {found.n} runs"


def _shown(paper: Paper, results: Results) -> Iterator[tuple[ShownTable, str]]:
    """Tables of values without claims, of studies that were computed."""
    for table in paper.shown:
        values = results.values.get(table.study)
        if not values:
            continue
        columns = [_ready("quantity", lambda row: row.quantity + (f", {row.unit}" if row.unit else ""))]
        columns += [
            _ready(title, lambda row, begin=begin, values=values: _range(values.get(f"{begin}_{row.key}", NOTHING)))
            for title, begin in table.columns.items()
        ]
        yield table, table_text(make_table(columns, table.rows))


def _errata(paper: Paper) -> str:
    named = {claim.id: f"{claim.item}, {claim.quantity}" for claim in paper.claims}

    def consequence(erratum: Erratum) -> str:
        shown_by = f" Shown by: {', '.join(named[name] for name in erratum.claims)}." if erratum.claims else ""
        return erratum.consequence + shown_by

    columns = [_ready(name, attrgetter(name)) for name in ("equation", "printed", "corrected")]
    return table_text(make_table([*columns, _ready("consequence", consequence)], paper.errata))


def _checked(checks: Sequence[Reference], results: Results) -> str:
    """What other code computed, beside ours."""
    columns = [
        _ready("quantity", lambda check: check.quantity),
        _ready("independent", _expected),
        _ready("ours", lambda check: shown(results.found(check).median, 7)),
        _ready("agrees", lambda check: _agreement(check, results)),
    ]
    return table_text(make_table(columns, checks))


def _expected(check: Reference) -> str:
    unit = f" {check.unit}" if check.unit else ""
    slack = shown(check.tolerance.around(check.value), 2)
    return f"{BOUNDS.get(check.form, '')}{shown(check.value, 7)}{unit} ± {slack}"


def _agreement(check: Reference, results: Results) -> str:
    return ("yes" if within(check, results.found(check)) else "**no**") + (f"; {check.note}" if check.note else "")


def counts_line(judged: Sequence[Judged]) -> str:
    """How many results there are and how they ended; how many claims of the other kinds."""
    results = _ended([j for j in judged if j.claim.kind == RESULT])
    others = [(kind, [j for j in judged if j.claim.kind == kind]) for kind in KINDS if kind != RESULT]
    told = "; ".join(f"{kind}: {_ended(own)}" for kind, own in others if own)
    return f"Results: {results}." + (f" Besides, {told}." if told else "")


def _ended(judged: Sequence[Judged]) -> str:
    counts = Counter(j.verdict for j in judged)
    text = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    return f"{len(judged)} ({text})" if judged else "0"


# ---- Figures of the pages: drawn by a paper's module on a matplotlib figure, as SVG with equal bytes every time.

FOLDER = "figures"


def file_of(paper: str, figure: Figure) -> str:
    """Path of a figure's file within the pages."""
    return f"{FOLDER}/{paper}-{figure.id}.svg"


def write_figure(paper: Paper, figure: Figure, results: Sequence[StudyResult], directory: Path) -> str:
    """Draw a figure from its study's results, in order of their seeds; returns the SHA-256 of the file."""
    data = svg(drawing(paper.paper, figure, results)).encode()
    path = directory / file_of(paper.paper, figure)
    make_folder(path.parent, within=directory)
    write_atomic(path, data)
    return hashlib.sha256(data).hexdigest()


if __name__ == "__main__":
    write([load(name) for name in everything()], Path(sys.argv[1]))
