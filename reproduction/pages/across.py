"""The page that compares the papers' methods with their baselines on every vessel, from stored results alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...reporting.numbers import MISSING, number, percent
from ...reporting.tables import Column, make_table
from ...reporting.tables import markdown as table_text
from ..claims.claim import Paper
from ..papers.paper_across import statistics
from ..papers.paper_across.statistics import OUTCOMES
from ..papers.paper_across.studies import LOST, NOISE, PAIRS, PLACES, PROPOSED, SEEDS
from ..results import Results


@dataclass(frozen=True)
class PairCell:
    """A pair on one vessel at one level of noise; the quantities of `statistics.paired`, `adjusted` by Holm."""

    vessel: str
    noise: str
    found: dict[str, float]
    adjusted: float

    @property
    def outcome(self) -> str:
        """better, worse, no difference, or both fail."""
        f = self.found
        return statistics.outcome(self.adjusted, f["ratio"], f["error"], f["baseline"])


def cells(results: Results, pair: str) -> list[PairCell]:
    """All vessels and levels on which a pair was compared; the p values of these are adjusted together."""
    raw = {}
    for vessel, values in results.values.items():
        for noise in NOISE:
            prefix = f"{pair}.{noise}."
            found = {key.removeprefix(prefix): v.median for key, v in values.items() if key.startswith(prefix)}
            if found:
                raw[vessel, noise] = found
    adjusted = statistics.holm({"/".join(place): found["p"] for place, found in raw.items()})
    return [PairCell(place[0], place[1], found, adjusted["/".join(place)]) for place, found in raw.items()]


def counts(found: Sequence[PairCell]) -> Counter[str]:
    """How many comparisons ended in which way."""
    return Counter(cell.outcome for cell in found)


def title(pair: str) -> str:
    """The pair in words."""
    return f"{PAIRS[pair].method} against {PAIRS[pair].baseline}"


def proposed(results: Results) -> dict[tuple[str, str], dict[str, float]]:
    """Quantities of `PROPOSED` by vessel and noise, see `studies.proposed_at`; empty where it was not computed."""
    values, found = results.values.get("proposed", {}), {}
    for vessel, noise in PLACES:
        prefix = f"{vessel}.{noise}."
        own = {key.removeprefix(prefix): v.median for key, v in values.items() if key.startswith(prefix)}
        if own:
            found[vessel, noise] = own
    return found


def page(paper: Paper, results: Results) -> str:
    """The whole page."""
    pairs = {pair: cells(results, pair) for pair in PAIRS}
    parts = [f"# {paper.title}", *paper.notes, _LEGEND, "## In short", _summary(pairs)]
    for pair, found in pairs.items():
        parts += [f"## {title(pair)}", *_details(found)]
    if single := proposed(results):
        parts += [f"## {PROPOSED.method} against {PROPOSED.baseline}", *_proposed(single)]
    return "\n\n".join(parts) + "\n"


_LEGEND = f"""The error is the root mean square of the free-run errors of surge, sway and yaw rate over the standard
deviation of each; a fit that fails or a run that diverges counts as {LOST:g}. A ratio below 1 means that the method has
the smaller error. *better* and *worse* need both a two-sided Wilcoxon signed-rank test on the {SEEDS} paired runs below
{statistics.LEVEL:g} after Holm's correction over all comparisons of the pair, and a median ratio further than
{percent(statistics.MATERIAL)} from 1. *both fail*: the median errors of both are above {statistics.USELESS:g}, that of
a constant prediction. The effect is the matched-pairs rank-biserial correlation: 1 where the method always has the
smaller error, -1 where the baseline has."""


def _summary(pairs: dict[str, list[PairCell]]) -> str:
    columns = [
        Column("pair", lambda row: title(row[0])),
        Column("compared", lambda row: str(len(row[1])), lambda r: len(r[1])),
    ]
    columns += [
        Column(name, lambda row, name=name: str(counts(row[1])[name]), lambda row, name=name: counts(row[1])[name])
        for name in OUTCOMES
    ]
    return table_text(make_table(columns, [*pairs.items()]))


def _details(found: Sequence[PairCell]) -> Iterator[str]:
    def value(key: str) -> Column:
        heading = {"error": "error", "baseline": "error of the baseline", "ratio": "ratio", "effect": "effect"}[key]
        return Column(heading, lambda cell: number(cell.found[key], 3), lambda cell: cell.found[key])

    yield _matrix(found)
    columns = [
        Column("vessel", lambda cell: cell.vessel),
        Column("noise", lambda cell: cell.noise),
        *(value(key) for key in ("error", "baseline", "ratio")),
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
    both = statistics.paired(own, other, LOST)
    failing = int(np.sum(np.minimum(own, other) > statistics.USELESS))

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
    columns = [Column("vessel", lambda vessel: vessel)]
    for noise in NOISE:
        columns.append(Column(f"{noise} noise", lambda vessel, noise=noise: _errors(found.get((vessel, noise)))))
    yield table_text(make_table(columns, list(dict.fromkeys(vessel for vessel, _ in found))))


def _errors(cell: dict[str, float] | None) -> str:
    if cell is None:
        return MISSING
    own, other = cell["error"], cell["baseline"]
    return f"{number(own / other, 2)} ({number(own, 2)}, {number(other, 2)})"


def _matrix(found: Sequence[PairCell]) -> str:
    """Vessels by noise: the ratio, in bold where it is better or worse."""
    at = {(cell.vessel, cell.noise): cell for cell in found}

    def shown(vessel: str, noise: str) -> str:
        cell = at[vessel, noise]
        if cell.outcome in OUTCOMES[:2]:
            return f"**{cell.outcome}** {number(cell.found['ratio'], 2)}"
        return f"{cell.outcome} {number(cell.found['ratio'], 2)}" if cell.outcome == OUTCOMES[2] else cell.outcome

    columns = [Column("vessel", lambda vessel: vessel)]
    for noise in NOISE:
        columns.append(
            Column(
                f"{noise} noise",
                lambda vessel, noise=noise: shown(vessel, noise),
                markdown=lambda vessel, noise=noise: shown(vessel, noise),
            )
        )
    return table_text(make_table(columns, list(dict.fromkeys(cell.vessel for cell in found))))
