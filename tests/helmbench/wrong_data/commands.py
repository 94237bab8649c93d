"""What each command says of records, and what became of a change: told, refused, harmless, or silently wrong.

Beside that the matrix counts names of the hull and of sensors that the unchanged records do not give.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

import helmbench
from helmbench.datasets.record import Record
from helmbench.models.errors import BadInput, CannotFit, FitFailed

from .fleet import FLEET, model_of, records_of

REFUSED = (BadInput, CannotFit, FitFailed)
LIKE = 1.25
"""Times the coefficient of the unchanged records up to which a change has done no harm."""
MOTION = 0.05
"""The same of an error, as a share of the motion."""
UNKNOWABLE = {("identify", "rudder doubled")}
"""What no command can know: a ship of which nothing is known may have twice or half the rudder."""
NO_HULL = {
    "rudder early": {"rudder_delay"},
    "rudder late": {"rudder_sensor_delay"},
    "rudder turned": {"rudder_sign"},
    "outliers": {"wave_motion", "outliers"},
}
"""Change -> what is rightly named of the chain from order to record, or of the sea, and is no number of the hull."""
NAMED = {
    "radians in the rudder's degrees": {"rudder_response"},
    "radians in all degrees": {"wrong_unit", "rudder_response"},
    "degrees in heading": {"wrong_unit"},
    "degrees in yaw rate": {"wrong_unit"},
    "rudder doubled": {"wrong_unit"},
    "rudder late": {"rudder_response"},
    "rudder early": {"rudder_response"},
    "rudder shuffled": {"rudder_response"},
    "rudder turned": {"rudder_sign"},
    "rudder amidships": {"rudder_response", "constant_channel"},
    "heading turned": {"channel_sign"},
    "yaw rate turned": {"channel_sign"},
    "heading + 180": {"heading_zero"},
    "heading + 90": {"heading_zero"},
    "rows lost": {"time_stamps"},
    "gap": {"time_stamps"},
    "constant speed": {"constant_channel"},
    "knots": {"wrong_unit"},
    "velocities exchanged": {"channel_swap"},
    "positions exchanged": {"channel_swap", "channel_sign"},
    "earth frame": {"earth_frame_velocity"},
    "time reversed": {"channel_sign", "rudder_response", "rudder_sign", "heading_zero"},
    "outliers": {"outliers", "impossible_samples"},
    "halves exchanged": {"splice", "rudder_response"},
    "sway turned": {"channel_sign"},
    "time doubled": {"wrong_unit"},
    "positions in feet": {"wrong_unit"},
    "heading and yaw rate exchanged": {"channel_swap"},
}
"""Change -> what may be named of it; anything else that the unchanged records do not have is invented."""


@dataclass(frozen=True)
class CommandAnswer:
    """What a command says: doubts, errors of sensors and files, numbers of the hull with intervals, and a figure that a
    change without a word must leave as it is, within `slack` or by a factor; `refused` holds why it refuses."""

    doubts: frozenset[str] = frozenset()
    sensors: frozenset[str] = frozenset()
    hull: dict[str, tuple[float, float]] = field(default_factory=dict)
    figure: float | None = None
    slack: float = 0.0
    refused: str = ""


@dataclass(frozen=True)
class ChangeOutcome:
    """One change, set and command: what became of it, names of the hull, sensors that were invented, and a sentence."""

    outcome: str
    hull: tuple[str, ...]
    invented: tuple[str, ...]
    why: str


def check(name: str, records: Sequence[Record]) -> CommandAnswer:
    """`check`: findings that matter."""
    found = [f for f in helmbench.check(records).findings if f.material]
    return CommandAnswer(frozenset(f"{f.cause}: {f.evidence}" for f in found), frozenset(f.cause for f in found))


def validate(name: str, records: Sequence[Record]) -> CommandAnswer:
    """`validate`: doubts, and the share of the yaw rate that free runs do not explain."""
    found = helmbench.validate(model_of(name), records)
    score = found.score("yaw_rate_rad_s")
    return CommandAnswer(frozenset(found.doubts), figure=None if score is None else 1.0 - score.r2, slack=MOTION)


def identify(name: str, records: Sequence[Record]) -> CommandAnswer:
    """`identify`: the gain of a first-order response model."""
    return CommandAnswer(figure=helmbench.identify(records, FLEET[name].family, "ls").parameters["K"])


def calibrate(name: str, records: Sequence[Record]) -> CommandAnswer:
    """`calibrate`: doubts, and numbers that moved."""
    found = helmbench.calibrate(model_of(name), records)
    return CommandAnswer(frozenset(found.doubts), hull={m.name: (m.low, m.high) for m in found.moved})


def diagnose(name: str, records: Sequence[Record]) -> CommandAnswer:
    """`diagnose`: doubts and checks, causes of sensors, and causes and groups of the hull with their sizes."""
    found = helmbench.diagnose(model_of(name), records)
    doubts = {*found.doubts, *(f.evidence for f in found.checks)}
    if found.verdict in ("inconclusive", "unexplained"):
        doubts.add(found.reason)
    sensors = {f.cause for f in found.causes if f.stage == "kinematics" or check_is_sensor(f.cause)}
    own = [f for f in found.causes if f.cause not in sensors]
    hull = {f"{f.cause} {s.parameter}": (s.low, s.high) for f in own for s in f.sizes} | {
        f.cause: (-np.inf, np.inf) for f in own if not f.sizes
    }
    return CommandAnswer(frozenset(doubts), frozenset(sensors), hull)


def check_is_sensor(cause: str) -> bool:
    """Whether a cause is an error of a sensor or of the record."""
    from helmbench.diagnosis.causes.registry import all_causes

    return all_causes()[cause].where in ("sensor", "record")


COMMANDS: dict[str, Callable[[str, Sequence[Record]], CommandAnswer]] = {
    one.__name__: one for one in (check, validate, identify, calibrate, diagnose)
}


def said(command: str, name: str, records: Sequence[Record]) -> CommandAnswer:
    """What a command says of records; its warnings are doubts."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            found = COMMANDS[command](name, records)
        except REFUSED as error:
            return CommandAnswer(refused=str(error))
    doubts = found.doubts | {str(w.message) for w in told if issubclass(w.category, UserWarning)}
    return CommandAnswer(doubts, found.sensors, found.hull, found.figure, found.slack)


@cache
def unchanged(command: str, name: str) -> CommandAnswer:
    """What a command says of the records as they are."""
    return said(command, name, records_of(name))


def judged(command: str, name: str, change: str, records: Sequence[Record]) -> ChangeOutcome:
    """What became of a change in a command."""
    before, after = unchanged(command, name), said(command, name, records)
    if after.refused:
        return ChangeOutcome("refused", (), (), after.refused)
    wrong = {n: size for n, size in after.hull.items() if n.split()[0] not in NO_HULL.get(change, ())}
    hull = tuple(n for n, (low, high) in wrong.items() if not _overlaps(before.hull.get(n), low, high))
    rightly = NAMED.get(change, set()) | NO_HULL.get(change, set())
    invented = tuple(sorted(after.sensors - before.sensors - FLEET[name].known - rightly))
    words = {text for text in after.doubts - before.doubts if command != "check" or text.partition(":")[0] in rightly}
    words |= (after.sensors - before.sensors) & rightly
    if words:
        return ChangeOutcome("told", hull, invented, "; ".join(sorted(words)))
    same = _alike(before.figure, after.figure, after.slack)
    return ChangeOutcome(
        "harmless" if same else "silent", hull, invented, "" if same else f"{before.figure} -> {after.figure}"
    )


def _overlaps(known: tuple[float, float] | None, low: float, high: float) -> bool:
    return known is not None and known[0] <= high and low <= known[1]


def _alike(before: float | None, after: float | None, slack: float) -> bool:
    if before is None or after is None:
        return before is after
    if slack:
        return abs(after - before) < slack
    ratio = after / before
    return 1.0 / LIKE < ratio < LIKE
