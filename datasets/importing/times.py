"""The time of a table: which columns it is in, its form, and what is asked where nothing tells."""

from __future__ import annotations

import re
from collections.abc import Mapping as Dict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from ...models.errors import BadInput
from ...models.number_texts import number_of
from .clock import COUNTED, DATED, FORMS, OF_DAY, OF_WEEK, Form, TimeGuess, guess_form, seconds, spread
from .draft import Answer, Question, Sure
from .headers import BRACKETS, read_header
from .mapping import TimeMap, scalar
from .moments import WEEK_S, leap_seconds, start_of_week, utc_of_gps, week_stated
from .names import is_date, is_time, joined, listed, part_of_time, words, writes_day_first
from .quantities import vocabulary, word_list
from .raw import RawColumn, RawTable

ZONE = re.compile(r"\b(utc|gmt|zulu|tu|z)\b|(utc|gmt)$", re.IGNORECASE)
WITH_ZONE = re.compile(
    r".*(\dZ|:\d\d(?:[.,]\d+)?\s?[+-]\d{2}(?::?\d{2})?(?: [A-Z]{3,4})?|T\d{4,6}(?:[.,]\d+)?[+-]\d{2}:?\d{2}|UTC|GMT)$"
)
"""A moment with the offset of its zone; the year of a date is none."""
AHEAD = re.compile(r"\b(?:utc|gmt)\s*([+-])\s*(\d{1,2}(?:\.\d)?)(?::?(\d{2}))?\b", re.IGNORECASE)
"""How much the clocks of a zone are ahead of UTC."""
OF_ZONE = re.compile(r"zone\b|\btimes\b|\bzeiten\b", re.IGNORECASE)
"""Words of a line that states the zone of all times."""
GPS_TIME = frozenset({"gpst", "tow", "itow", "sow"})
"""Words that state GPS time, in which a clock is ahead of UTC by the leap seconds."""
OF_GPS_WEEK = GPS_TIME | {"gms", "week"}
"""Words of a time that counts from the begin of a GPS week."""
SCALE_STATED = re.compile(
    r"\btime[ _-]?(?:system|scale|reference|base|standard)\b[^\n\w]{0,10}(gps|utc)\b", re.IGNORECASE
)
RATE_STATED = re.compile(
    r"(?:sampl|rate|freq|takt|abtast|\bfs\b)\w*[^\d\n]{0,20}(?P<hz>[\d.]+)\s*(?:hz|samples/s)"
    r"|(?:\bfs\b|sampl\w*[ _](?:rate|freq\w*)(?:[ _]hz)?)\s*[=:]\s*(?P<bare>[\d.]+)\s*$"
    r"|^\W*frequency\W+(?P<alone>[\d.]+)\s*$",
    re.IGNORECASE,
)
"""A sampling rate in Hz; without its unit where the name alone can be nothing else."""
STEP_STATED = re.compile(
    r"\b(?:dt|delta t|time ?step|sampl(?:e|ing) (?:interval|time|period|step)|abtast(?:zeit|intervall))\b[^\d\n]{0,12}"
    r"(?P<step>[\d.]+)\s*(?P<unit>s|sec|ms)\b",
    re.IGNORECASE,
)
NEAR_S = 1.5
"""Seconds within which two times of a table are the same."""
HEAD, APART = 400, 0.9
"""Rows that tell how fine a time is, and the share of them with a time of their own."""
SURELY_OF_WEEK_S = 86400.0
"""Seconds from which on a number is no time of day."""
AS_LONG = 0.05
"""Relative difference of their lengths from which on two times are not the same."""
Scale: TypeAlias = Literal["", "UTC", "GPS"]
DAY_S, MONTH_S = 86400.0, 31.0 * 86400.0
"""A day, and the longest time that dates of one log span where other dates are possible."""


@dataclass(frozen=True)
class TableTime:
    """The time of a table.

    columns, form : where it is; form None: open.  likely : the form that is used to compare channels until it is known.
    scale : 'UTC' or 'GPS' where the file states it, the offset from UTC being known; '' where it does not.
    ahead_s : seconds that the clock of a stated zone is ahead of UTC.
    vague : whether the scale is told by a name such as `GPS time`, which stands for the receiver's UTC as well.
    week : GPS week that the file states for seconds of the week.  offset_s : to add to the times, as answered.
    question : what is open.
    """

    columns: tuple[str, ...] = ()
    form: Form | None = None
    likely: Form | None = None
    step_s: float | None = None
    sure: Sure = "stated"
    why: str = ""
    scale: Scale = ""
    question: Question | None = None
    forms: tuple[Form, ...] = ()
    week: int | None = None
    offset_s: float | None = None
    vague: bool = False
    ahead_s: float = 0.0

    def seconds(self, table: RawTable, form: Form | None = None) -> tuple[np.ndarray, str] | None:
        """((N,) seconds, those with a date in UTC since 1970, what was done to them); None where no time is known."""
        used = form or self.form or self.likely
        if used is None:
            return None
        if used == "rows":
            return (self.step_s or 1.0) * np.arange(table.n), ""
        time, done = spread(seconds([c for name in self.columns if (c := table.column(name))], used))
        if used in OF_WEEK and self.week is not None:
            time = time + start_of_week(self.week)
        if self.ahead_s:
            said = f"its zone is {self.ahead_s / 3600.0:+g} h from UTC: set to UTC"
            return time - self.ahead_s, f"{done}; {said}" if done else said
        if self.scale != "GPS" or not self.dated or not np.isfinite(time).any():
            return time, done
        ahead = leap_seconds(float(np.nanmin(time)))
        said = f"GPS time, {ahead:g} s ahead of UTC on that date (leap seconds): set to UTC"
        return utc_of_gps(time), f"{done}; {said}" if done else said

    @property
    def dated(self) -> bool:
        """Whether the times count from 1970."""
        return (self.form or self.likely) in DATED or self.week is not None

    @property
    def zoned(self) -> bool:
        """Whether the file states the offset of its times from UTC."""
        return self.scale != ""

    @property
    def period_s(self) -> float:
        """Seconds after which times without a date are the same again, a day or a week; 0 where they are not."""
        form = self.form or self.likely
        return 0.0 if self.dated else WEEK_S if form in OF_WEEK else DAY_S if form in OF_DAY else 0.0


def find_time(table: RawTable, given: TimeMap | None, answers: Dict[str, str]) -> TableTime:
    """The time of a table, as the map or an answer says, or as the file tells it."""
    key, offset = clock_question(table.label), None
    if key in answers:
        try:
            offset = number_of(answers[key])
        except ValueError:
            hint = "give a number of seconds"
            raise BadInput(f"{answers[key]!r} is no answer to {key!r}", hint=hint) from None
    if given is not None and given.form != "?":
        stated = _with_scale(TableTime(given.columns, given.form, given.form, given.step_s), table)
        return replace(stated, why="the map says so", offset_s=offset)
    spans: dict[str, float] = {}  # of columns that are called times
    for column in (c for c in table.columns if c.known == "" and c.numeric and is_time(c.name) and c.finite.size):
        guess = guess_form(column, _unit(column))
        if guess is not None and guess.stated and guess.forms[0] in COUNTED:
            spans[column.name] = FORMS[guess.forms[0]].seconds * float(np.ptp(column.finite))
    # they do not last equally long: those of the model and of the ship, for example
    differ = len(spans) > 1 and max(spans.values()) > (1.0 + AS_LONG) * min(spans.values())
    rivals = [column for column in table.columns if column.name in spans] if differ else []
    found = None if rivals else _told(table)
    if found is None:
        return replace(_without(table, answers, rivals), offset_s=offset)
    form = answers.get(f"{table.label}/time")
    if found.form is None and form in found.forms:
        found = replace(found, form=form, likely=form, sure="stated", why="as answered", question=None)
    return replace(_with_scale(found, table), offset_s=offset)


def clock_question(label: str) -> str:
    """The id of the question for the offset of a table's clock."""
    return f"{label}/clock"


def _told(table: RawTable) -> TableTime | None:
    """The time that the table tells; None where no column looks like one."""
    parts = _parts(table)
    if parts is not None:
        return parts
    stated = next((column for column in table.columns if column.known == "time"), None)
    scored = []
    for place, column in enumerate(table.columns):
        guess = guess_form(column, _unit(column)) if column.known in ("", "time") else None
        guess = guess and _of_gps(table, column, guess)
        called = is_time(column.name) or column is stated
        counts = bool(set(words(column.name)) & word_list("counters")) and not _unit(column)
        if counts or guess is None:
            continue
        # not called a time: a date with a time of day, or the first and rising evenly
        stamp = guess.forms[0] in DATED and (not column.numeric or guess.forms[0].startswith("epoch"))
        if not (called or stamp or (place == 0 and guess.stated)):
            continue
        texts = guess.stated and not column.numeric
        first = column.values[:HEAD]
        # nearly every row has a time of its own: not a date alone, nor the full seconds of a fast log
        apart = len(set(first.tolist() if isinstance(first, np.ndarray) else first)) > APART * len(first)
        utc = bool(ZONE.search(column.name.replace("_", " "))) and apart
        dated = guess.forms[0] in DATED
        scored.append((column is stated, called, dated, utc, texts, guess.stated, -place, column, guess))
    if not scored:
        return None
    *_, column, guess = max(scored, key=lambda entry: entry[:7])
    names, guess = _with_date(table, column, guess)
    names_of_all = (read_header(c.name).words for c in table.columns)
    if guess.forms == ("day first", "month first") and writes_day_first(names_of_all):
        guess = TimeGuess(("day first",), "the headers are of a language that writes the day first", True)
    sure: Sure = "stated" if guess.stated else "physics"
    if len(guess.forms) == 1:
        return TableTime(names, guess.forms[0], guess.forms[0], None, sure, guess.reason)
    text = f"What is the form of the time in {', '.join(names)}? {guess.reason}; the file does not say it."
    made = tuple(Answer(form, FORMS[form].meaning or form, _time_line(names, form)) for form in guess.forms)
    question = Question(f"{table.label}/time", "time", table.label, names[-1], text, made)
    return TableTime(names, None, guess.forms[0], None, "guess", guess.reason, "", question, guess.forms)


def _parts(table: RawTable) -> TableTime | None:
    """The time of a table that holds its hours, minutes and seconds (and year, month and day) in columns each, or a GPS
    week and its seconds."""
    held = {part: c for c in table.columns if c.numeric and (part := part_of_time(c.name))}
    clock, date = (("hour", "minute", "second"), ("year", "month", "day"))
    if all(part in held for part in clock) and np.nanmax(held["minute"].numbers) < 60.0:
        form: Form = "date parts" if all(part in held for part in date) else "clock parts"
        wanted = (*(date if form == "date parts" else ()), *clock, *(("fraction",) if "fraction" in held else ()))
        names = tuple(held[part].name for part in wanted)
        return TableTime(names, form, form, why=f"columns {', '.join(names)}")
    days = held.get("day of year")
    if days is not None and "year" in held and np.any(days.finite % 1.0):
        names = (held["year"].name, days.name)
        return TableTime(names, "year and day", "year and day", why=f"columns {', '.join(names)}")
    called = (c for c in table.columns if joined(c.name) in listed("week"))
    week = next((c for c in called if c.numeric and _whole(c.numbers)), None)
    place = table.columns.index(week) if week is not None else 0
    of_week = [bool({*words(column.name)} & OF_GPS_WEEK) for column in table.columns]
    near = sorted(range(len(table.columns)), key=lambda i: (not of_week[i], i < place, abs(i - place)))
    for column in (table.columns[i] for i in near) if week is not None else ():
        fine = _unit(column) in FORMS["microseconds"].units + FORMS["nanoseconds"].units
        known = column.finite if column.numeric and is_time(column.name) and not fine else np.zeros(0)
        rising = known.size > 1 and np.mean(np.diff(known) >= 0.0) > 0.95
        if week is not None and column is not week and rising and 0.0 <= known.min() <= known.max() < 1e3 * WEEK_S:
            names = (week.name, column.name)
            return TableTime(names, "gps week", "gps week", why=f"columns {', '.join(names)}")
    return None


def _whole(numbers: np.ndarray) -> bool:
    """Whether numbers (N,) are those of GPS weeks: whole, and one or two that follow each other."""
    known = numbers[np.isfinite(numbers)]
    return bool(known.size and np.array_equal(known, np.round(known)) and 0 <= known.min() <= known.max() < 8192
                and np.ptp(known) <= 1.0)  # fmt: skip


def _of_gps(table: RawTable, column: RawColumn, guess: TimeGuess) -> TimeGuess:
    """The form of a number that counts GPS time, as its name or a date above the table tells; else as guessed."""
    numbers = column.finite if column.numeric else np.zeros(0)
    if not numbers.size or guess.forms[0] not in (*COUNTED, "epoch s"):
        return guess
    name, low, high = set(words(column.name)), float(numbers.min()), float(numbers.max())
    called = bool(GPS_TIME & name) or "week" in name
    by_name = called or "gps" in name
    if guess.forms[0] == "epoch s":
        unix = {"unix", "epoch", "posix", "utc"} & name
        why = "seconds since 1970 in UTC, or since 1980 in GPS time"
        return TimeGuess(("gps s", "epoch s"), why) if by_name and not unix else guess
    thousand = guess.forms[0] == "milliseconds" or (high >= WEEK_S and guess.forms[0] != "seconds")
    size = 1e-3 if thousand else 1.0
    late = size * low > SURELY_OF_WEEK_S and size * high < WEEK_S
    dated = not thousand and late and week_stated(table.notes, numbers) is not None
    if size * high >= WEEK_S or not (called or (by_name and late) or dated):
        return guess
    why = "its name says so" if by_name else "the date above the table lies on that day of the week"
    form: Form = "milliseconds of week" if thousand else "seconds of week"
    return TimeGuess((form,), f"GPS seconds of the week: {why}", True)


def _unit(column: RawColumn) -> str:
    unit = column.unit.strip("[]() ").lower() or (column.lettered.unit if column.lettered else "")
    if unit:
        return unit
    bracketed = next((text for text in BRACKETS.findall(column.name) if re.search(r"\d", text)), "")
    if bracketed:
        return bracketed.strip().lower()
    name = column.called or column.name
    last = words(name)[-1:] or ("",)
    known = {text for facts in FORMS.values() for text in facts.units}
    if len(words(name)) > 1 and last[0] in known:
        return last[0]
    texts = (*(said.lower() for said in column.said), *words(name))
    return next((text for text in texts if text in known and len(text) > 1), "")


def _with_date(table: RawTable, column: RawColumn, guess: TimeGuess) -> tuple[tuple[str, ...], TimeGuess]:
    """The time with the column of the date, where the time is a time of day or a date alone."""
    form = guess.forms[0]
    if form in ("clock", "hhmmss", "day fraction"):
        for date in (c for c in table.columns if c is not column and is_date(c.name)):
            own = _date_of_digits(date) or guess_form(date, "")
            if own is not None and own.forms[0] in ("iso", "ddmmyy", "yymmdd", "day first", "month first", "excel"):
                return (date.name, column.name), own
    if form in ("iso", "day first", "month first") and not any(":" in text for text in column.first(5)):
        for clock in (c for c in table.columns if c is not column):
            own = guess_form(clock, "")
            if own is not None and own.forms[0] in ("clock", "hhmmss"):
                return (column.name, clock.name), guess
    return (column.name,), guess


def _date_of_digits(column: RawColumn) -> TimeGuess | None:
    """The form of a date of six or eight digits; None where it is none."""
    texts = set(column.first(HEAD))
    forms = {6: ("ddmmyy", "yymmdd"), 8: ("yyyymmdd",)}.get(len(min(texts, key=len, default="")), ())
    if column.texts is None or not all(text.isdigit() for text in texts) or len({*map(len, texts)}) > 1:
        return None
    known = RawColumn("", "", [*texts])
    lasts = {form: float(np.ptp(seconds([known], form))) for form in forms}  # nan where one is no date
    able = tuple(form for form in forms if lasts[form] <= MONTH_S) or tuple(f for f in forms if lasts[f] >= 0.0)
    return TimeGuess(able, "digits of a date", len(able) == 1) if able else None


def _time_line(names: tuple[str, ...], form: str) -> str:
    listed = ", ".join(str(scalar(name)) for name in names)
    return f"time: {{columns: [{listed}], form: {form}}}"


def _without(table: RawTable, answers: Dict[str, str], rivals: Sequence[RawColumn] = ()) -> TableTime:
    """A table without a column of the time: logged at a fixed step, which is asked; or with `rivals` to choose from."""
    step = next((step for note in table.notes if (step := step_stated(note))), None)
    if step is not None:
        return TableTime((), "rows", "rows", step, "stated", "a line above the header states the time step")
    key = answers.get(f"{table.label}/time", "")
    with suppress(ValueError):
        if (typed := number_of(key)) > 0.0:
            return TableTime((), "rows", "rows", typed, "stated", "as answered")
    numeric = [c for c in table.columns if c.numeric and len(c.numbers) > 1]
    guesses = {
        c.name: guess_form(c, _unit(c)) for c in rivals or numeric if rivals or np.mean(np.diff(c.numbers) > 0.0) > 0.95
    }
    pairs: dict[str, tuple[str, Form]] = {
        f"{name}: {form}": (name, form) for name, guess in guesses.items() if guess is not None for form in guess.forms
    }
    if key in pairs:
        name, form = pairs[key]
        return TableTime((name,), form, form, why="as answered")
    made = tuple(Answer(key, key, _time_line((name,), form)) for key, (name, form) in pairs.items())
    text = "No column looks like a time: which one is it, or how many seconds are between the rows?"
    if rivals:
        text = f"{' and '.join(c.name for c in rivals)} are times that do not last equally long: which one is it?"
    names = ", ".join(column.name for column in table.columns)
    number = "seconds between the rows: time: {columns: [], form: rows, step_s: NUMBER}"
    at = table.columns[0].name
    question = Question(f"{table.label}/time", "time", table.label, at, f"{text} Columns: {names}.", made, number)
    return TableTime(question=question, sure="guess", why="no column looks like a time")


def step_stated(note: str) -> float | None:
    """The time step that a line states: `sampling rate 10 Hz`, `dt = 0.1 s`."""
    rate, step = RATE_STATED.search(note), STEP_STATED.search(note)
    hertz = next((text for text in rate.groups() if text), "") if rate else ""
    if hertz.strip(".") and float(hertz) > 0.0:
        return 1.0 / float(hertz)
    if step and step["step"].strip(".") and float(step["step"]) > 0.0:
        return float(step["step"]) * (1e-3 if step["unit"].lower() == "ms" else 1.0)
    return None


def _with_scale(time: TableTime, table: RawTable) -> TableTime:
    """The time with its scale, and with the GPS week of its seconds, as the file states them."""
    form = time.form or time.likely
    columns = [column for name in time.columns if (column := table.column(name))]
    if form in OF_WEEK and columns:
        week = week_stated(table.notes, columns[0].numbers * FORMS[form].seconds)
        return replace(time, scale="GPS", week=week)
    ahead = _ahead(table, columns, form)
    if ahead is not None:
        return replace(time, scale="UTC", ahead_s=ahead)
    called = {word for column in columns for word in (*words(column.unit), *words(column.name))}
    scale = _scale(table, columns, form)
    others = (c for c in table.columns if c.numeric and c.name not in time.columns)
    week = next((c for c in others if GPS_TIME & set(words(c.name))), None)
    own = time.seconds(table) if not scale and week is not None and time.dated else None
    if own is not None and week is not None and np.isfinite(own[0]).any():
        # seconds of the GPS week in another column of a table with dates tell it
        gps = week.numbers * (1e-3 if np.nanmax(np.append(week.numbers, 0.0)) > WEEK_S else 1.0)
        ahead = (gps - (own[0] - start_of_week(0))) % WEEK_S
        middle = float(np.nanmedian(ahead)) if np.isfinite(ahead).any() else np.nan
        if abs(middle - float(leap_seconds(float(np.nanmin(own[0]))))) < NEAR_S:
            scale = "UTC"
        elif min(middle, WEEK_S - middle) < NEAR_S:
            scale = "GPS"
    vague = scale == "GPS" and not GPS_TIME & called and {"gps", "time"} <= called and form not in ("gps week", "gps s")
    return replace(time, scale=scale, vague=vague)


def _ahead(table: RawTable, columns: Sequence[RawColumn], form: Form | None) -> float | None:
    """Seconds that clocks of the zone are ahead of UTC that the header of a time, or a line above it, states; None
    where none does, the cells state theirs, or the numbers count from a moment in UTC."""
    shown = [text for column in columns for text in column.first(1)]
    counts = form not in (*DATED, *OF_DAY) or str(form).startswith(("epoch", "gps"))
    zones = vocabulary()["time_zones"]
    texts = [f"{c.name} {c.unit}" for c in columns] + [note for note in table.notes if OF_ZONE.search(note)]
    for text in () if counts or any(map(WITH_ZONE.fullmatch, shown)) else texts:
        match, hours = AHEAD.search(text), next((zones[word] for word in words(text) if word in zones), None)
        if match:
            size = 3600.0 * float(match[2]) + 60.0 * int(match[3] or 0)
            return -size if match[1] == "-" else size
        if hours is not None:
            return 3600.0 * hours
    return None


def _scale(table: RawTable, columns: Sequence[RawColumn], form: Form | None) -> Scale:
    """UTC or GPS, where the file states the offset of its times from UTC."""
    texts = [column.first(1) for column in columns]
    called = [word for column in columns for word in (*words(column.unit), *words(column.name))]
    if any(column.known == "time" for column in columns) or ZONE.search(" ".join(called)):
        return "UTC"
    if any(WITH_ZONE.fullmatch(text[0].strip()) for text in texts if text):
        return "UTC"
    if form in ("gps week", "gps s") or GPS_TIME & set(called) or {"gps", "time"} <= set(called):
        return "GPS"
    stated = {match[1].upper() for note in table.notes for match in SCALE_STATED.finditer(note)}
    if stated in ({"GPS"}, {"UTC"}):
        return "GPS" if stated == {"GPS"} else "UTC"
    numeric = (column.numbers for column in columns if column.numeric and column.numbers.size)
    return "UTC" if any(np.nanmax(np.append(numbers, -1.0)) > 1e8 for numbers in numeric) else ""
