"""What a calibration says: the numbers that moved, the errors of what was left out, and what remains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from ...models.plain import plain
from ...models.result import RunsResult

if TYPE_CHECKING:
    from ...models.model import Model
    from ..result import Trace

SCHEMA = 4
HIDDEN = ("model", "extended", "calibrated", "traces")
"""Fields that are not written as plain data."""


@dataclass(frozen=True)
class Moved:
    """One number of the model: before and after, 90 % interval, change in percent (None from zero) and in prior
    standard deviations; where it differs, in words (empty: everywhere); whether the published number, its ratio to
    another one that moved too, may have stayed."""

    name: str
    group: str
    before: float
    after: float
    low: float
    high: float
    percent: float | None
    prior_sds: float
    where: str = ""
    in_proportion: bool = False


@dataclass(frozen=True)
class StatedRegime:
    """Where a number is wrong: on one side of a threshold (SI) with its 90 % interval.

    number, group : what is wrong there.  share_of_error : share of the squared error of left-out pieces, beyond what is
    no matter, that the choice with it takes off.
    """

    number: str
    group: str
    variable: str
    side: str
    threshold: float
    low: float
    high: float
    unit: str
    share_of_error: float


@dataclass(frozen=True)
class StepTold:
    """One group that entered: fall of the score with its standard error, groups that would do as well, and errors.

    left_out, held_out : column -> root mean squared free-run error, SI, of pieces of training records that were left
    out of the fit, and of the held-out records.
    """

    group: str
    title: str
    gain: float
    standard_error: float
    tied_with: tuple[str, ...]
    left_out: Mapping[str, float]
    held_out: Mapping[str, float]


@dataclass(frozen=True)
class Share:
    """Shares of a channel's squared free-run error of the base model, left-out pieces of records.

    coefficients : taken off by what was chosen.  trim : due to the initial state of single pieces.  noise : the
    sensor's.  remaining : the rest.
    """

    coefficients: float
    trim: float
    noise: float
    remaining: float


@dataclass(frozen=True)
class Remaining:
    """A condition in which the remaining error of a channel is larger than elsewhere."""

    channel: str
    condition: str
    share_of_error: float
    share_of_time: float


@dataclass(frozen=True)
class Ingredient:
    """What one ingredient of the prediction removes: column -> share of the squared error that comes back where all
    numbers are fitted again without it."""

    what: str
    removes: Mapping[str, float]


@dataclass(frozen=True)
class RunEffect:
    """A record's own neutral rudder angle (rad) about the common one."""

    record: str
    neutral_angle_rad: float


@dataclass(frozen=True)
class NextRun:
    """A manoeuvre that would tell more: its information on the numbers of the model, nats."""

    manoeuvre: str
    information: float


@dataclass(frozen=True, repr=False)
class Calibration(RunsResult):
    """The outcome of `calibrate`: which numbers of the model moved, by how much, and what they take off the error.

    `moved` are the numbers with intervals, `steps` the groups in the order in which they entered, `shares` what the
    free-run error consists of; `simulate` and `diagnose` take the extended and the calibrated model like any other.
    """

    model: Model
    extended: Model
    """The extended model of the diagnosis: numbers that moved, as few as explain the records, and other causes."""
    calibrated: Model
    """The model for predictions: all numbers moved under their priors where that predicts left-out pieces better, else
    the extended one."""
    records: tuple[tuple[str, str], ...]
    """(name, 'train' | 'held_out')."""
    verdict: str
    """As of `diagnose`: 'adequate', 'named', 'tied', 'partly_named' or 'unexplained'."""
    reason: str
    """One sentence that supports the verdict, with causes that are no numbers of the model."""
    moved: tuple[Moved, ...]
    steps: tuple[StepTold, ...]
    before: Mapping[str, tuple[float, float | None]]
    after: Mapping[str, tuple[float, float | None]]
    """Before and after: column -> (left-out pieces of training records, held-out records) root mean squared free-run
    errors, SI; pieces have starts of their own, the second is None without held-out records."""
    shares: Mapping[str, Share]
    remaining: tuple[Remaining, ...]
    runs: tuple[RunEffect, ...]
    traces: tuple[Trace, ...]
    """Measured against free runs of the base and the extended model."""
    next_runs: tuple[NextRun, ...]
    worse: tuple[str, ...]
    """Columns in which held-out records are predicted worse than 1.05 times the base model's error."""
    wall_s: float
    regime: StatedRegime | None = None
    """Where one of the numbers is wrong; None where all are wrong everywhere."""
    predicted: Mapping[str, tuple[float, float | None]] = field(default_factory=dict)
    """The same as `after`, by the calibrated model."""
    own: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Column -> errors of held-out records by the base and by the calibrated model, with each record's own neutral
    rudder angle and start, which are fitted to it under their priors; empty without held-out records."""
    ingredients: tuple[Ingredient, ...] = ()
    """What measured inputs and the numbers that moved each remove of the error of left-out pieces."""
    floor: Mapping[str, float] = field(default_factory=dict)
    """Column -> error (SI) of held-out records by a fit to these records themselves; empty without them."""
    doubts: tuple[str, ...] = ()
    """What is doubtful about the records, a sentence each."""
    room: ClassVar[str] = "calibration"
    files: ClassVar[tuple[str, ...]] = (
        *("calibration.json", "calibration.html"),
        *("extended_model.json", "calibrated_model.json"),
    )
    pictured: ClassVar[str] = "measured channels and simulations"

    def to_json(self) -> dict[str, Any]:
        """The calibration as plain data, without the models' equations."""
        document = {name: value for name, value in self.__dict__.items() if name not in HIDDEN}
        facts = plain(document)
        return {"schema": SCHEMA, "model": self.model.id, "extended_family": self.extended.family, **facts}

    def _models(self) -> dict[str, Model]:
        return {self.files[2]: self.extended, self.files[3]: self.calibrated}

    def __repr__(self) -> str:
        groups = ", ".join(step.group for step in self.steps)
        return f"<Calibration of {self.model.id}: {self.verdict}{' ' + groups if groups else ''}>"
