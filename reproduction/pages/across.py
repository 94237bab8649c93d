"""Does the method of a paper beat its baseline, on its own example and on every vessel?  From stored results alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import itemgetter
from typing import Any

import numpy as np

from ...reporting.numbers import MISSING, number, percent
from ...reporting.tables import Column, make_table
from ...reporting.tables import markdown as table_text
from ...reporting.templating import render
from ..claims.claim import Headline, Paper
from ..papers.paper_across import studies
from ..papers.paper_across.studies import (
    BETTER,
    BOTH_FAIL,
    EQUAL,
    LOST,
    NOISE,
    OUTCOMES,
    PAIRS,
    PLACES,
    SEEDS,
    WORSE,
)  # fmt: skip
from ..results import Results
from ..verdicts import NOTHING, Spread


@dataclass(frozen=True)
class PairCell:
    """A pair on one vessel at one level of noise; the quantities of `studies.paired`, `adjusted` by Holm."""

    vessel: str
    noise: str
    found: dict[str, float]
    adjusted: float

    @property
    def outcome(self) -> str:
        """better, worse, no difference, or both fail."""
        f = self.found
        return studies.outcome(self.adjusted, f["ratio"], f["error"], f["baseline"])


def cells(results: Results, pair: str) -> list[PairCell]:
    """All vessels and levels on which a pair was compared; the p values of these are adjusted together."""
    places = [(vessel, noise) for vessel in results.values for noise in NOISE]
    raw = {place: _medians(results.values[place[0]], f"{pair}.{place[1]}.") for place in places}
    raw = {place: found for place, found in raw.items() if found}
    adjusted = studies.holm({"/".join(place): found["p"] for place, found in raw.items()})
    return [PairCell(place[0], place[1], found, adjusted["/".join(place)]) for place, found in raw.items()]


def _medians(values: Mapping[str, Spread], prefix: str) -> dict[str, float]:
    """Medians of the values whose keys begin so, by the rest of the keys."""
    return {key.removeprefix(prefix): v.median for key, v in values.items() if key.startswith(prefix)}


def counts(found: Sequence[PairCell]) -> Counter[str]:
    """How many comparisons ended in which way."""
    return Counter(cell.outcome for cell in found)


def title(pair: str) -> str:
    """The pair in words."""
    return f"{PAIRS[pair].method} against {PAIRS[pair].baseline}"


def proposed(results: Results) -> dict[tuple[str, str], dict[str, float]]:
    """Quantities of `PROPOSED` by vessel and noise, see `studies.proposed_at`; empty where it was not computed."""
    values = results.values.get("proposed", {})
    found = {(vessel, noise): _medians(values, f"{vessel}.{noise}.") for vessel, noise in PLACES}
    return {place: own for place, own in found.items() if own}


def page(paper: Paper, results: Results) -> str:
    """The whole page."""
    pairs = {pair: cells(results, pair) for pair in PAIRS}
    compared = Column("compared", lambda row: str(len(row[1])), lambda row: len(row[1]))
    single = proposed(results)
    text = render(
        "reproduction_across.md.j2",
        paper=paper,
        outcomes=outcome_table([*pairs.items()], compared),
        pairs=[(title(pair), *_details(found)) for pair, found in pairs.items()],
        proposed=_proposed(single) if single else None,
        studies=studies,
        lost=LOST,
        seeds=SEEDS,
        percent=percent,
    )
    return text.rstrip() + "\n"


def outcome_table(pairs: Sequence[tuple[str, Sequence[PairCell]]], *beside: Column) -> str:
    """How many comparisons of each pair ended in which way."""
    columns = [Column("pair", lambda row: title(row[0])), *beside]
    columns += [
        Column(name, lambda row, name=name: str(counts(row[1])[name]), lambda row, name=name: counts(row[1])[name])
        for name in OUTCOMES
    ]
    return table_text(make_table(columns, pairs))


def _details(found: Sequence[PairCell]) -> tuple[str, str]:
    """Outcomes of a pair by vessel and noise, and all its numbers."""

    def value(key: str, heading: str = "") -> Column:
        return Column(heading or key, lambda cell: number(cell.found[key], 3), lambda cell: cell.found[key])

    at = {(cell.vessel, cell.noise): cell for cell in found}
    columns = [
        Column("vessel", lambda cell: cell.vessel),
        Column("noise", lambda cell: cell.noise),
        value("error"),
        value("baseline", "error of the baseline"),
        value("ratio"),
        Column("won", lambda cell: percent(cell.found["won"]), lambda cell: cell.found["won"]),
        value("effect"),
        Column("p (Holm)", lambda cell: number(cell.adjusted, 2), lambda cell: cell.adjusted),
        Column("outcome", lambda cell: cell.outcome),
    ]
    by_noise = _by_noise([cell.vessel for cell in found], lambda *place: _ratio(at[place]))
    return by_noise, table_text(make_table(columns, found))


def _proposed(found: dict[tuple[str, str], dict[str, float]]) -> dict[str, Any]:
    """What the page says of the proposal as a whole."""
    own, other = (np.array([cell[name] for cell in found.values()]) for name in ("error", "baseline"))
    both = studies.paired(own, other, LOST)

    def cost(prefix: str) -> str:
        evaluations, seconds = (
            float(np.nanmedian([cell[f"{prefix}{name}"] for cell in found.values()]))
            for name in ("evaluations", "cpu_s")
        )
        return f"{evaluations:.0f} evaluations and {number(seconds, 2)} s of CPU time"

    return {
        "n": len(found),
        "smaller": int(np.sum(own < other)),
        "larger": int(np.sum(own > other)),
        "failing": int(np.sum(np.minimum(own, other) > studies.USELESS)),
        "ratio": number(both["ratio"], 3),
        "p": number(both["p"], 2),
        "cost": cost(""),
        "baseline_cost": cost("baseline_"),
        "table": _by_noise([vessel for vessel, _ in found], lambda *place: _errors(found.get(place))),
    }


def _errors(cell: dict[str, float] | None) -> str:
    if cell is None:
        return MISSING
    own, other = cell["error"], cell["baseline"]
    return f"{number(own / other, 2)} ({number(own, 2)}, {number(other, 2)})"


def _ratio(cell: PairCell) -> str:
    """The outcome and the ratio, in bold where it is better or worse."""
    ratio = "" if cell.outcome == OUTCOMES[3] else f" {number(cell.found['ratio'], 2)}"
    return f"**{cell.outcome}**{ratio}" if cell.outcome in OUTCOMES[:2] else cell.outcome + ratio


def _by_noise(vessels: Sequence[str], text: Callable[[str, str], str]) -> str:
    """A table of vessels by noise: texts, which are Markdown."""
    columns = [Column("vessel", lambda vessel: vessel)]
    for noise in NOISE:
        shown = partial(lambda noise, vessel: text(vessel, noise), noise)
        columns.append(Column(f"{noise} noise", shown, markdown=shown))
    return table_text(make_table(columns, list(dict.fromkeys(vessels))))


YES, NO, PARTLY, OPEN = "yes", "no", "partly", "not settled"
MOSTLY = 2.0 / 3.0
"""Share of the comparisons that makes a yes or a no."""
SLIGHT = 0.15
"""A single ratio nearer to 1 than this is taken as no difference: medians over some runs are no surer."""


def own_answer(found: Spread) -> str:
    """Of one ratio of errors on the paper's own example: yes where the median of the runs is clearly below 1."""
    if not found.known:
        return OPEN
    return YES if found.median < 1.0 - SLIGHT else NO


def own(paper: Paper, results: Results) -> list[tuple[str, str, str]]:
    """Comparisons on the paper's own example: quantity, ratio in words, answer."""
    assert paper.headline is not None
    found = []
    for comparison in paper.headline.own:
        ratio = results.values.get(comparison.study, {}).get(comparison.key, NOTHING)
        told = number(ratio.median, 3) if ratio.known else OPEN
        told = "the other is exact to rounding" if comparison.exact else told
        told += f", {comparison.note}" if comparison.note else ""
        found.append((comparison.quantity, told, own_answer(ratio)))
    return found


def joined(answers: Sequence[tuple[str, str, str]]) -> str:
    """One word for several comparisons."""
    words = {answer for *_, answer in answers}
    return PARTLY if len(words) > 1 else next(iter(words), OPEN)


def on_vessels(headline: Headline, across: Results) -> str:
    """One word for all vessels: yes where most comparisons are better, no where few are."""
    found = [cell for pair in headline.pairs for cell in cells(across, pair)]
    if not found:
        return OPEN
    share = counts(found)[BETTER] / len(found)
    return YES if share >= MOSTLY else NO if share <= 1.0 - MOSTLY else PARTLY


def answer(paper: Paper, results: Results, across: Results | None) -> dict[str, str] | None:
    """What a paper's page says first: whether its method is better, on its own example and on all vessels."""
    headline = paper.headline
    if headline is None:
        return None
    answers = own(paper, results)
    columns = [Column(name, itemgetter(place)) for place, name in enumerate(("compared", "ratio", "better"))]
    found = {"own": joined(answers), "ratios": table_text(make_table(columns, answers)), "outcomes": ""}
    if across is None:
        return found
    outcomes = outcome_table([(pair, cells(across, pair)) for pair in headline.pairs])
    words = {"vessels": on_vessels(headline, across), "instead": instead(headline, across)}
    return found | words | {"outcomes": outcomes}


def instead(headline: Headline, across: Results | None) -> str:
    """Where the method was better than every baseline that it was compared with."""
    if across is None or not headline.pairs:
        return OPEN
    lists = [{(c.vessel, c.noise): c.outcome for c in cells(across, pair)} for pair in headline.pairs]
    places = [place for place in lists[0] if all(one.get(place, BETTER) == BETTER for one in lists)]
    if not places:
        return "nowhere in what was tried"
    by_noise: dict[str, list[str]] = {}
    for vessel, noise in places:
        by_noise.setdefault(noise, []).append(vessel)
    return "; ".join(f"{noise} noise: {', '.join(vessels)}" for noise, vessels in by_noise.items())


def table(found: Sequence[tuple[Paper, Results]], across: Results | None) -> str:
    """The headline table of the first page."""
    rows = [(paper, results) for paper, results in found if paper.headline is not None]

    def link(row: tuple[Paper, Results]) -> str:
        return f"[{row[0].paper}]({row[0].paper}.md)"

    columns = [
        Column("paper", link, markdown=link),
        Column("its claim", lambda row: row[0].headline.claim),
        Column("holds on its own example", lambda row: own_text(*row)),
        Column("holds on other vessels", lambda row: _vessels_text(row[0].headline, across)),
        Column("when to use it instead", lambda row: instead(row[0].headline, across)),
    ]
    return table_text(make_table(columns, rows))


def own_text(paper: Paper, results: Results) -> str:
    """The word and the ratios behind it."""
    answers = own(paper, results)
    ratios = ", ".join(f"{ratio} ({quantity})" for quantity, ratio, _ in answers)
    return f"{joined(answers)}; ratio of errors {ratios}"


def _vessels_text(headline: Headline, across: Results | None) -> str:
    if across is None:
        return OPEN
    told = []
    for pair in headline.pairs:
        found = cells(across, pair)
        n = counts(found)
        told.append(
            f"{title(pair)}: better in {n[BETTER]}, worse in {n[WORSE]}, no difference in {n[EQUAL]}, "
            f"both fail in {n[BOTH_FAIL]} of {len(found)}"
        )
    return f"{on_vessels(headline, across)}; " + "; ".join(told)
