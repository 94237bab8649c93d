"""What the diagnosis of a craft without a model says: what steers it, what simpler models lack, how far ahead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..datasets.display import shown_name
from ..diagnosis.craft.result import (
    ADEQUATE,
    FOLLOWS,
    INCONCLUSIVE,
    NO_EFFECT,
    OUTSIDE,
    OWN_SPEED,
    PARTLY,
    UNEXPLAINED,
    by_thrust,
)
from ..diagnosis.craft.sensors import CORRECTED
from ..estimation.selection.score import share_of_errors
from ..estimation.validation.horizons import TRUSTED
from ..estimation.validation.validate import label
from .diagnosis.words import cause, listed
from .numbers import DEG, SHORT, number, r_squared
from .page import BAD, FAIR, GOOD, Section, Verdict, equation_parts, items, overlays, result_page, sides
from .runs import of_validation
from .tables import Column, Table, field, make_table, numeric
from .validation.page import explained_lines, horizon_table, share_explained

if TYPE_CHECKING:
    from ..diagnosis.craft.result import CraftDiagnosis, LawTold, NumberTold, Rise
    from .page import Page

HEADING = "heading_rad"
SHOWN = (*TRUSTED, "surge_m_s", "sway_m_s")
HEADLINES = {
    ADEQUATE: (GOOD, "Adequate"),
    PARTLY: (FAIR, "Partly named"),
    UNEXPLAINED: (BAD, "Unexplained"),
    INCONCLUSIVE: (FAIR, "Inconclusive"),
    NO_EFFECT: (BAD, "The recorded input hardly acts"),
    OUTSIDE: (FAIR, "Held-out records leave the training range"),
    FOLLOWS: (BAD, "The recorded input follows the motion"),
}
R2 = (
    "One minus the squared error over the variance of the yaw rate, and over the squared change of heading since the "
    "start. Law alone: what steers it, without further steps; built model: with all steps."
)
OF_LOOP = (
    "All numbers and steps are those of the craft and its controller together: they hold while this controller steers, "
    "and say nothing of the craft alone."
)
"""What is said where the recorded input follows the motion."""
TITLES = ("Measured and predicted", "What simpler models lack, and the model", "What remains", "What to record next")


def headline(diagnosis: CraftDiagnosis) -> str:
    """The verdict with how far it holds."""
    if diagnosis.verdict == ADEQUATE:
        return f"{HEADLINES[ADEQUATE][1]} up to {number(diagnosis.trusted_s)} s ahead"
    return HEADLINES[diagnosis.verdict][1]


def page(diagnosis: CraftDiagnosis) -> Page:
    """The page of a craft's diagnosis."""
    tested = "held_out" in {role for _, role in diagnosis.records}
    first, each = overlays(of_validation(diagnosis.ahead, "held_out" if tested else "train"))
    every = equation_parts(diagnosis.model, diagnosis.model)[1]
    trusted = [f"{line}." for line in explained_lines(diagnosis.ahead)]
    said = f"{headline(diagnosis)}: {diagnosis.reason.rstrip('.')}."
    return result_page(
        "A model from records",
        f"{diagnosis.model.title or diagnosis.model.family}; {sides(diagnosis.records)}",
        Verdict(
            HEADLINES[diagnosis.verdict][0],
            said,
            (*diagnosis.notes, *_sensors(diagnosis), _steers(diagnosis), *_lacks(diagnosis), *_neutral(diagnosis)),
        ),
        seen=[first, r2_table(diagnosis)],
        changed=[
            make_table(STEPS, diagnosis.steps),
            numbers_table(diagnosis),
        ],
        remains=[
            items([*trusted, *_remaining(diagnosis), *_speed(diagnosis), _heading(diagnosis)]),
            make_table(BAND, sorted(diagnosis.band, key=lambda b: b.after_s), "How far heading can be trusted"),
        ],
        following=[f"{diagnosis.next_runs[:1].upper()}{diagnosis.next_runs[1:]}." if diagnosis.next_runs else None],
        details=[
            Section("What steers it", (laws_table(diagnosis),)),
            Section("How far ahead", (horizon_table(diagnosis.ahead),)),
            Section("Neutral angle of every training record beside the common one", (angles_table(diagnosis),)),
            each,
            every,
        ],
        doubts=diagnosis.doubts,
        titles=TITLES,
    )


def told_in_a_line(diagnosis: CraftDiagnosis) -> str:
    """The outcome in a line: verdict, what steers it, and what was added."""
    chosen = next(law for law in diagnosis.laws if law.chosen)
    if diagnosis.verdict == FOLLOWS:
        return f"{headline(diagnosis)}. {OF_LOOP}"
    seen = [f"corrected: {cause(f.cause)}" for f in diagnosis.causes if f.cause in CORRECTED]
    added = "; ".join([*(step.title for step in diagnosis.steps[1:] if step.gain > 0.0), *seen])
    return f"{headline(diagnosis)}. {chosen.title[:1].upper()}{chosen.title[1:]}{f'; {added}' if added else ''}."


def _sensors(diagnosis: CraftDiagnosis) -> list[str]:
    """What the records show of their sensors."""
    corrected = [f for f in diagnosis.causes if f.cause in CORRECTED]
    others = [f for f in diagnosis.causes if f not in corrected]
    said = [f"Found in the records themselves, and corrected: {listed(corrected)}."] if corrected else []
    return said + ([f"Found in the records themselves, but not corrected: {listed(others)}."] if others else [])


def _steers(diagnosis: CraftDiagnosis) -> str:
    if diagnosis.verdict == FOLLOWS:
        return OF_LOOP
    chosen = next(law for law in diagnosis.laws if law.chosen)
    told = f'What steers it: "{chosen.title}"'
    others = [law for law in diagnosis.laws if not law.chosen]
    worse = sorted((law for law in others if law.gain < min(chosen.gain - law.error, -0.01)), key=lambda law: law.gain)
    equal = [law for law in others if law not in worse]
    if worse:
        rise = -100.0 * share_of_errors(worse[0].gain, worse[0].error)[0]
        told += f'. With "{worse[0].title}" the errors are {rise:.0f} % larger'
    if equal:
        others_said = " or ".join(f'"{law.title}"' for law in equal)
        told += f". The records cannot tell it from {others_said}"
    return f"{told}."


def _lacks(diagnosis: CraftDiagnosis) -> list[str]:
    first = diagnosis.steps[0]
    shares = (
        f"{r_squared(first.r2_yaw_rate)} of the yaw rate and {r_squared(first.r2_heading)} of the change of heading"
    )
    alone = "" if diagnosis.verdict == FOLLOWS else " for this alone"
    told = [f"A model of {first.numbers} numbers{alone} has R² {shares} in windows of {number(diagnosis.window_s)} s."]
    if diagnosis.verdict == FOLLOWS:
        return told
    lacking = [f"{s.title} ({_fall(s.gain, s.error)})" for s in diagnosis.steps[1:] if s.gain > 0.0]
    lacks = "Craft and controller together have beside it" if diagnosis.doubts else "It lacks"
    shares = "with the fall of errors that each brings"
    return [*told, f"{lacks}, {shares}: {'; '.join(lacking)}."] if lacking else told


def _neutral(diagnosis: CraftDiagnosis) -> list[str]:
    """The neutral angle, where its interval does not hold zero."""
    offset = next((n for n in diagnosis.numbers if n.name == "rudder_offset" and n.low * n.high > 0.0), None)
    if offset is None:
        return []
    unit, factor = _steering_unit(diagnosis)
    value, half = number(-factor * offset.value, 2), number(factor * (offset.high - offset.value), 2)
    return [f"A rudder or command of {value} ± {half} {unit} (90 %) holds a straight course."]


def _steering_unit(diagnosis: CraftDiagnosis) -> tuple[str, float]:
    """Unit in which the steering is shown, and how many of it a unit of the record is."""
    return ("N", 1.0) if by_thrust(diagnosis.laws) else ("deg", DEG)


def _remaining(diagnosis: CraftDiagnosis) -> list[str]:
    """What nearly entered: what remains looks like that."""
    near = sorted((r for r in diagnosis.refused if r[1] > max(r[2], 0.01)), key=lambda r: -r[1])[:2]
    said = " or ".join(f"{name.replace('_', ' ')} ({_fall(gain, error)})" for name, gain, error in near)
    return [f"What remains looks most like {said}, which the records do not show beyond doubt."] if near else []


def _speed(diagnosis: CraftDiagnosis) -> list[str]:
    """How well surge and sway are predicted, where the model has them."""
    times = diagnosis.ahead.horizons_s[:3]
    if diagnosis.own_speed is None or not times:
        return []
    both = [(c, diagnosis.ahead.score(f"{c}_m_s", OWN_SPEED, horizon=label(times[-1]))) for c in ("surge", "sway")]
    shares = " and ".join(f"{r_squared(score.r2)} of {what}" for what, score in both if score is not None)
    return [f"With surge and sway of its own, which need no measured speed, R² is {shares} after {label(times[-1])}."]


def _heading(diagnosis: CraftDiagnosis) -> str:
    known = [band for band in diagnosis.band if band.sd_rad < LOST]
    lost = [band for band in diagnosis.band if band not in known]
    told = [f"is known within ± {number(DEG * b.sd_rad, 2)} deg (1 sd) after {number(b.after_s)} s" for b in known[-1:]]
    told += [f"is not known after {number(lost[0].after_s)} s"] if lost else []
    inside = (
        ""
        if math.isnan(diagnosis.inside)
        else f" {100.0 * diagnosis.inside:.0f} % of held-out heading errors are inside one sd."
    )
    return f"The heading {' and '.join(told)}, since each run has a neutral angle of its own.{inside}"


def _fall(gain: float, error: float) -> str:
    """The share by which errors fall with a fall of their logarithm, and its standard error."""
    return " ± ".join(f"{100.0 * share:.0f} %" for share in share_of_errors(gain, error))


R2_COLUMNS = (numeric("R² yaw rate", "r2_yaw_rate", r_squared), numeric("R² heading", "r2_heading", r_squared))


def _against_best(law: LawTold) -> str:
    fall, error = share_of_errors(law.gain, law.error)
    return f"{-100.0 * fall:+.0f} % ± {100.0 * error:.0f} %"


def laws_table(diagnosis: CraftDiagnosis) -> Table:
    """The steering laws: a row each."""
    columns = [
        field("title", "what steers it"),
        Column("errors against the best", _against_best, lambda law: -law.gain),
        *R2_COLUMNS,
        Column("", lambda law: "chosen" if law.chosen else "as good" if law.tied else ""),
    ]
    note = f"Each law alone, fitted to windows of {diagnosis.window_s:.3g} s; scores are of blocks that were left out."
    return make_table(columns, diagnosis.laws, note=note)


def _fall_of(step: Rise) -> str:
    return _fall(step.gain, step.error) if step.error else ""


STEPS = (
    field("title", "step"),
    numeric("numbers", "numbers", str),
    Column("errors fall by", _fall_of, lambda step: step.gain),
    *R2_COLUMNS,
)


def r2_table(diagnosis: CraftDiagnosis) -> Table:
    """R² of yaw rate, of the change of heading, and of surge and sway by time ahead: a row a channel and model.

    In a zigzag the heading itself hardly varies: the change since the start is what is predicted.
    """
    rows = [
        (channel, name) for channel in SHOWN for name in diagnosis.ahead.models if diagnosis.ahead.score(channel, name)
    ]
    columns = [
        Column("channel", lambda row: "change of heading" if row[0] == HEADING else shown_name(row[0])),
        Column("model", lambda row: row[1]),
        *(
            numeric(f"after {label(t)}", lambda row, t=t: share_explained(diagnosis.ahead, *row, label(t)), r_squared)
            for t in diagnosis.ahead.horizons_s
        ),
    ]
    return make_table(columns, rows, "R² by the time ahead", R2)


def numbers_table(diagnosis: CraftDiagnosis) -> Table:
    """The numbers of the model that are not zero, with their intervals; angles in degrees."""
    angles = not by_thrust(diagnosis.laws)

    def scaled(of: NumberTold, value: float) -> float:
        return DEG * value if angles and of.unit == "rad" else value

    columns = [
        field("name", "number"),
        Column("unit", lambda n: "deg" if angles and n.unit == "rad" else n.unit),
        Column("value", lambda n: number(scaled(n, n.value)), lambda n: scaled(n, n.value)),
        Column("90 % interval", lambda n: f"{number(scaled(n, n.low))} to {number(scaled(n, n.high))}"),
    ]
    rows = [n for n in diagnosis.numbers if n.value or n.low or n.high]
    return make_table(columns, rows, "Numbers of the model")


LOST = math.pi / 2.0
"""Standard deviation of the heading, rad, from which it is not known."""
BAND = (
    numeric("after, s", "after_s"),
    Column("heading, 1 sd, deg", lambda b: SHORT(DEG * b.sd_rad) if b.sd_rad < LOST else "not known"),
)


def angles_table(diagnosis: CraftDiagnosis) -> Table:
    """The neutral angle of every training record beside the common one."""
    unit, factor = _steering_unit(diagnosis)
    columns = [
        Column("record", lambda row: row[0]),
        numeric(f"own neutral angle, {unit}", lambda row: row[1], SHORT, factor),
    ]
    return make_table(columns, diagnosis.own_angles)
