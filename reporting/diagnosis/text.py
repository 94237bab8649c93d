"""What a diagnosis says in words and short numbers: for the terminal, the page and the Markdown form alike."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Entry, Finding, Gain, Size

DEG = 180.0 / math.pi
NOTHING = "–"
IN_DEGREES = {"rad": "deg", "rad/s": "deg/s"}
SHARES = ("e", "s", "share", "fraction")
"""Parameters without unit that are told in per cent."""
CHANNEL_WORDS = {
    "heading_rad": ("heading", "deg", DEG),
    "yaw_rate_rad_s": ("yaw rate", "deg/s", DEG),
    "surge_m_s": ("surge", "m/s", 1.0),
    "sway_m_s": ("sway", "m/s", 1.0),
    "north_m": ("north", "m", 1.0),
    "east_m": ("east", "m", 1.0),
    "position_m": ("position", "m", 1.0),
}
STATUS_ORDER = ("named", "tied", "explained_by", "not_significant", "not_testable")


def channel(name: str) -> tuple[str, str, float]:
    """Spoken name, unit and factor of a channel."""
    return CHANNEL_WORDS.get(name, (name, "", 1.0))


def number(value: float | None, digits: int = 3) -> str:
    """A short number; a dash where there is none."""
    if value is None or math.isnan(value):
        return NOTHING
    if math.isinf(value):
        return "inf" if value > 0 else "−inf"
    text = f"{value:.{digits}g}" if value == 0.0 or 1e-3 <= abs(value) < 1e5 else f"{value:.{max(digits - 1, 0)}e}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def size(item: Size) -> str:
    """`delta0 0.31 deg [0.28, 0.34]`, in degrees or per cent where people think in them."""
    factor, unit = scale(item)
    value, low, high = (factor * x for x in (item.value, item.low, item.high))
    digits = _digits(value, low, high)
    where = f" in {item.record}" if item.record else ""
    told = f"{item.parameter} {number(value, digits)} {unit}".rstrip()
    return f"{told} [{number(low, digits)}, {number(high, digits)}]{where}"


def _digits(value: float, low: float, high: float) -> int:
    """Significant digits that show the interval's width with two of them."""
    width, largest = abs(high - low), max(abs(value), abs(low), abs(high))
    if not (math.isfinite(width) and math.isfinite(largest)) or width <= 0.0:
        return 3
    return min(max(2 + math.ceil(math.log10(largest / width)), 2), 8)


def scale(item: Size) -> tuple[float, str]:
    """Factor and unit in which a size is told."""
    if item.unit in IN_DEGREES:
        return DEG, IN_DEGREES[item.unit]
    if item.unit in ("1", "fraction") and item.parameter.partition(":")[0] in SHARES:
        return 100.0, "%"
    return 1.0, "" if item.unit == "1" else item.unit


def cause(name: str) -> str:
    """`rudder_offset` as people say it."""
    return name.replace("_", " ")


def tie(finding: Finding) -> str:
    """The cause, with those that it cannot be told from."""
    return " or ".join(map(cause, (finding.cause, *finding.tied_with)))


def p_value(value: float | None) -> str:
    """An adjusted p-value, short."""
    if value is None or math.isnan(value):
        return NOTHING
    return "< 1e-16" if value < 1e-16 else f"{value:.1e}" if value < 1e-3 else f"{value:.3f}"


def verdict(found: Diagnosis) -> str:
    """The sentence that stands first."""
    named = [f"{tie(f)} ({'; '.join(map(size, f.sizes[:3]))})" if f.sizes else tie(f) for f in found.causes]
    causes = " and ".join([", ".join(named[:-1]), named[-1]] if len(named) > 1 else named)
    opening = {
        "adequate": "The simulation agrees with the records: no cause of the bank is needed.",
        "inconclusive": "The records decide nothing.",
        "unexplained": "The simulation is wrong in a way that no cause of the bank explains"
        + (f"; of its causes {causes} fit best." if causes else "."),
        "named": f"The simulation misses {causes}.",
        "tied": f"The simulation misses {causes}; the records cannot tell the tied causes apart.",
    }[found.verdict]
    return " ".join(part for part in (opening, gain_sentence(found)) if part)


def gain_sentence(found: Diagnosis) -> str:
    """What the extension is worth on held-out records; empty where there is no gain to tell."""
    shown = [name for name in ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s") if name in found.gain]
    if not shown or not found.causes:
        return ""
    told = []
    for name in shown[:2]:
        gain, (word, unit, factor) = found.gain[name], channel(name)
        before, after = number(factor * gain.rmse_before), number(factor * gain.rmse_after)
        told.append(f"{word} from {before} to {after} {unit}")
    return f"With it the free-run error on held-out records goes: {', '.join(told)}."


def ratio(gain: Gain) -> str:
    """Error after over before, with its interval."""
    middle = gain.rmse_after / gain.rmse_before if gain.rmse_before > 0.0 else math.nan
    return f"{number(middle)} [{number(gain.ratio_low)}, {number(gain.ratio_high)}]"


def ordered_bank(found: Diagnosis) -> list[Entry]:
    """The bank: what passed first, then by evidence."""

    def key(entry: Entry) -> tuple:
        place = STATUS_ORDER.index(entry.status) if entry.status in STATUS_ORDER else len(STATUS_ORDER)
        p = 2.0 if entry.p_adjusted is None else entry.p_adjusted
        return place, p, -(entry.statistic or 0.0), entry.cause

    return sorted(found.bank, key=key)


def gain_rows(found: Diagnosis) -> list[tuple[str, ...]]:
    """Channel, RMSE before and after, ratio with interval, R^2 before and after, share of the gap closed."""
    rows = []
    for name, gain in found.gain.items():
        word, unit, factor = channel(name)
        rmse = [f"{number(factor * value)} {unit}".rstrip() for value in (gain.rmse_before, gain.rmse_after)]
        r2 = [_fixed(value, 3) for value in (gain.r2_before, gain.r2_after)]
        closed = NOTHING if math.isnan(gain.closed) else f"{_fixed(100.0 * gain.closed, 0)} %"
        rows.append((word, *rmse, ratio(gain), *r2, closed))
    return rows


def hypothesis(found: Diagnosis) -> list[tuple[str, str]]:
    """The term that fits an unexplained effect best, as pairs of texts."""
    facts = found.hypothesis or {}
    rows = [("kind", cause(str(facts.get("hypothesis", ""))))]
    rows += [(f"{term['term']} on {term['acts_on']}", number(float(term["size"]))) for term in facts.get("terms", ())]
    told = {True: "confirmed", False: "rejected", None: "not tested"}
    confirmed = facts.get("confirmed_on_held_out")
    return [*rows, ("on held-out records", told[None if confirmed is None else bool(confirmed)])]


def _fixed(value: float, decimals: int) -> str:
    return NOTHING if math.isnan(value) else f"{value:.{decimals}f}".replace("-", "−")


GAIN_COLUMNS = ("channel", "RMSE before", "RMSE after", "after/before [90 %]", "R² before", "R² after", "gap closed")


def terminal(found: Diagnosis) -> str:
    """The verdict, a line a cause, and the gain, in plain text."""
    lines = [f"{found.verdict}: {verdict(found)}", *([found.reason] if found.reason else [])]
    for finding in found.causes:
        lines.append(f"  {tie(finding)}  (stage {finding.stage}, adjusted p {p_value(finding.p_adjusted)})")
        lines += [f"    {size(item)}" for item in finding.sizes]
        lines += [f"    {text}" for text in (finding.evidence, _separate(finding)) if text]
    if found.gain:
        lines += table([GAIN_COLUMNS, *gain_rows(found)])
    elif not any(role == "held_out" for _, role in found.records):
        lines.append("no held-out records: the gain was not measured")
    lines += [f"next manoeuvre: {found.next_manoeuvre}"] if found.next_manoeuvre else []
    return "\n".join(lines)


def _separate(finding: Finding) -> str:
    return f"to tell them apart: {finding.separate_by}" if finding.tied_with and finding.separate_by else ""


def table(rows: list[tuple[str, ...]], pad: Callable[[str, int], str] = str.ljust) -> list[str]:
    """Rows of texts in columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [
        "  " + "  ".join(pad(text, width) for text, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
