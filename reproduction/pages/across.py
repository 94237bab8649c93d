"""Does the method of a paper beat its baseline, on its own example and on every vessel?  From stored results alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...reporting.numbers import MISSING, number, percent
from ...reporting.tables import Column, make_table
from ...reporting.tables import markdown as table_text
from ..claims.claim import Headline, Paper
from ..papers.paper_across import studies
from ..papers.paper_across.studies import (
    BETTER,
    BOTH_FAIL,
    EQUAL,
    LOST,
    MATERIAL,
    NOISE,
    OUTCOMES,
    PAIRS,
    PLACES,
    PROPOSED,
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
    parts = [f"# {paper.title}", *paper.notes, _LEGEND, "## In short", outcome_table([*pairs.items()], compared)]
    for pair, found in pairs.items():
        parts += [f"## {title(pair)}", *_details(found)]
    if single := proposed(results):
        parts += [f"## {PROPOSED.method} against {PROPOSED.baseline}", *_proposed(single)]
    return "\n\n".join(parts) + "\n"


_LEGEND = f"""The error is the root mean square of the free-run errors of surge, sway and yaw rate over the standard
deviation of each; a fit that fails or a run that diverges counts as {LOST:g}. A ratio below 1 means that the method has
the smaller error. *better* and *worse* need both a two-sided Wilcoxon signed-rank test on the {SEEDS} paired runs below
{studies.LEVEL:g} after Holm's correction over all comparisons of the pair, and a median ratio further than
{percent(studies.MATERIAL)} from 1. *both fail*: the median errors of both are above {studies.USELESS:g}, that of
a constant prediction. The effect is the matched-pairs rank-biserial correlation: 1 where the method always has the
smaller error, -1 where the baseline has."""


def outcome_table(pairs: Sequence[tuple[str, Sequence[PairCell]]], *beside: Column) -> str:
    """How many comparisons of each pair ended in which way."""
    columns = [Column("pair", lambda row: title(row[0])), *beside]
    columns += [
        Column(name, lambda row, name=name: str(counts(row[1])[name]), lambda row, name=name: counts(row[1])[name])
        for name in OUTCOMES
    ]
    return table_text(make_table(columns, pairs))


def _details(found: Sequence[PairCell]) -> Iterator[str]:
    def value(key: str, heading: str = "") -> Column:
        return Column(heading or key, lambda cell: number(cell.found[key], 3), lambda cell: cell.found[key])

    at = {(cell.vessel, cell.noise): cell for cell in found}
    yield _by_noise([cell.vessel for cell in found], lambda *place: _ratio(at[place]))
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
    yield "<details><summary>All numbers</summary>"
    yield table_text(make_table(columns, found))
    yield "</details>"


def _proposed(found: dict[tuple[str, str], dict[str, float]]) -> Iterator[str]:
    own, other = (np.array([cell[name] for cell in found.values()]) for name in ("error", "baseline"))
    both = studies.paired(own, other, LOST)
    failing = int(np.sum(np.minimum(own, other) > studies.USELESS))

    def cost(prefix: str) -> str:
        evaluations, seconds = (
            float(np.nanmedian([cell[f"{prefix}{name}"] for cell in found.values()]))
            for name in ("evaluations", "cpu_s")
        )
        return f"{evaluations:.0f} evaluations and {number(seconds, 2)} s of CPU time"

    yield (
        "Paper 003's proposal as a whole: the observer's states as they are, C by the bee colony of its Table 3 (30 "
        "sources, 60 moves a cycle, 30 cycles), with RW-LSSVR and with LS-SVR. One record a vessel and level of noise "
        "instead of 20, since a fit takes the colony's evaluations; so there is one test over all of them and none for "
        "each. [The colony's convergence](003.md)."
    )
    yield (
        f"RW-LSSVR has the smaller error in {int(np.sum(own < other))} of {len(found)}, the larger one in "
        f"{int(np.sum(own > other))}; the median ratio of errors is {number(both['ratio'], 3)} (two-sided Wilcoxon "
        f"signed-rank test, p {number(both['p'], 2)}); in {failing} both are worse than a constant prediction. In the "
        f"median a fit takes {cost('')}, that of LS-SVR {cost('baseline_')}."
    )
    yield "Ratio of errors, and in brackets the error with RW-LSSVR and with LS-SVR:"
    yield _by_noise([vessel for vessel, _ in found], lambda *place: _errors(found.get(place)))


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
