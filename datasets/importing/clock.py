"""Times of logs: their forms, and the same in seconds."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeAlias

import numpy as np

from ..time_faults import LONGEST_STEP_S, SHORTEST_STEP_S
from .cells import Texts
from .moments import EPOCH_S, WEEK_S, days_since_1970, moment
from .names import words
from .quantities import names_in, vocabulary
from .raw import RawColumn

Form: TypeAlias = str


@dataclass(frozen=True)
class TimeForm:
    """A form of a time, as `time_forms` in `words.yaml` explains; seconds 0: it is no number."""

    counts: str
    seconds: float = 0.0
    zero: float = 0.0
    numbers: tuple[float, ...] = ()
    units: tuple[str, ...] = ()
    meaning: str = ""


FORMS: dict[Form, TimeForm] = {
    form: TimeForm(**facts | {"units": names_in(facts.get("units", ""))})
    for form, facts in vocabulary()["time_forms"].items()
}
DATED, OF_WEEK, OF_DAY = (
    tuple(form for form, facts in FORMS.items() if facts.counts == origin) for origin in ("date", "week", "midnight")
)
"""Forms that say the date (logs with these have a common time), count from the begin of a GPS week, from midnight."""
COUNTED = ("seconds", "tenths of seconds", "hundredths of seconds", "milliseconds", "microseconds", "nanoseconds",
           "minutes", "hours")  # fmt: skip
"""Forms that count from any moment on."""
DAY, HOUR = 86400.0, 3600.0
DIGITS = ("yyyymmdd", "ddmmyy", "yymmdd")
COUNTERS = (2.0**16, 2.0**32)
"""Numbers at which a counter of 16 or 32 bits begins again."""
MOST_STEPS = 3.0
"""Usual steps within which a clock that begins again goes on."""
WEEKS_OF_TEN_BITS, SINCE_2019 = 1024, 2048
"""Receivers send the week as ten bits, which count from zero since April 2019."""
FEWEST_STAMPS = 10
"""Different stamps from which on rows with equal ones are spread."""
CLOCK = re.compile(r"(\d{1,2}):(\d{2})(?::(\d{2}(?:[.,:]\d+)?))?\s*([AaPp][Mm])?\s*(?:UTC|Z|GMT|LT)?")
ISO = re.compile(r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}([T ].*|-\d{1,2}:\d{2}:.*)?|\d{8}[T ]\d{4,6}.*")
COMPACT = re.compile(r"(?:19|20)\d{2}(?:0[1-9]|1[0-2])(?:0[1-9]|[12]\d|3[01])(?:[01]\d|2[0-3])(?:[0-5]\d){2}(?:\.\d+)?")
"""Date and time of day of fourteen digits: 20240503080000.1."""
TWO_PARTS = re.compile(r"(\d{1,3}):([0-5]\d(?:[.,]\d+)?)")
"""Hours and minutes, or minutes and seconds."""
DECIMALS, OF_MINUTES = re.compile(r"[.,]"), re.compile(r"(?<!:)\b(?:mm?:ss?|min\w*[:/]s\w*)\b")
REPEATED = 0.3
"""Share of rows with the text of the row before from which on it shows no seconds."""
LEAST_SHOWN_S = 0.09
"""Least step of minutes and seconds, s; a hundredth of a minute is shown by smaller numbers."""
NUMERIC_DATE = re.compile(r"(\d{1,2})([./-])(\d{1,2})[./-](\d{2,4})(.*)")
NAMED_DATE = re.compile(r"\d{1,2}[- ][A-Za-z]{3}[- ]\d{2,4}.*")


MULTIPLE = re.compile(r"[x*]?\s*(1\s*/)?\s*(\d*\.?\d+)\s*[x*]?\s*([a-zµμ秒]+)|([a-zµμ秒]+)\s*/\s*(\d+)")
"""A unit with a factor: `0.1 s`, `1/10 s`, `100 ms`, `s/10`."""
SHORTEST_S, LONGEST_S, LEAST_SPAN_S = 0.004, 30.0, 10.0
"""Time steps of a log, and its shortest length."""
FEWEST_WHOLE = 2.0
"""Step of whole numbers from which on they may be parts of a second."""
ROUND = (1.0, 2.0, 2.5, 4.0, 5.0)


@dataclass(frozen=True)
class TimeGuess:
    """The forms that a time column may have, likeliest first, why, and whether the file states it."""

    forms: tuple[Form, ...]
    reason: str
    stated: bool = False


def guess_form(column: RawColumn, unit: str) -> TimeGuess | None:
    """The form of a column as a time; None where it can be none."""
    if column.texts is not None and _all(COMPACT, column):
        return TimeGuess(("iso",), "form of the texts", True)
    if column.numeric and not (column.lettered and column.lettered.positive):
        return _guess_number(column.numbers, unit.lower())
    texts = column.first(200)
    if not texts:
        return None
    if _all(TWO_PARTS, column):
        return _of_two_parts(texts, f"{column.name} {unit}".lower())
    for form, pattern in (("clock", CLOCK), ("iso", ISO), ("day first", NAMED_DATE)):
        if _all(pattern, column):
            return TimeGuess((form,), "form of the texts", True)
    dates = [match for text in texts if (match := NUMERIC_DATE.fullmatch(text))]
    if len(dates) < len(texts) or column.texts is None:
        return None
    if any(int(match[1]) > 12 for match in dates):
        return TimeGuess(("day first",), "a day above 12", True)
    if any(int(match[3]) > 12 for match in dates):
        return TimeGuess(("month first",), "a day above 12", True)
    if dates[0][2] == "." or all(match[1] == match[3] for match in dates):
        return TimeGuess(("day first",), "form of the date", True)
    every = [match for text in column.texts.unique() if (match := NUMERIC_DATE.fullmatch(text))]
    firsts, seconds_ = ({match[place] for match in every} for place in (1, 3))
    if len(firsts) != len(seconds_) and min(len(firsts), len(seconds_)) == 1:
        why = "the day changes at midnight, the month does not"
        return TimeGuess(("day first" if len(firsts) > 1 else "month first",), why, True)
    return TimeGuess(("day first", "month first"), "day and month could be exchanged")


def _of_two_parts(texts: Sequence[str], header: str) -> TimeGuess | None:
    """The form of a clock of two parts: as the header says; hours and minutes where rows repeat it; minutes and seconds
    where the first part is no hour, or it begins at zero, or has decimals that go in usual steps; else either."""
    steps = np.abs(np.diff([_of_minutes(text) for text in texts]))
    if any(map(DECIMALS.search, texts)):
        usual = np.any(steps > 0.0) and float(np.median(steps[steps > 0.0])) > LEAST_SHOWN_S
        return TimeGuess(("mm:ss",), "form of the texts", True) if usual else None
    if OF_MINUTES.search(header):
        return TimeGuess(("mm:ss",), "the header says it", True)
    if not steps.size or float(np.mean(steps == 0.0)) > REPEATED or "hh:mm" in header:
        return TimeGuess(("clock",), "form of the texts", True)
    minutes = [int(text.partition(":")[0]) for text in texts]
    if max(minutes) > 23 or not _clock(texts[0]):
        return TimeGuess(("mm:ss",), "another minute in every row is none of a manoeuvre")
    return TimeGuess(("mm:ss", "clock"), "hours and minutes, or minutes and seconds")


def _all(pattern: re.Pattern[str], column: RawColumn) -> bool:
    """Whether the first texts of a column are of a form."""
    texts = column.first(200)
    return bool(texts) and all(pattern.fullmatch(text) for text in texts)


def _guess_number(numbers: np.ndarray, unit: str) -> TimeGuess | None:
    known = numbers[np.isfinite(numbers)]
    if known.size < 2 or np.ptp(known) == 0.0:
        return None
    steps = np.diff(known)
    rising = bool(np.mean(steps >= 0.0) > 0.95)
    low, high = float(known.min()), float(known.max())
    stated = _stated(unit)
    for form, (least, most) in ((form, facts.numbers) for form, facts in FORMS.items() if facts.numbers):
        fits = form not in ("excel", "datenum") or (np.median(steps) < 0.05 and stated is None)
        if rising and least <= low and high <= most and fits:
            return TimeGuess((form,), f"values near {low:.6g}")
    if stated is not None:
        return _by_unit(stated, unit, steps, high - low) if rising else TimeGuess((stated,), f"unit {unit}", True)
    if re.search(r"\d", unit) and re.search(r"[a-z]", unit):  # a unit of its own, which no word of the name replaces
        return TimeGuess(COUNTED, f"the unit {unit} is not known")
    if _is_hhmmss(known):
        return TimeGuess(("hhmmss",), "no value has minutes or seconds above 59, and it jumps after them")
    if low >= 0.0 and high <= 1.0 and 0.0 < np.median(np.abs(steps)) < 1e-3:
        return TimeGuess(("day fraction",), "values between 0 and 1 in steps of less than a second of a day")
    return _by_step(steps, high - low) if rising else None


def _stated(unit: str) -> Form | None:
    """The form that a unit states, also one with a factor; None where it is not known."""
    form: Form | None = next((form for form, facts in FORMS.items() if unit in facts.units), None)
    match = None if form else MULTIPLE.fullmatch(unit.strip())
    if match is None:
        return form
    text, number = (match[3], float(match[2])) if match[3] else (match[4], 1.0 / max(float(match[5]), 1e-300))
    base: Form | None = next((form for form, facts in FORMS.items() if text in facts.units and facts.seconds), None)
    if base is None or number <= 0.0:
        return None
    size = FORMS[base].seconds * (1.0 / number if match[1] else number)
    return next((form for form in COUNTED if abs(FORMS[form].seconds / size - 1.0) < 1e-6), None)


def _by_unit(stated: Form, unit: str, steps: np.ndarray, span: float) -> TimeGuess:
    """The form that the unit states; where no log has such steps and another form makes them usual, both: ask."""
    moved = float(np.median(steps[steps > 0.0])) if stated in COUNTED and np.any(steps > 0.0) else 0.0
    if moved and not SHORTEST_STEP_S <= FORMS[stated].seconds * moved <= LONGEST_STEP_S:
        by_step = _by_step(steps, span)
        forms = by_step.forms if by_step else ()
        others: list[Form] = [f for f in forms if SHORTEST_S <= FORMS[f].seconds * moved <= LONGEST_S]
        if others:
            why = f"the unit {unit} gives steps of {FORMS[stated].seconds * moved:.4g} s, in which no log is written"
            return TimeGuess((*others, stated), why)
    return TimeGuess((stated,), f"unit {unit}", True)


def _by_step(steps: np.ndarray, span: float) -> TimeGuess | None:
    """Forms whose step is one of a log: those with a round step, or else all."""
    moved = steps[steps > 0.0]
    if not moved.size:
        return None
    step = float(np.median(moved))
    forms: tuple[Form, ...] = ("seconds", "milliseconds", "minutes", "microseconds", "nanoseconds", "hours")
    usual: list[Form] = [form for form in forms if SHORTEST_S <= FORMS[form].seconds * step <= LONGEST_S]
    able: list[Form] = [form for form in usual if FORMS[form].seconds * span >= LEAST_SPAN_S]
    even: list[Form] = [form for form in able if _is_round(FORMS[form].seconds * step)]
    found: tuple[Form, ...] = tuple(even or able)
    if found == ("seconds",) and step >= FEWEST_WHOLE and np.array_equal(moved, np.round(moved)):
        return TimeGuess(COUNTED[:3], f"whole numbers in steps of {step:.4g}")
    if not found:
        return TimeGuess(("seconds", "milliseconds", "minutes"), f"steps of {step:.4g}")
    return TimeGuess(found, f"steps of {step:.4g}: no other unit gives steps of a log")


def _is_round(step: float) -> bool:
    """Whether a step is 1, 2, 2.5, 4 or 5 times a power of ten, or a whole number of samples a second, within 2 %."""
    mantissa = step / 10.0 ** math.floor(math.log10(step) + 1e-9)
    rate = 1.0 / step
    whole = 1.0 <= rate <= 120.0 and abs(rate - round(rate)) < 0.02
    return whole or any(abs(mantissa / value - 1.0) < 0.02 for value in (*ROUND, 10.0))


def _is_hhmmss(known: np.ndarray) -> bool:
    """Whether numbers are clock times such as 235959.5: minutes and seconds below 60, and usual steps at full minutes,
    where the numbers jump."""
    if not (np.all(known >= 0.0) and np.all(known < 240000.0)) or known.max() <= 10000:
        return False
    whole = known.astype(np.int64)
    sound = np.all((whole % 100 < 60) & (whole // 100 % 100 < 60))
    steps, full = np.diff(_from_hhmmss(known)), np.diff(whole // 100) > 0
    usual = float(np.median(steps[~full])) if not full.all() else 0.0
    return bool(sound and full.any() and np.mean((steps[full] > 0.0) & (steps[full] < MOST_STEPS * usual)) > 0.5)


def seconds(columns: Sequence[RawColumn], form: Form) -> np.ndarray:
    """(N,) seconds: since 1970 for forms with a date (UTC unless the text names a zone), else of the log's own clock.

    columns : the time, or the date and the time of day.  nan where a cell is no time.
    """
    if form in ("date parts", "clock parts"):
        whole = 6 if form == "date parts" else 3
        *date, hour, minute, second = (column.numbers for column in columns[:whole])
        found = 3600.0 * hour + 60.0 * minute + second
        if date:
            known = np.logical_and.reduce([np.isfinite(part) for part in date])
            days = days_since_1970(*(np.where(known, part, 1.0).astype(np.int64) for part in date))
            found = np.where(known, DAY * days + found, np.nan)
        else:
            found = _over_midnight(found)
        for column in columns[whole:]:  # nano-, micro- or milliseconds; not known ones are none
            own = words(column.name)[-1]
            size = 1e-9 if own.startswith("n") else 1e-6 if own.startswith(("micro", "us")) else 1e-3
            found = found + size * np.nan_to_num(column.numbers)
        return found
    if form == "year and day":
        year, day = (column.numbers for column in columns)
        return DAY * (days_since_1970(np.nan_to_num(year, nan=1970.0), np.ones(day.size), day))
    if form == "gps week":
        week, second = (column.numbers for column in columns)
        second = second * (1e-3 if np.nanmax(second, initial=0.0) > WEEK_S else 1.0)
        return EPOCH_S + WEEK_S * np.where(week < WEEKS_OF_TEN_BITS, week + SINCE_2019, week) + second
    if form in DIGITS and len(columns) == 1:
        return (columns[0].texts or Texts([])).mapped(partial(_of_digits, form=form))
    if len(columns) == 2:
        date, clock = seconds(columns[:1], form), _time_of_day(columns[1])
        if np.isfinite(date).any() and np.ptp(date[np.isfinite(date)]) > 0.0:
            return date + clock
        return date + _over_midnight(clock)
    column = columns[0]
    if form == "mm:ss" and column.texts is not None:
        return _going_on(column.texts.mapped(_of_minutes), HOUR)
    if form == "clock":
        clock = _over_midnight(_time_of_day(column))
        return _going_on(clock, DAY / 2.0)
    if form == "hhmmss":
        return _over_midnight(_from_hhmmss(column.numbers))
    if form == "day fraction":
        return _over_midnight(DAY * column.numbers)
    if FORMS[form].seconds:
        factor, offset, numbers = FORMS[form].seconds, FORMS[form].zero, column.numbers
        if form in COUNTED and (np.diff(numbers) < 0.0).any():
            for period in (*COUNTERS, DAY / factor, WEEK_S / factor):
                numbers = _going_on(numbers, period)
        return numbers * factor + offset
    # dates with times as seconds since 1970 (N,), computed once for each form; nan where a text is none
    texts = column.texts
    if texts is None:
        return np.full(len(column.values), np.nan)
    if form not in column.times:
        column.times[form] = _moments(texts, form)
    return column.times[form]


def _moments(texts: Texts, form: Form) -> np.ndarray:
    """Dates with times as seconds since 1970 (N,); nan where a text is none."""
    even = texts.moments() if form == "iso" and texts.arrow is not None else None
    return texts.mapped(partial(moment, month_first=form == "month first")) if even is None else even


def _time_of_day(column: RawColumn) -> np.ndarray:
    if column.texts is None or column.numeric:
        numbers = column.numbers
        known = numbers[np.isfinite(numbers)]
        return DAY * numbers if known.size and known.max() <= 1.0 else _from_hhmmss(numbers)
    return column.texts.mapped(_clock)


def _of_digits(text: str, form: Form) -> float:
    parts = [text[:2], text[2:4], text[4:]][:: -1 if form == "yymmdd" else 1]
    return moment(text if form == "yyyymmdd" else "-".join(parts))


def _of_minutes(text: str) -> float:
    found = TWO_PARTS.fullmatch(text)
    return 60.0 * int(found[1]) + float(found[2].replace(",", ".")) if found else math.nan


def _clock(text: str) -> float:
    text = text.rsplit(" ", 1)[-1] if re.match(r"\d{4}-", text) else text
    match = CLOCK.fullmatch(text)
    if not match:
        return math.nan
    hour, minute = int(match[1]), int(match[2])
    second = match[3] or "0"
    second = float(second.replace(",", ".").replace(":", "."))
    if match[4]:
        hour = hour % 12 + (12 if match[4].lower() == "pm" else 0)
    return 3600.0 * hour + 60.0 * minute + second if hour < 24 and minute < 60 and second < 61.0 else math.nan


def _from_hhmmss(numbers: np.ndarray) -> np.ndarray:
    return 3600.0 * (numbers // 10000) + 60.0 * (numbers // 100 % 100) + numbers % 100


def _over_midnight(clock: np.ndarray) -> np.ndarray:
    """Times of day (N,) that go on after midnight."""
    out, known = clock.copy(), np.flatnonzero(np.isfinite(clock))
    steps = np.diff(clock[known])
    out[known[1:]] += DAY * np.cumsum(steps < -DAY / 2.0)
    return out


def _going_on(clock: np.ndarray, period: float) -> np.ndarray:
    """Times (N,) of a clock that shows those within a period, going on where it begins again: the next time but for the
    period is the next step."""
    places = np.flatnonzero(np.isfinite(clock))
    known = clock[places]
    steps = np.diff(known)
    back = steps < 0.0
    if not back.any() or known.min() < 0.0 or np.ptp(known) > period:
        return clock
    usual = float(np.median(steps[~back])) if not back.all() else 0.0
    again = back & (steps + period > 0.0) & (steps + period < MOST_STEPS * usual)
    out = clock.copy()
    out[places[1:]] += period * np.cumsum(again)
    return out


def spread(time: np.ndarray) -> tuple[np.ndarray, str]:
    """Times (N,) of a clock of full seconds or of few digits, with the rows of one stamp spread evenly; what was
    done.

    Only where at least a third of the rows repeat the stamp before them, and about equally many share every stamp, or
    all stamps are those of even steps within their rounding.
    """
    steps = np.diff(time)
    if steps.size < 3 or np.isnan(steps).any() or (steps < 0.0).any() or np.mean(steps == 0.0) < 1.0 / 3.0:
        return time, ""
    first = np.flatnonzero(np.concatenate([[True], steps > 0.0]))
    if first.size < FEWEST_STAMPS:
        return time, ""
    counts, rows, repeated = np.diff(first), np.arange(time.size), int(np.sum(steps == 0.0))
    if np.ptp(counts[1:]) > 1.0 + 0.2 * np.median(counts):
        slope, start = np.polyfit(rows, time, 1)
        even = start + slope * rows
        if np.abs(time - even).max() > steps.max():
            return time, ""
        return even, f"{repeated} rows repeat a rounded time: spread evenly, {slope:.4g} s apart"
    inner = first[1:]
    slope = (time[inner[-1]] - time[inner[0]]) / (inner[-1] - inner[0]) if inner.size > 1 else steps.mean()
    out = np.interp(rows, inner, time[inner])
    out = np.where(rows < inner[0], time[inner[0]] - (inner[0] - rows) * slope, out)
    out = np.where(rows > inner[-1], time[inner[-1]] + (rows - inner[-1]) * slope, out)
    return out, f"{repeated} rows repeat the time of the row before: spread evenly, {slope:.4g} s apart"
