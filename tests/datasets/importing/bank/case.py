"""A raw log of the bank, what its owner knows of it, and how he answers the questions of the import."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml

from .truth import Run

ROUNDS = 12
"""Questions in a row after which a log counts as not imported."""
FACTORS = {
    "rad": 1.0, "deg": np.pi / 180.0, "rad/s": 1.0, "deg/s": np.pi / 180.0, "deg/min": np.pi / 10800.0, "m/s": 1.0,
    "kn": 1852.0 / 3600.0, "km/h": 1.0 / 3.6, "m": 1.0, "km": 1000.0, "mm": 1e-3, "rps": 1.0, "rpm": 1.0 / 60.0,
}  # fmt: skip


@dataclass(frozen=True)
class Is:
    """What a column is, as its owner knows: quantity, unit, 1 or -1 to the record's convention, factor and offset."""

    quantity: str
    unit: str = ""
    sign: int = 1
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Case:
    """write : of a run into a folder, gives the files.  knows : column -> what it is.  wanted : channels of the record.

    side : to which a positive number in the rudder's column turns the ship.  time : form of the time where it is asked,
    or the name of its column.  loose : of a log that is resampled.  whole : id of a question about the whole log -> key
    of its answer.  questions : how many are asked, None where that is not counted.  records : of the log; the longest
    is compared.  start : the key under which the record states its start, '' where none is known.  first_s : when the
    record begins after the run by its clock, to `within_s`.  refused, said : what the import says, as a refusal or as
    a doubt.  seconds : how long the log is.
    """

    write: Callable[[Run, Path], list[Path]]
    hostile: bool
    knows: dict[str, Is] = field(default_factory=dict)
    wanted: tuple[str, ...] = ("rudder_rad", "heading_rad", "yaw_rate_rad_s")
    side: str = "starboard"
    time: str = ""
    variation: str = ""
    loose: float = 0.03
    options: dict = field(default_factory=dict)
    whole: dict[str, str] = field(default_factory=dict)
    questions: int | None = None
    records: int = 1
    start: str = ""
    first_s: float = 0.0
    within_s: float = 0.6
    refused: str = ""
    said: str = ""
    seconds: float = 160.0


def truth_of(run: Run, channel: str) -> np.ndarray:
    """The true values (N,) of a channel, a rudder positive to starboard."""
    return {
        "rudder_rad": run.delta, "rudder_command_rad": run.order, "heading_rad": run.psi, "yaw_rate_rad_s": run.r,
        "surge_m_s": run.u, "sway_m_s": run.v, "roll_rad": run.roll, "north_m": run.north, "east_m": run.east,
        "propeller_rps": run.rps,
    }[channel]  # fmt: skip


def answer(question, case: Case) -> str | None:
    """What the owner answers; None where no answer is right."""
    if question.about == "rudder side":
        return case.side
    if question.id.endswith("/clock"):
        return case.knows["clock"].quantity if "clock" in case.knows else None
    if question.about == "time" and question.number and case.time.replace(".", "", 1).isdigit():
        return case.time
    if question.about == "time":
        return next((a.key for a in question.answers if case.time and a.key.startswith(case.time)), None)
    if question.id == "variation":
        return case.variation or None
    if question.about == "columns":
        return _about_columns(question, case)
    if question.id in case.whole:
        return case.whole[question.id]
    if question.id not in ("rudder", "turning"):
        return _about_column(question, case)
    lines = [(a.key, line[0]) for a in question.answers if isinstance(line := yaml.safe_load(a.line), list)]
    return next((key for key, e in lines if _known(case, e["column"]).quantity == e["to"]), None)


SAID = re.compile(r"(?:^|, )(?P<name>(?:(?! is ).)+) is (?P<kinds>[a-z ]+) \[(?P<unit>[^],]+)(?P<sign>, [^]]+)?\]")
"""A column, what it may be, its unit and sign, as a question about several columns says them."""


def _about_columns(question, case: Case) -> str:
    """The first answer of which all is right, each the first one with changes; the last where there is none."""
    text = question.text.rpartition("together ")[2]
    said = {m["name"]: m for m in SAID.finditer(text.partition("), ")[2] if " is the time (" in text else text)}
    for option in question.answers:
        own = said | {m["name"]: m for m in SAID.finditer(option.text.removeprefix("no, but "))}
        if option.key.isdigit() and all(_is_meant(match, case, "units" in question.id) for match in own.values()):
            return option.key
    return question.answers[-1].key


def _is_meant(match: re.Match[str], case: Case, any_sign: bool) -> bool:
    known = _known(case, match["name"])
    factor, _, unit = match["unit"].rpartition(" ")
    same = known.quantity.replace("_", " ") in match["kinds"].split(" or ")
    turned = (known.sign < 0) == bool(match["sign"]) or known.quantity in ("rudder", "rudder_command")
    entry = {"unit": unit, "factor": float(factor or 1.0)}
    return same and _same_size(entry, known) and (any_sign or turned)


def _known(case: Case, column: str) -> Is:
    return case.knows.get(column, Is("not used"))


def _about_column(question, case: Case) -> str | None:
    known = _known(case, question.column)
    for option in question.answers:
        entry = yaml.safe_load(option.line)[0]
        if entry["to"] == "not used":
            if known.quantity == "not used":
                return option.key
            continue
        if entry["to"] != known.quantity:
            continue
        if question.about == "quantity" or (question.about == "unit" and _same_size(entry, known)):
            return option.key
        if question.about == "sign" and entry.get("sign", 1) == known.sign and _same_offset(entry, known):
            return option.key
    if question.about == "unit" and question.number and known.unit:
        return f"{100.0 * known.factor if '100' in question.number else known.factor:g}"
    return None


def _same_size(entry: dict, known: Is) -> bool:
    size = FACTORS.get(entry["unit"], 0.0) * entry.get("factor", 1.0)
    return abs(size / (FACTORS[known.unit] * known.factor) - 1.0) < 1e-6


def _same_offset(entry: dict, known: Is) -> bool:
    return abs(entry.get("offset", 0.0) * FACTORS.get(entry["unit"], 1.0) - known.offset) < 1e-6


@dataclass(frozen=True)
class CaseOutcome:
    """imported, or named with every column in the draft; questions that were answered; channels that are wrong."""

    imported: bool
    asked: int
    wrong: tuple[str, ...]
    missing: tuple[str, ...]
    unnamed: tuple[str, ...] = ()
    note: str = ""
    records: int = 0
    start: str = ""
    start_s: float = 0.0
    """What the record states of its start, and that in seconds since 1970."""
    said: str = ""
    again: Callable[[], tuple[str, ...]] | None = None
    """What differs where the log is imported with the map that the import wrote."""
