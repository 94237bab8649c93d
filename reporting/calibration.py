"""What a calibration says: the numbers that moved, step by step, and what remains."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from .diagnosis.words import channel, in_line, sentence, worse
from .numbers import DEG, interval, number, percent, with_unit
from .page import BAD, FAIR, GOOD, Section, Verdict, equation_parts, overlays, result_page, sides
from .runs import of_trace
from .tables import Column, Table, field, make_table, numeric

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ..diagnosis.calibration.result import Calibration, Moved
    from .page import Page

VERDICTS = {
    "adequate": (GOOD, "The model agrees with the records."),
    "named": (GOOD, "What the model gets wrong is explained by"),
    "tied": (FAIR, "What the model gets wrong is explained, as others would do as well, by"),
    "partly_named": (FAIR, "A part of what the model gets wrong is explained by"),
    "unexplained": (BAD, "No number of the model explains what it gets wrong."),
}
"""Verdict -> how it is set off, and its first sentence, which the numbers that moved end where some explain."""
MOST_NAMED = 4
"""Numbers that the first sentence names."""
DEGREES = ("rudder_offset",)
"""Numbers that are shown in degrees."""
BASE = "base model"
STEPS = (
    "Root mean square errors of free runs. Left out: pieces of training records, with starts of their own, each "
    "predicted by a fit without it. Of held-out records only that is used that a change which worsens them is "
    "withdrawn."
)


def page(calibration: Calibration) -> Page:
    """The page of a calibration."""
    told = [sentence(calibration.reason), worse(calibration.worse, "extended") if calibration.worse else ""]
    first, each = overlays([of_trace(trace, bool(calibration.moved)) for trace in calibration.traces])
    new, every = equation_parts(calibration.extended, calibration.model)
    return result_page(
        f"Calibration of {calibration.model.id}",
        f"{calibration.model.title or calibration.model.family}; {sides(calibration.records)}",
        Verdict(
            VERDICTS[calibration.verdict][0],
            first_sentence(calibration),
            tuple(filter(None, told)),
            calibration.verdict.replace("_", " "),
        ),
        seen=[first, models_table(calibration)],
        changed=[make_table(MOVED, calibration.moved), new] if calibration.moved else ["No number of the model moved."],
        remains=[
            shares_table(calibration),
            make_table(REMAINING, calibration.remaining, "Where the remaining error lies"),
        ],
        following=[next_sentence(calibration) if calibration.next_runs else None],
        details=[
            Section("Step by step", (steps_table(calibration),)),
            Section("What every ingredient removes of the squared error", (ingredients_table(calibration),)),
            Section("Neutral rudder angle of every training record", (make_table(RUNS, calibration.runs),)),
            each,
            *([every] if calibration.moved else []),
        ],
        doubts=calibration.doubts,
    )


def first_sentence(calibration: Calibration) -> str:
    """The verdict with the numbers that moved, and what they do to the error of the heading, or of a first channel."""
    said = VERDICTS[calibration.verdict][1]
    if said.endswith(".") or not calibration.moved:
        return f"{said.rstrip('.').removesuffix(' by')}."
    named = [_in_a_word(moved) for moved in calibration.moved]
    named = [*named[:MOST_NAMED], f"{len(named) - MOST_NAMED} more"] if len(named) > MOST_NAMED + 1 else named
    return f"{said} {in_line(named)}{_errors(calibration)}."


def _in_a_word(moved: Moved) -> str:
    """`R_0 +25 %`, or the value of a number that was zero."""
    change = (
        f"{moved.percent:+.0f} %" if moved.percent is not None else with_unit(_scale(moved) * moved.after, _unit(moved))
    )
    return f"{moved.name} {change}{f' {moved.where}' if moved.where else ''}"


def _errors(calibration: Calibration) -> str:
    column = "heading_rad" if "heading_rad" in calibration.before else next(iter(calibration.before), "")
    if column not in calibration.after:
        return ""
    place = 1 if calibration.before[column][1] is not None else 0
    before, after, (word, unit, factor) = (
        calibration.before[column][place],
        calibration.after[column][place],
        channel(column),
    )
    if before is None or after is None:
        return ""
    change = f"from {number(factor * before)} to {number(factor * after)} {unit}"
    return f"; {('left-out', 'held-out')[place]} error of the {word} {change}"


def next_sentence(calibration: Calibration) -> str:
    """What to sail or measure next."""
    runs = ", ".join(
        f"{run.manoeuvre} (information {number(run.information, 2)} nats)" for run in calibration.next_runs
    )
    return f"Manoeuvres that would tell most about the numbers that are open: {runs}."


def _scale(m: Moved) -> float:
    return DEG if m.name in DEGREES else 1.0


def _unit(m: Moved) -> str:
    return "deg" if m.name in DEGREES else ""


def _change(m: Moved) -> str:
    return "" if m.percent is None else f"{m.percent:+.0f} %{', in proportion' if m.in_proportion else ''}"


def _after(m: Moved) -> str:
    factor = _scale(m)
    return interval(factor * m.after, factor * m.low, factor * m.high)


MOVED = (
    field("name", "number"),
    Column("group", lambda m: m.group.replace("_", " ")),
    Column("before", lambda m: number(_scale(m) * m.before), lambda m: m.before),
    Column("after, 90 % interval", _after, lambda m: m.after),
    Column("unit", _unit),
    Column("change", _change, lambda m: m.percent),
    Column("where", lambda m: m.where or "everywhere"),
    numeric("in prior standard deviations", lambda m: m.prior_sds, "{:+.1f}".format),
)


def steps_table(calibration: Calibration) -> Table:
    """Errors of pieces that were left out, and of held-out records, from the base model through every step."""
    rows: list[tuple[str, Mapping[str, float], Mapping[str, float], str, str]]
    rows = [(BASE, {c: old for c, (old, _) in calibration.before.items()}, _held(calibration), "", "")]
    rows += [
        (f"+ {s.title}", s.left_out, s.held_out, f"{s.gain:.2f} ± {s.standard_error:.2f}", ", ".join(s.tied_with))
        for s in calibration.steps
    ]
    columns = [Column("model", lambda row: row[0])]
    for column in calibration.before:
        word, unit, factor = channel(column)
        for place, side in ((1, "left out"), (2, "held out")):
            errors = partial(lambda at, c, row: row[at].get(c), place, column)
            columns.append(numeric(f"{word}, {unit}, {side}", errors, _or_blank, factor))
    columns += [
        Column("fall of the score", lambda row: row[3]),
        Column("would do as well", lambda row: row[4].replace("_", " ")),
    ]
    return make_table(columns, rows, note=STEPS)


def _held(calibration: Calibration) -> dict[str, float]:
    return {c: new for c, (_, new) in calibration.before.items() if new is not None}


def _or_blank(value: float | None, form: Callable[[Any], str] = number) -> str:
    return "" if value is None else form(value)


def shares_table(calibration: Calibration) -> Table:
    """What each channel's squared free-run error of the base model consists of."""
    names = (
        ("numbers that moved", "coefficients"),
        ("start of single pieces", "trim"),
        ("sensor noise", "noise"),
        ("remaining", "remaining"),
    )
    columns = [
        Column("channel", lambda row: channel(row[0])[0]),
        *(numeric(title, lambda row, name=name: getattr(row[1], name), percent) for title, name in names),
    ]
    return make_table(columns, list(calibration.shares.items()), "What the error of the base model consists of")


def models_table(calibration: Calibration) -> Table:
    """Errors of held-out records, of left-out pieces of training records where none are held out, by every model; with
    each held-out record's own neutral rudder angle and start; and the floor: the error of a fit to these records
    themselves."""
    place = 1 if any(new is not None for _, new in calibration.before.values()) else 0
    models = (
        (BASE, calibration.before),
        ("numbers that moved", calibration.after),
        ("all numbers, under their priors", calibration.predicted or calibration.after),
    )
    columns = [Column("channel", lambda c: channel(c)[0]), Column("unit", lambda c: channel(c)[1])]
    columns += [_model_column(title, {c: pair[place] for c, pair in errors.items()}) for title, errors in models]
    for place, title in enumerate(("base model", "all numbers") if calibration.own else ()):
        own = {c: pair[place] for c, pair in calibration.own.items()}
        columns.append(_model_column(f"{title}, own neutral angle and start", own))
    columns += [_model_column("floor of the structure", calibration.floor)] if calibration.floor else []
    side = "held-out records" if place else "left-out pieces of training records"
    return make_table(columns, list(calibration.before), f"Errors of {side}")


def _model_column(title: str, errors: Mapping[str, float | None]) -> Column:
    shown = {column: channel(column)[2] * value for column, value in errors.items() if value is not None}
    return numeric(title, shown.get, _or_blank)


def ingredients_table(calibration: Calibration) -> Table:
    """Share of the squared error of left-out pieces that every ingredient removes: it comes back where all numbers are
    fitted again without it."""
    columns = [
        field("what", "ingredient"),
        *(
            numeric(channel(column)[0], lambda one, c=column: one.removes.get(c), partial(_or_blank, form=percent))
            for column in calibration.before
        ),
    ]
    note = "Of left-out pieces; all numbers are fitted again without it."
    return make_table(columns, calibration.ingredients, note=note)


REMAINING = (
    Column("channel", lambda entry: channel(entry.channel)[0]),
    field("condition"),
    numeric("share of the squared error", "share_of_error", percent),
    numeric("share of the time", "share_of_time", percent),
)
RUNS = (
    field("record"),
    numeric("neutral rudder angle about the common one, deg", lambda run: run.neutral_angle_rad, "{:+.2f}".format, DEG),
)
