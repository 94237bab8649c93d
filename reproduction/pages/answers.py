"""Does the method of a paper beat its baseline?  On its own example and on every vessel, from stored results alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...reporting.numbers import number
from ...reporting.tables import Column, make_table
from ...reporting.tables import markdown as table_text
from ..claims.claim import Headline, Paper
from ..papers.paper_across.statistics import BETTER, BOTH_FAIL, EQUAL, MATERIAL, WORSE
from ..results import Results
from ..verdicts.spread import NOTHING, Spread
from .across import cells, counts, outcome_table, title

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


def section(paper: Paper, results: Results, across: Results | None) -> Iterator[str]:
    """The first section of a paper's page."""
    if paper.headline is None:
        return
    headline = paper.headline
    yield "## Does it beat the baseline?"
    yield f"The claim: {headline.claim}."
    answers = own(paper, results)
    word, method = joined(answers), headline.method
    yield f"**On its own example: {word}.** Ratios of errors, {method} over the other; below 1 it is better."
    columns = [
        Column("compared", lambda row: row[0]),
        Column("ratio", lambda row: row[1]),
        Column("better", lambda row: row[2]),
    ]
    yield table_text(make_table(columns, answers))
    if across is not None:
        yield from _on_vessels(headline, across)


def _on_vessels(headline: Headline, across: Results) -> Iterator[str]:
    word = on_vessels(headline, across)
    yield f"**On all vessels: {word}.** Three levels of noise, 20 runs each; [all numbers](across.md)."
    yield outcome_table([(pair, cells(across, pair)) for pair in headline.pairs])
    yield f"When to use it instead: {instead(headline, across)}."


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


RULE = f"""*On its own example*: the median ratio of the errors over our runs, yes below {1.0 - SLIGHT:g};
*partly* where the comparisons differ. *On other vessels*: yes where the method is better in at least two thirds of
the comparisons, no where it is in at most one third; better and worse are settled by paired tests and a difference of
more than {100.0 * MATERIAL:g} %. *When to use it instead*: the vessels on which it was better than all that it was
compared with."""
