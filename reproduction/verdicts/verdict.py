"""The verdict on a claim: a pure function of the claim and of the spreads of our values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...reporting.numbers import number
from ..claims.claim import Claim, Reference
from .spread import NOTHING, Spread

REPRODUCED = "reproduced"
CORRECTED = "reproduced with correction"
IMPOSSIBLE = "not reproducible"
CONTRADICTED = "contradicted"
NO_VALUE = "no finite value"
VERDICTS = (REPRODUCED, CORRECTED, IMPOSSIBLE, CONTRADICTED)


@dataclass(frozen=True)
class Judged:
    """A claim with what was found and the verdict; `reason` is one sentence."""

    claim: Claim
    corrected: Spread
    as_printed: Spread
    verdict: str
    reason: str


def judge(claim: Claim, values: Mapping[str, Spread], failure: str = "") -> Judged:
    """Compare a claim with the spreads of its study's values.

    A published value counts as equal to ours where it lies in the interval in which a single further run would lie,
    widened by the claim's tolerance; a statement agrees where at least half of our runs do.

    - `reproduced`: the printed equations give it; or ours, where no other were printed.
    - `reproduced with correction`: only the corrected equations give it.
    - `contradicted`: neither do.
    - `not reproducible`: nothing can be computed (`claim.missing`), no run gave a number, or the published value
      only agrees with an interval that does not settle its sign (`claim.nonzero`) or is too wide (`claim.widest`).
    """
    corrected = values.get(claim.corrected, NOTHING)
    printed = values.get(claim.as_printed, NOTHING) if claim.as_printed else NOTHING
    verdict = _verdict(claim, corrected, printed)
    return Judged(claim, corrected, printed, verdict, failure or _reason(claim, corrected, printed, verdict))


def _verdict(claim: Claim, corrected: Spread, printed: Spread) -> str:
    if claim.missing or not (corrected.known or printed.known):
        return IMPOSSIBLE
    first = printed if claim.as_printed else corrected
    if agrees(claim, first) and determines(claim, first):
        return REPRODUCED
    if agrees(claim, corrected) and determines(claim, corrected):
        return CORRECTED
    return IMPOSSIBLE if agrees(claim, first) or agrees(claim, corrected) else CONTRADICTED


def determines(claim: Claim, found: Spread) -> bool:
    """Whether the interval is narrow enough, and excludes zero where the claim requires that."""
    return not (_holds_zero(claim, found) or _too_wide(claim, found))


def _holds_zero(claim: Claim, found: Spread) -> bool:
    return claim.nonzero and found.low <= 0.0 <= found.high


def _too_wide(claim: Claim, found: Spread) -> bool:
    return claim.widest < math.inf and found.high - found.low > claim.widest * abs(float(claim.published))


def agrees(claim: Claim, found: Spread) -> bool:
    """Whether a single run like ours may give what was published."""
    if not found.known:
        return False
    if claim.kind == "holds":
        return (found.mean >= 0.5) == claim.published
    value = float(claim.published)
    slack = claim.tolerance.around(value)
    low_enough = claim.kind == "at_least" or found.low - slack <= value
    high_enough = claim.kind == "at_most" or value <= found.high + slack
    return low_enough and high_enough


def within(reference: Reference, found: Spread) -> bool:
    """Whether the median of ours lies within the tolerance of an independent computation."""
    beyond = found.median - reference.value
    slack = reference.tolerance.around(reference.value)
    low_enough = reference.kind == "at_least" or beyond <= slack
    high_enough = reference.kind == "at_most" or beyond >= -slack
    return found.known and low_enough and high_enough


def _reason(claim: Claim, corrected: Spread, printed: Spread, verdict: str) -> str:
    if claim.missing:
        return claim.missing
    given = claim.reason if isinstance(claim.reason, str) else claim.reason.get(verdict, "")
    text = given or _default(claim, corrected, printed, verdict)
    return text.format(
        published=shown(claim.published),
        corrected=shown(corrected.median),
        as_printed=shown(printed.median) if printed.known else NO_VALUE,
        low=shown(corrected.low),
        high=shown(corrected.high),
    )


def _default(claim: Claim, corrected: Spread, printed: Spread, verdict: str) -> str:
    if verdict == IMPOSSIBLE and (corrected.known or printed.known):
        too_wide = claim.widest < math.inf
        what = "is wider than the value itself" if too_wide else "contains zero as well"
        return f"The interval of our runs contains it, but {what}: such records cannot determine it."
    return _DEFAULTS[verdict, bool(claim.as_printed)]


_DEFAULTS = {
    (REPRODUCED, True): "The printed equations give it.",
    (REPRODUCED, False): "It lies within the interval of our runs.",
    (CORRECTED, True): "The corrected equations give it, the printed ones do not ({as_printed}).",
    (CONTRADICTED, True): "Neither the corrected equations ({corrected}) nor the printed ones ({as_printed}) give it.",
    (CONTRADICTED, False): "It lies outside the interval of our runs.",
    (IMPOSSIBLE, True): "No run gave a finite value.",
    (IMPOSSIBLE, False): "No run gave a finite value.",
}


def shown(value: Any, digits: int = 5) -> str:
    """A value as the pages print it: yes or no, a text, or a number."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, int | float):
        return str(value)
    return number(value, digits) if math.isfinite(value) else NO_VALUE
