"""Markdown pages of a reproduction: one a paper and an index, from claims and stored results alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any

from ...bench.store import write_atomic
from ...reporting.numbers import MISSING, interval_digits, percent
from ...reporting.tables import Column, Table, make_table
from ...reporting.tables import markdown as table_text
from .. import results as stored
from ..claims.claim import Erratum, Paper, Reference
from ..results import Results
from ..verdicts.spread import DIGITS, Spread
from ..verdicts.verdict import NO_VALUE, REPRODUCED, VERDICTS, Judged, shown, within
from .figures import file_of

INDEX = "README.md"
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
    """The first page: numbers of claims by verdict, and how to read the other pages."""
    rows = [_counts(paper, results) for paper, results in found]
    counted = ("claims", *VERDICTS)
    rows.append({"paper": "", "title": "all"} | {name: sum(row[name] for row in rows) for name in counted})
    columns = [_ready(name, itemgetter(name)) for name in ("paper", "title")]
    columns += [Column(name, lambda row, name=name: str(row[name]), itemgetter(name)) for name in counted]
    table = table_text(make_table(columns, rows))
    return "\n\n".join([_INTRODUCTION, table, _LEGEND]) + "\n"


def _counts(paper: Paper, results: Results) -> dict[str, Any]:
    """A paper's row of the index."""
    counts = Counter(claim.verdict for claim in results.judged(paper))
    facts = {"paper": f"[{paper.paper}]({paper.paper}.md)", "title": paper.title, "claims": len(paper.claims)}
    return facts | {name: counts[name] for name in VERDICTS}


def _ready(title: str, text: Callable[[Any], str]) -> Column:
    """A column of texts that are Markdown already: links, formulas, bold type."""
    return Column(title, text, markdown=text)


_INTRODUCTION = """# Five papers, computed again

Every table of five papers on the identification of manoeuvring models, and every number that their texts and figures
claim: the published value, ours under the corrected equations, ours under the equations as printed, and a verdict.
These pages are written by `helmbench reproduce`; every number of ours comes from the files in the folder `results`."""

_LEGEND = """## How to read the pages

- **reproduced**: the printed equations give the published value, or the only form of them that exists.
- **reproduced with correction**: the corrected equations give it, the printed ones do not.
- **not reproducible**: the paper does not say enough to compute it, or such records cannot determine it: the
  interval of our runs is so wide that it contains almost any value.
- **contradicted**: neither form gives it: the published value is outside the interval of our runs.

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
    yield f"## {item}"
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
        _ready("published", _published),
        _ready("corrected", lambda j: _spread(j, j.corrected) if j.claim.corrected else MISSING),
        _ready("as printed", lambda j: _spread(j, j.as_printed) if j.claim.as_printed else MISSING),
        Column("verdict", lambda j: j.verdict, markdown=lambda j: f"**{j.verdict}**"),
        _ready("reason", _reason),
    ]


def _published(judged: Judged) -> str:
    claim = judged.claim
    unit = f" {claim.unit}" if claim.unit and not isinstance(claim.published, bool | str) else ""
    return f"{BOUNDS.get(claim.kind, '')}{shown(claim.published)}{unit}{_tolerance(judged)}"


def _reason(judged: Judged) -> str:
    equation = judged.claim.equation if judged.verdict != REPRODUCED else ""
    return judged.reason + (f" Wrong: {_equations(equation)}." if equation else "")


def _tolerance(judged: Judged) -> str:
    claim = judged.claim
    if claim.kind == "holds" or not claim.study or not (slack := claim.tolerance.around(float(claim.published))):
        return ""
    return f" ± {shown(slack, 2)}"


def _spread(judged: Judged, found: Spread) -> str:
    if judged.claim.kind == "holds":
        return _share(judged, found)
    if not found.known:
        return NO_VALUE if found.n else MISSING
    lost = f", no value in {found.n - found.finite} of {found.n}" if found.finite < found.n else ""
    if not found.high - found.low > max(abs(found.low), abs(found.high)) * 10.0 ** (2 - DIGITS):
        return shown(found.median) + lost
    digits = interval_digits(0.0, found.low, found.high, least=3)
    return f"{shown(found.median, max(digits, 4))} [{shown(found.low, digits)}, {shown(found.high, digits)}]{lost}"


def _share(judged: Judged, found: Spread) -> str:
    """Of a statement: whether it is true, and in how many of the runs."""
    if not found.known:
        return MISSING
    if found.n == 1:
        return shown(bool(found.median))
    return f"true in {percent(found.mean)} of {found.n} runs"


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
    columns = [_ready(name, attrgetter(name)) for name in ("equation", "printed", "corrected")]
    columns.append(_ready("consequence", lambda erratum: erratum.consequence + _shown_by(paper, erratum)))
    yield table_text(make_table(columns, paper.errata))


def _shown_by(paper: Paper, erratum: Erratum) -> str:
    claims = ", ".join(_quantity(paper, name) for name in erratum.claims)
    return f" Shown by: {claims}." if claims else ""


def _quantity(paper: Paper, name: str) -> str:
    claim = next(claim for claim in paper.claims if claim.id == name)
    return f"{claim.item}, {claim.quantity}"


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
    return f"{BOUNDS.get(check.kind, '')}{shown(check.value, 7)}{unit} ± {slack}"


def _agreement(check: Reference, results: Results) -> str:
    return ("yes" if within(check, results.found(check)) else "**no**") + (f"; {check.note}" if check.note else "")


def counts_line(judged: Sequence[Judged]) -> str:
    """How many claims there are and how they ended."""
    counts = Counter(j.verdict for j in judged)
    text = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
    return f"{len(judged)} claims: {text}."


def _equations(text: str) -> str:
    return f"eq. {text}" if text.startswith("(") else text
