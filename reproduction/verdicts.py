"""Spreads of values over runs, with the interval in which one more would lie, and the verdict on a claim from them."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from ..reporting.numbers import number
from .claims.claim import Claim, Reference

COVERAGE = 0.95
DIGITS = 7
"""Significant digits that are stored."""


Known = Annotated[float, BeforeValidator(lambda value: math.nan if value is None else value)]
"""A number; nan where it is not known, which is stored as null."""


@dataclass(frozen=True)
class Spread:
    """A quantity over runs: `median`, and the interval [`low`, `high`] for a single further run; nan where unknown.

    n : runs;  finite : those that gave a number;  smallest, largest, mean (of statements the
    share of true ones) : of these.
    """

    n: int
    finite: int
    median: Known
    low: Known
    high: Known
    smallest: Known
    largest: Known
    mean: Known

    @property
    def known(self) -> bool:
        """Whether at least half of the runs gave a number."""
        return self.finite > 0 and 2 * self.finite >= self.n


NOTHING = Spread(0, 0, *[math.nan] * 6)


def spread(values: Sequence[float], logarithmic: bool = False) -> Spread:
    """The spread of one value a run; what is not finite counts as a run without a number."""
    whole = np.asarray(values, float)
    found = np.sort(whole[np.isfinite(whole)])
    if not found.size:
        return Spread(len(whole), 0, *[math.nan] * 6)
    low, high = prediction_interval(found, logarithmic)
    numbers = (float(np.median(found)), low, high, float(found[0]), float(found[-1]), float(np.mean(found)))
    return Spread(len(whole), len(found), *(float(f"{value:.{DIGITS}g}") for value in numbers))


def prediction_interval(ordered: np.ndarray, logarithmic: bool = False) -> tuple[float, float]:
    """Interval that holds one more value with probability .95, given sorted values (n,).

    From 39 values on by order statistics, whatever the distribution; below by Student's t, of the logarithms where
    that is asked for and all are positive; of one value that value.
    """
    n = len(ordered)
    if n == 1:
        return float(ordered[0]), float(ordered[0])
    rank = int((1.0 - COVERAGE) / 2.0 * (n + 1))
    if rank >= 1:
        return float(ordered[rank - 1]), float(ordered[n - rank])
    if logarithmic and ordered[0] > 0.0:
        low, high = _student(np.log(ordered))
        return math.exp(low), math.exp(high)
    return _student(ordered)


def _student(values: np.ndarray) -> tuple[float, float]:
    from scipy.special import stdtrit

    n = len(values)
    half = stdtrit(n - 1, 0.5 + COVERAGE / 2.0) * float(np.std(values, ddof=1)) * math.sqrt(1.0 + 1.0 / n)
    middle = float(np.mean(values))
    return middle - half, middle + half


def summarise(runs: Sequence[Mapping[str, Any]], logarithmic: Container[str] = ()) -> dict[str, Spread]:
    """Key -> spread over the runs of one study, each a mapping of key to value; absent and null are not numbers.

    `logarithmic` are the keys whose interval is taken of the logarithms.
    """
    keys = dict.fromkeys(key for values in runs for key in values)
    each = {key: [values.get(key) for values in runs] for key in keys}
    numbers = {key: [math.nan if value is None else float(value) for value in own] for key, own in each.items()}
    return {key: spread(own, key in logarithmic) for key, own in numbers.items()}


REPRODUCED = "reproduced"
CORRECTED = "reproduced with correction"
CONSISTENT = "consistent, not determined"
IN_REACH = "in reach of unprinted settings"
NOT_REACHED = "not reached, settings not printed"
NO_VALUE = "no finite value"
NOT_COMPUTABLE = "not computable"
NOT_USED = "not used"
CONTRADICTED = "contradicted"
OPEN = (CONSISTENT, IN_REACH, NOT_REACHED, NO_VALUE, NOT_COMPUTABLE, NOT_USED)
"""What is neither reproduced nor contradicted; a claim may give one reason for all of these, under `open`."""
VERDICTS = (REPRODUCED, CORRECTED, *OPEN, CONTRADICTED)
HALF_TOLERANCE = 0.1
"""A statement that is true in a share of the runs this near to a half is not decided."""

LEAST_POINTS = 8
"""A search for a value with fewer points than these does not cover its range, and contradicts nothing."""
GAP = 0.5
"""A search leaves gaps: the range of what it found is widened by this share of its width at either end."""
RARE = 0.1
"""A statement that is true in this share of our runs may have been true in the one run of the authors."""
ROUNDING = 1e-6
"""Values that differ by less, relatively, are equal, so that no verdict depends on the last stored digit."""


@dataclass(frozen=True)
class Judged:
    """A claim with what was found and the verdict; `reason` is one sentence.

    `searched` are the values over the range of what the paper does not print.
    """

    claim: Claim
    corrected: Spread
    as_printed: Spread
    searched: tuple[Spread, ...]
    verdict: str
    reason: str


def judge(
    claim: Claim,
    values: Mapping[str, Spread],
    failure: str = "",
    searched: Mapping[str, Spread] | None = None,
    over: str = "",
) -> Judged:
    """Compare a claim with the spreads of its study's values.

    A published value counts as equal to ours where it lies in the interval in which a single further run would lie,
    widened by the claim's tolerance; a statement is true where `HALF_TOLERANCE` more than half of our runs agree.

    - `reproduced`: the printed equations give it; or ours, where no other were printed.
    - `reproduced with correction`: only the corrected equations give it.
    - `contradicted`: neither do, although everything that decides it is printed (`claim.stated`), or although what is
      not printed was searched over a range, `over`, and the values in `searched` stay away from it (see `reached`).
    - `consistent, not determined`: the published value lies in the interval of our runs, which does not settle it: a
      decisive setting is not printed (`claim.unprinted`), the interval holds zero (`claim.nonzero`) or is too wide
      (`claim.limit`), or about half of the runs agree with a statement.
    - `in reach of unprinted settings`: it lies among the values that a search over these settings found, or a
      statement is true at some of them or in some of our runs.
    - `not reached, settings not printed`: it lies outside both, but not all that decides it is printed, or a search
      with gaps as wide as this one's may have missed it (`GAP`).
    - `no finite value`: no run gave a number.
    - `not computable`: the paper lacks what a computation needs (`claim.missing`).
    - `not used`: a setting that no study takes (`claim.unused`).
    """
    corrected = values.get(claim.corrected, NOTHING)
    printed = values.get(claim.as_printed, NOTHING) if claim.as_printed else NOTHING
    tried = tuple((searched or {}).get(key, NOTHING) for key in (claim.corrected, claim.as_printed) if key)
    verdict = _verdict(claim, corrected, printed, tried)
    found = {key: shown(own.median) for key, own in {**values, **(searched or {})}.items()}
    reason = failure or _reason(claim, corrected, printed, verdict, tried, over, found)
    return Judged(claim, corrected, printed, tried, verdict, reason)


def _verdict(claim: Claim, corrected: Spread, printed: Spread, tried: tuple[Spread, ...]) -> str:
    if claim.missing or claim.unused:
        return NOT_COMPUTABLE if claim.missing else NOT_USED
    first = printed if claim.as_printed else corrected
    if not claim.unprinted and agrees(claim, first) and determines(claim, first):
        return REPRODUCED
    if not claim.unprinted and agrees(claim, corrected) and determines(claim, corrected):
        return CORRECTED
    if any(agrees(claim, found) or undecided(claim, found) for found in (first, corrected)):
        return CONSISTENT
    return _far(claim, (first, corrected), tried)


def _far(claim: Claim, own: tuple[Spread, ...], tried: tuple[Spread, ...]) -> str:
    """The verdict on a claim that disagrees with our runs."""
    known = any(found.known for found in own)
    if not any(found.finite for found in tried):
        if claim.stated and known and not claim.unprinted:
            return CONTRADICTED
        return NOT_REACHED if known else NO_VALUE
    if any(reached(claim, found, gap=0.0) for found in tried) or any(happens(claim, found) for found in own):
        return IN_REACH
    few = claim.form != "holds" and max(found.n for found in tried) < LEAST_POINTS
    if few or claim.unprinted or any(reached(claim, found) for found in tried):
        return NOT_REACHED if known else NO_VALUE
    return CONTRADICTED


def undecided(claim: Claim, found: Spread) -> bool:
    """Whether a statement is true in about half of the runs."""
    return claim.form == "holds" and found.known and abs(found.mean - 0.5) < HALF_TOLERANCE - ROUNDING


def reached(claim: Claim, found: Spread, gap: float = GAP) -> bool:
    """Whether the published value lies among the values that a search found, whose range is widened by a share `gap`
    of its width at either end."""
    if not found.finite:
        return False
    if claim.form == "holds":
        return (found.largest if claim.published else 1.0 - found.smallest) >= 0.5
    low, high = found.smallest, found.largest
    if claim.scale == "log" and low > 0.0:
        beyond = (high / low) ** gap
        return _between(claim, float(claim.published), low / beyond, high * beyond)
    beyond = gap * (high - low)
    return _between(claim, float(claim.published), low - beyond, high + beyond)


def happens(claim: Claim, found: Spread) -> bool:
    """Whether a statement is true in a few of our runs at least."""
    return claim.form == "holds" and found.known and (found.mean if claim.published else 1.0 - found.mean) >= RARE


def determines(claim: Claim, found: Spread) -> bool:
    """Whether the interval is narrow enough, and excludes zero where the claim requires that."""
    holds_zero = claim.nonzero and found.low <= 0.0 <= found.high
    return not (holds_zero or _too_wide(claim, found))


def _too_wide(claim: Claim, found: Spread) -> bool:
    if claim.limit == math.inf or not claim.published:
        return False
    return found.high - found.low > claim.limit * abs(float(claim.published))


def agrees(claim: Claim, found: Spread) -> bool:
    """Whether a single run like ours may give what was published.

    Of a censored claim, runs without a number lie beyond the record's end, and a lower bound agrees with them.
    """
    if not found.known:
        return claim.censored and claim.form == "at_least" and found.n > 0
    if claim.form == "holds":
        share = found.mean if claim.published else 1.0 - found.mean
        return share >= 0.5 + HALF_TOLERANCE - ROUNDING
    return _between(claim, float(claim.published), found.low, found.high)


def _between(told: Claim | Reference, value: float, low: float, high: float) -> bool:
    """Whether a value that is told lies in an interval that is widened by the tolerance; of bounds, on its side."""
    slack = max(told.tolerance.around(value), ROUNDING * abs(value))
    low_enough = told.form == "at_least" or low - slack <= value
    high_enough = told.form == "at_most" or value <= high + slack
    return low_enough and high_enough


def within(reference: Reference, found: Spread) -> bool:
    """Whether the median of ours lies within the tolerance of an independent computation."""
    return found.known and _between(reference, reference.value, found.median, found.median)


def _reason(
    claim: Claim,
    corrected: Spread,
    printed: Spread,
    verdict: str,
    tried: tuple[Spread, ...],
    over: str,
    found: Mapping[str, str],
) -> str:
    if claim.missing or claim.unused:
        return claim.missing or claim.unused
    given = claim.reason if isinstance(claim.reason, str) else claim.reason.get(verdict, "")
    if not given and not isinstance(claim.reason, str) and verdict in OPEN:
        given = claim.reason.get("open", "")
    text = given or ("" if claim.unprinted else _default(claim, corrected, printed, verdict))
    filled = text.format(
        published=shown(claim.published),
        corrected=shown(corrected.median),
        as_printed=shown(printed.median) if printed.known else NO_VALUE,
        low=shown(corrected.low),
        high=shown(corrected.high),
        found=found,
    )
    parts = [claim.unprinted, filled, _of_search(claim, verdict, tried, over)]
    return " ".join(part for part in parts if part)


def _of_search(claim: Claim, verdict: str, tried: tuple[Spread, ...], over: str) -> str:
    """What the range of the unprinted settings gave, where it decided the verdict."""
    known = [found for found in tried if found.finite]
    if not claim.search or verdict in (REPRODUCED, CORRECTED) or not known:
        return ""
    if claim.form == "holds":
        share = max(found.mean if claim.published else 1.0 - found.mean for found in known)
        whole = "true at a part of it" if share else "nowhere true"  # of a study that tries the range in one run
        values = f"true in {share:.0%} of {known[0].n} settings" if known[0].n > 1 else whole
    else:
        values = f"{shown(min(f.smallest for f in known), 4)} to {shown(max(f.largest for f in known), 4)}"
    return f"Searched: {over}; found: {values}."


def _default(claim: Claim, corrected: Spread, printed: Spread, verdict: str) -> str:
    if verdict not in OPEN:
        if verdict == REPRODUCED and not claim.as_printed and corrected.n == 1:
            return "Ours agrees."
        return _DEFAULTS[verdict, bool(claim.as_printed)]
    if not (corrected.known or printed.known):
        return "No run gave a finite value."
    both = [found for found in (printed, corrected) if found.known]
    if any(undecided(claim, found) for found in both):
        return f"True in about half of the runs, within {HALF_TOLERANCE:g} of it: such runs do not settle it."
    inside = [found for found in both if agrees(claim, found)]
    if any(_too_wide(claim, found) for found in inside):
        return "The interval of our runs contains it, but is wider than the value itself: they do not determine it."
    if inside:
        return "The interval of our runs contains it, but contains zero as well: such records cannot determine it."
    return "The paper does not print what decides it."


_DEFAULTS = {
    (REPRODUCED, True): "The printed equations give it.",
    (REPRODUCED, False): "It lies within the interval of our runs.",
    (CORRECTED, True): "The corrected equations give it, the printed ones do not ({as_printed}).",
    (CONTRADICTED, True): "Neither the corrected equations ({corrected}) nor the printed ones ({as_printed}) give it.",
    (CONTRADICTED, False): "It lies outside the interval of our runs.",
}


def shown(value: Any, digits: int = 5) -> str:
    """A value as the pages print it: yes or no, a text, or a number."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, int | float):
        return str(value)
    return number(value, digits) if math.isfinite(value) else NO_VALUE
