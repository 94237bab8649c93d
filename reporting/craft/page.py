"""What the diagnosis of a craft without a model says: what steers it, what simpler models lack, how far ahead."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...datasets.display import shown_name
from ...diagnosis.craft.result import (
    ADEQUATE,
    FOLLOWS,
    INCONCLUSIVE,
    NO_EFFECT,
    OUTSIDE,
    OWN_SPEED,
    PARTLY,
    UNEXPLAINED,
)
from ...estimation.validation.horizons import STRAIGHT, TRUSTED
from ...estimation.validation.validate import label
from ..numbers import DEG, number, r_squared
from ..page import BAD, FAIR, GOOD, Section, Verdict, equation_parts, items, overlays, result_page, sides
from ..runs import of_validation
from ..tables import Column, Table, make_table
from ..validation.tables import horizon_table, trusted_lines

if TYPE_CHECKING:
    from ...diagnosis.craft.result import CraftDiagnosis, Rise
    from ..page import Page

HEADING = "heading_rad"
SHOWN = (*TRUSTED, "surge_m_s", "sway_m_s")
HEADLINES = {
    ADEQUATE: (GOOD, "Adequate"),
    PARTLY: (FAIR, "Partly named"),
    UNEXPLAINED: (BAD, "Unexplained"),
    INCONCLUSIVE: (FAIR, "Inconclusive"),
    NO_EFFECT: (BAD, "The recorded input does not act"),
    OUTSIDE: (FAIR, "Held-out records leave the training range"),
    FOLLOWS: (BAD, "The recorded input follows the motion"),
}
R2 = (
    "One minus the squared error over the variance of the yaw rate, and over the squared change of heading since the "
    "start. first: the steering law alone; built: the model with all steps."
)
TITLES = ("Measured and predicted", "What simpler models lack, and the model", "What remains", "What to record next")


def headline(found: CraftDiagnosis) -> str:
    """The verdict with how far it holds."""
    if found.verdict == ADEQUATE:
        return f"{HEADLINES[ADEQUATE][1]} up to {number(found.trusted_s)} s"
    return HEADLINES[found.verdict][1]


def page(found: CraftDiagnosis) -> Page:
    """The page of a craft's diagnosis."""
    tested = "held_out" in {role for _, role in found.records}
    first, each = overlays(of_validation(found.ahead, "held_out" if tested else "train"))
    every = equation_parts(found.model, found.model)[1]
    trusted = [f"{line}." for line in trusted_lines(found.ahead)]
    said = f"{headline(found)}: {found.reason.rstrip('.')}."
    return result_page(
        "A model from records",
        f"{found.model.title or found.model.family}; {sides(found.records)}",
        Verdict(HEADLINES[found.verdict][0], said, (_steers(found), *_lacks(found), *_neutral(found))),
        seen=[first, r2_table(found)],
        changed=[steps_table(found), numbers_table(found)],
        remains=[items([*_remaining(found), *_speed(found), _heading(found), *found.notes]), band_table(found)],
        following=[f"{found.next_runs[:1].upper()}{found.next_runs[1:]}." if found.next_runs else None],
        details=[
            Section("What steers it", (laws_table(found),)),
            Section("Errors ahead", (horizon_table(found.ahead), items(trusted))),
            Section("Neutral angle of every training record beside the common one", (angles_table(found),)),
            each,
            every,
        ],
        doubts=found.doubts,
        titles=TITLES,
    )


def told_in_a_line(found: CraftDiagnosis) -> str:
    """The outcome in a line: verdict, what steers it, and what was added."""
    chosen = next(law for law in found.laws if law.chosen)
    added = "; ".join(step.title for step in found.steps[1:] if step.gain > 0.0)
    return f"{headline(found)}. {chosen.title[:1].upper()}{chosen.title[1:]}{f'; {added}' if added else ''}."


def _steers(found: CraftDiagnosis) -> str:
    chosen = next(law for law in found.laws if law.chosen)
    told = f"What steers it: {chosen.title}"
    others = [law for law in found.laws if not law.chosen]
    worse = sorted((law for law in others if law.gain < min(chosen.gain - law.error, -0.01)), key=lambda law: law.gain)
    equal = [law for law in others if law not in worse]
    if worse:
        told += f"; with {worse[0].title} errors are {_percent(-worse[0].gain)} larger"
    if equal:
        told += f". The records cannot tell it from {' or '.join(law.title for law in equal)}"
    return f"{told}."


def _lacks(found: CraftDiagnosis) -> list[str]:
    first = found.steps[0]
    shares = (
        f"{r_squared(first.r2_yaw_rate)} of the yaw rate and {r_squared(first.r2_heading)} of the change of heading"
    )
    told = [f"A model of {first.numbers} numbers has R² {shares} over windows of {number(found.window_s)} s."]
    lacking = [f"{s.title} ({_percent(s.gain)} ± {_percent(s.error)})" for s in found.steps[1:] if s.gain > 0.0]
    return [*told, f"It lacks: {'; '.join(lacking)}."] if lacking else told


def _neutral(found: CraftDiagnosis) -> list[str]:
    """The neutral angle, where its interval does not hold zero."""
    offset = next((n for n in found.numbers if n.name == "rudder_offset" and n.low * n.high > 0.0), None)
    if offset is None:
        return []
    unit, factor = _steering_unit(found)
    value, half = number(-factor * offset.value, 2), number(factor * (offset.high - offset.value), 2)
    return [f"A rudder or command of {value} ± {half} {unit} (90 %) holds a straight course."]


def _steering_unit(found: CraftDiagnosis) -> tuple[str, float]:
    """Unit in which the steering is shown, and how many of it a unit of the record is."""
    return ("N", 1.0) if found.model.family.startswith("twin-thrusters") else ("deg", DEG)


def _remaining(found: CraftDiagnosis) -> list[str]:
    """What nearly entered: what remains looks like that."""
    near = sorted((r for r in found.refused if r[1] > max(r[2], 0.01)), key=lambda r: -r[1])[:2]
    said = " or ".join(f"{name.replace('_', ' ')} ({_percent(gain)} ± {_percent(error)})" for name, gain, error in near)
    return [f"What remains looks most like {said}, which the records do not show beyond doubt."] if near else []


def _speed(found: CraftDiagnosis) -> list[str]:
    """How well surge and sway are predicted, where the model has them."""
    times = found.ahead.horizons_s[:3]
    if found.own_speed is None or not times:
        return []
    both = [(c, found.ahead.score(f"{c}_m_s", OWN_SPEED, horizon=label(times[-1]))) for c in ("surge", "sway")]
    shares = " and ".join(f"{r_squared(score.r2)} of {what}" for what, score in both if score is not None)
    return [f"With surge and sway of its own, which need no measured speed, R² is {shares} after {label(times[-1])}."]


def _heading(found: CraftDiagnosis) -> str:
    last = found.band[-1]
    told = f"Heading is known within ± {number(DEG * last.sd_rad, 2)} deg (1 sd) after {number(last.after_s)} s"
    inside = "" if math.isnan(found.inside) else f"; {100.0 * found.inside:.0f} % of held-out heading errors are inside"
    return f"{told}, since each run has a neutral angle of its own{inside}."


def _percent(logarithm: float) -> str:
    """A fall or rise of the logarithm of errors."""
    return f"{100.0 * logarithm:.0f} %"


def laws_table(found: CraftDiagnosis) -> Table:
    """The steering laws: a row each."""
    columns = [
        Column("what steers it", lambda law: law.title),
        Column("errors against the best", lambda law: f"{-100.0 * law.gain:+.0f} % ± {100.0 * law.error:.0f} %",
               lambda law: -law.gain),
        Column("R² yaw rate", lambda law: r_squared(law.r2_yaw_rate), lambda law: law.r2_yaw_rate),
        Column("R² heading", lambda law: r_squared(law.r2_heading), lambda law: law.r2_heading),
        Column("", lambda law: "chosen" if law.chosen else "as good" if law.tied else ""),
    ]  # fmt: skip
    note = f"Each law alone, fitted to windows of {found.window_s:.3g} s; scores are of blocks that were left out."
    return make_table(columns, found.laws, note=note)


def _fall_of(step: Rise) -> str:
    return f"{_percent(step.gain)} ± {_percent(step.error)}" if step.error else ""


def steps_table(found: CraftDiagnosis) -> Table:
    """The ladder: a row a step."""
    columns = [
        Column("step", lambda step: step.title),
        Column("numbers", lambda step: str(step.numbers), lambda step: step.numbers),
        Column("errors fall by", _fall_of, lambda step: step.gain),
        Column("R² yaw rate", lambda step: r_squared(step.r2_yaw_rate), lambda step: step.r2_yaw_rate),
        Column("R² heading", lambda step: r_squared(step.r2_heading), lambda step: step.r2_heading),
    ]  # fmt: skip
    return make_table(columns, found.steps)


def r2_table(found: CraftDiagnosis) -> Table:
    """R² of yaw rate, of the change of heading, and of surge and sway by time ahead: a row a channel and model.

    In a zigzag the heading itself hardly varies: the change since the start is what is predicted.
    """
    rows = [(channel, name) for channel in SHOWN for name in found.ahead.models if found.ahead.score(channel, name)]
    columns = [
        Column("channel", lambda row: "change of heading" if row[0] == HEADING else shown_name(row[0])),
        Column("model", lambda row: row[1]),
        *(_r2_column(found, label(time)) for time in found.ahead.horizons_s),
    ]
    return make_table(columns, rows, "R² by the time ahead", R2)


def _r2_column(found: CraftDiagnosis, horizon: str) -> Column:
    def value(row: tuple[str, str]) -> float | None:
        score = found.ahead.score(*row, horizon=horizon)
        if score is None or row[0] != HEADING:
            return None if score is None else score.r2
        still = {(s.channel, s.horizon): s.rmse for s in found.ahead.simple if s.model == STRAIGHT}
        return 1.0 - (score.rmse / still[HEADING, horizon]) ** 2 if still.get((HEADING, horizon)) else None

    return Column(f"after {horizon}", lambda row: r_squared(value(row)), value)


def numbers_table(found: CraftDiagnosis) -> Table:
    """The numbers of the model with intervals."""
    columns = [
        Column("number", lambda n: n.name),
        Column("unit", lambda n: n.unit),
        Column("value", lambda n: number(n.value), lambda n: n.value),
        Column("90 % interval", lambda n: f"{number(n.low)} to {number(n.high)}"),
    ]
    return make_table(columns, found.numbers, "Numbers of the model")


def band_table(found: CraftDiagnosis) -> Table:
    """How far heading can be trusted."""
    columns = [
        Column("after, s", lambda b: number(b.after_s), lambda b: b.after_s),
        Column("heading, 1 sd, deg", lambda b: number(DEG * b.sd_rad, 2), lambda b: DEG * b.sd_rad),
    ]
    return make_table(columns, sorted(found.band, key=lambda b: b.after_s), "How far heading can be trusted")


def angles_table(found: CraftDiagnosis) -> Table:
    """The neutral angle of every training record beside the common one."""
    unit, factor = _steering_unit(found)
    columns = [
        Column("record", lambda row: row[0]),
        Column(f"own neutral angle, {unit}", lambda row: number(factor * row[1], 2), lambda row: factor * row[1]),
    ]
    return make_table(columns, found.own_angles)
