"""Markdown pages of a reproduction: one a paper and an index, from claims and stored results alone.

`python -m helmbench.reproduction.pages.markdown FOLDER` writes them anew from the results in the folder, which
`make reproduction-pages` calls.
"""

from __future__ import annotations

import hashlib
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any

from ...models.folders import make_folder, write_atomic
from ...reporting.numbers import MISSING, interval_digits, percent
from ...reporting.plots import svg
from ...reporting.tables import Column, Table, make_table
from ...reporting.tables import markdown as table_text
from .. import results as stored
from ..claims.claim import DERIVED, KINDS, RESULT, Erratum, Figure, Paper, Reference
from ..claims.files import ACROSS, everything, load
from ..papers.study import StudyResult, drawing_of
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
    judged = results.judged(paper)
    parts = [
        f"# {paper.title}",
        f"Paper {paper.paper}: {paper.citation}",
        *across.section(paper, results, others),
        "## Claims",
        f"**{counts_line(judged)}**",
        "Intervals are those in which a single further run would lie with a probability of 95 %; a published value "
        "agrees with ours where it lies in the interval, widened by the tolerance. [How to read this](README.md)",
        *paper.notes,
        *_items(judged),
        *_shown(paper, results),
        *_figures(paper, results),
        *_errata(paper),
        *_checks(paper, results),
    ]
    return "\n\n".join(parts) + "\n"


def index(found: Sequence[tuple[Paper, Results]], others: Results | None = None) -> str:
    """The first page: what the papers claim and whether it holds, numbers of claims, how to read the other pages."""
    parts = [_INTRODUCTION]
    if others is not None:
        parts += ["## Does it hold?", MARKERS[0], across.table(found, others), MARKERS[1], across.RULE]
    judged = [(paper, results.judged(paper)) for paper, results in found]
    rows = [
        {"paper": f"[{paper.paper}]({paper.paper}.md)", "title": paper.title} | _numbers(own, RESULT)
        for paper, own in judged
    ]
    parts += ["## Results by verdict", _by_verdict(rows, "results")]
    whole = [j for _, own in judged for j in own]
    rows = [{"kind": kind} | _numbers(whole, kind) for kind in KINDS]
    parts += ["All claims by kind:", _by_verdict(rows, "claims"), _LEGEND]
    return "\n\n".join(parts) + "\n"


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


_INTRODUCTION = """# Five papers, computed again

Every table of five papers on the identification of manoeuvring models, and every number that their texts and figures
claim: the published value, ours under the corrected equations, ours under the equations as printed, and a verdict.
These pages are written by `helmbench reproduce`; every number of ours comes from the files in the folder `results`.
[The methods on every vessel](across.md) compares what the papers propose with what they want to replace."""

_LEGEND = """## How to read the pages

- A claim is a **result** of an experiment or a calculation; a **setting** of one; an **echo**, which repeats other
  numbers (a coefficient of a source, or arithmetic of numbers printed beside it); or **derived**: not printed, but
  computed by us from printed numbers, and shown in a column of its own. Only results count in the table above.
- **reproduced**: the printed equations give the published value, or the only form of them that exists.
- **reproduced with correction**: the corrected equations give it, the printed ones do not.
- **consistent, not determined**: the published value lies in the interval of our runs, but these do not settle it: a
  setting that decides it is not printed, the interval is wider than the value itself or holds zero, or about half of
  our runs agree with a statement.
- **in reach of unprinted settings**: a search over what is not printed comes to it, or past it.
- **not reached, settings not printed**: neither our runs nor a search come to it, and the paper leaves open what
  decides it: this says nothing against the paper.
- **no finite value**: no run gave a number.
- **not computable**: the paper lacks what a computation needs.
- **not used**: a setting that no study here takes.
- **contradicted**: neither form gives it, although all that decides it is printed; or although what is not printed
  (time step, rudder rate and lag, speed, zigzag angle, noise, start) was searched over a range that the reason names.
  Since a search leaves gaps, its values must stay away from the published one by more than half of their own range;
  a statement must be false at every point, and true in less than a tenth of our runs.

Where a paper has noise we repeat its experiment with other noise. The number given is the median of the runs, and the
interval behind it is the one in which a single further run, like the one that the authors made, would lie with a
probability of 95 % (order statistics from 39 runs on; below, Student's t, for errors of their logarithms). The
published value counts as equal where it lies in the interval, widened by a tolerance that each claim states and that
covers rounding in print. Bounds ("at most") need only a part of the interval on the right side; a statement counts as
true where at least 60 % of the runs agree, as false where at most 40 % do; between, it is not settled. A run that
diverges, or whose time constants come out complex, gives no number; "no finite value" stands where more than half of
the runs do so."""


def _items(judged: Sequence[Judged]) -> Iterable[str]:
    order = {item: place for place, item in reversed(list(enumerate(j.claim.item for j in judged)))}
    for item, group in groupby(sorted(judged, key=lambda j: order[j.claim.item]), key=lambda j: j.claim.item):
        yield from _item(item, list(group))


def _item(item: str, judged: Sequence[Judged]) -> Iterable[str]:
    """A table or section of the paper: our table and, below it, how each number was computed."""
    protocols = list(dict.fromkeys(j.claim.protocol for j in judged if j.claim.protocol))
    yield f"### {item}"
    yield table_text(make_table(_claim_columns(protocols), judged))
    if protocols:
        yield "How computed:\n\n" + "\n".join(f"{place}. {text}" for place, text in enumerate(protocols, start=1))


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


def _shown(paper: Paper, results: Results) -> Iterable[str]:
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
        yield f"## {table.title}"
        yield table.text
        yield table_text(make_table(columns, table.rows))


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
    named = {claim.id: f"{claim.item}, {claim.quantity}" for claim in paper.claims}

    def consequence(erratum: Erratum) -> str:
        shown_by = f" Shown by: {', '.join(named[name] for name in erratum.claims)}." if erratum.claims else ""
        return erratum.consequence + shown_by

    yield "## Errata"
    columns = [_ready(name, attrgetter(name)) for name in ("equation", "printed", "corrected")]
    columns.append(_ready("consequence", consequence))
    yield table_text(make_table(columns, paper.errata))


def _checks(paper: Paper, results: Results) -> Iterable[str]:
    checks = paper.checks()
    if not checks:
        return
    yield "## Checks against an independent computation"
    agreeing = sum(within(check, results.found(check)) for check in checks)
    yield f"Of {len(checks)} quantities that other code computed before, {agreeing} agree within the tolerance."
    yield "<details><summary>All of them</summary>"
    yield table_text(
        make_table(
            [
                _ready("quantity", lambda check: check.quantity),
                _ready("independent", _expected),
                _ready("ours", lambda check: shown(results.found(check).median, 7)),
                _ready("agrees", lambda check: _agreement(check, results)),
            ],
            checks,
        )
    )
    yield "</details>"


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
    draw = drawing_of(paper.paper, figure.draw)
    data = svg(lambda canvas: draw(results, canvas)).encode()
    path = directory / file_of(paper.paper, figure)
    make_folder(path.parent, within=directory)
    write_atomic(path, data)
    return hashlib.sha256(data).hexdigest()


if __name__ == "__main__":
    write([load(name) for name in everything()], Path(sys.argv[1]))
