"""What a calibration says: the numbers that moved, the errors of records that were left out, and what remains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from ...models.plain import plain
from ...models.result import RunsResult

if TYPE_CHECKING:
    from ...models.model import Model
    from ..result import Trace

SCHEMA = 3
EXPLAINABLE = 0.05
"""Least share of the squared error that counts as explainable by the model."""
HIDDEN = ("model", "extended", "calibrated", "traces")
"""Fields that are not written as plain data."""
VERDICTS = ("adequate", "named", "partly_named", "unexplained")


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

    @property
    def parameter(self) -> str:
        """Its name as a size: that of a number in a regime is told as its change."""
        return f"change: {self.name} {self.where}" if self.where else self.name


@dataclass(frozen=True)
class StatedRegime:
    """Where a number is wrong: on one side of a threshold (SI) with its 90 % interval.

    number, group : what is wrong there.  share_of_error : share of the squared free-run error of left-out records that
    it takes off, mean over the states.
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

    left_out, held_out : column -> root mean squared free-run error, SI, of training records that were left out of the
    fit, and of the held-out records.
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
    """Shares of a channel's squared free-run error of the base model, left-out records.

    coefficients : taken off by the numbers that moved.  trim : due to the neutral rudder angle and the initial state of
    single runs.  noise : the sensor's.  remaining : the rest.  causes : taken off by known causes beside the numbers.
    """

    coefficients: float
    trim: float
    noise: float
    remaining: float
    causes: float = 0.0

    @property
    def explained(self) -> float:
        """Share of what the model can explain, which trim and noise are no part of, that numbers and causes take
        off.

        Eq. 4 of docs/mathematics/calibration.md.
        """
        taken = self.coefficients + self.causes
        return taken / max(taken + self.remaining, EXPLAINABLE)


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
    """The base model with the numbers that moved, as few as explain the records."""
    calibrated: Model
    """The model for predictions: all numbers moved a little where that predicts left-out records better, else the
    extended one."""
    records: tuple[tuple[str, str], ...]
    """(name, 'train' | 'held_out')."""
    verdict: str
    reason: str
    moved: tuple[Moved, ...]
    steps: tuple[StepTold, ...]
    before: Mapping[str, tuple[float, float | None]]
    after: Mapping[str, tuple[float, float | None]]
    """Before and after: column -> (left-out training records, held-out records) root mean squared free-run errors, SI;
    the second is None without held-out records.  Before, these are as they were read; after, without what sensors and
    known causes explain, where such were found."""
    shares: Mapping[str, Share]
    remaining: tuple[Remaining, ...]
    runs: tuple[RunEffect, ...]
    traces: tuple[Trace, ...]
    """Measured against free runs before and after; after of a training record is by a fit without it."""
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
    """What measured inputs and the numbers that moved each remove of the error."""
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
