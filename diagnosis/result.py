"""What a diagnosis says: verdict, causes with sizes, the whole bank, the gain, and what a page needs to show it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from ..models.plain import plain
from ..models.result import RunsResult

if TYPE_CHECKING:
    import numpy as np

    from ..checks.result import CheckFinding, Size
    from ..datasets.record import Record
    from ..estimation.validation.result import Validation
    from ..models.model import Model

SCHEMA = 3
VERDICTS = ("inconclusive", "unexplained", "described", "partly_named", "tied", "named", "adequate")
"""In the order of precedence."""
BESIDE = "beside"
"""Detail of a finding of few numbers that is one beside all numbers of the model, which are uncertain."""
CHANGE = "change: "
"""Begin of the name of a number that changes in a regime, before the number and the regime in words."""


@dataclass(frozen=True)
class Finding:
    """A cause that passed, with those it cannot be told from.

    statistic, p_adjusted : of its test; None of what was counted, or is seen without a test.
    """

    cause: str
    tied_with: tuple[str, ...]
    stage: str
    statistic: float | None
    p_adjusted: float | None
    sizes: tuple[Size, ...]
    level: float = 0.90
    details: dict[str, Any] = field(default_factory=dict)
    evidence: str = ""
    separate_by: str | None = None


@dataclass(frozen=True)
class Entry:
    """One line of the bank.

    status : named, tied, not_significant, not_testable or explained_by.
    power : of the test at the size that matters (None where it was not tested).
    """

    cause: str
    status: str
    statistic: float | None
    p_adjusted: float | None
    power: float | None
    why: str


@dataclass(frozen=True)
class Curve:
    """A force, or a sensor's error, over the variable that it depends on, where there are data, arrays (N,), with a
    90 % band; after a step of a motion, per unit of that, of a force that depends on its past."""

    variable: str
    variable_unit: str
    force_unit: str
    values: tuple[float, ...]
    force: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]


@dataclass(frozen=True)
class RemainingForce:
    """A force, or the drift of a sensor, that no known cause explains.

    axis : X, Y or N, or the state that a sensor shows.  depends_on : variables in words.
    share : of the squared error of left-out pieces beyond noise that it takes off; None where only several together do.
    gain : channel -> root mean square error of left-out pieces before and after, SI.
    extended : whether it is a term of the extended model.  reading : what it may be.  next_manoeuvre : what would tell.
    tied_with : other forces that would do as well, in words.
    """

    axis: str
    depends_on: tuple[str, ...]
    text: str
    share: float | None
    gain: dict[str, tuple[float, float]]
    sizes: tuple[Size, ...]
    extended: bool
    reading: str
    next_manoeuvre: str
    tied_with: tuple[str, ...] = ()
    curve: Curve | None = None

    @property
    def span(self) -> str:
        """The record and the time in it over which the force acts, of one that acts in that alone; else empty."""
        return self.text.partition(": ")[2] if any(size.parameter.endswith("_event") for size in self.sizes) else ""

    @property
    def of_sensor(self) -> bool:
        """Whether it is the drift of a sensor."""
        return self.axis not in ("X", "Y", "N")


@dataclass(frozen=True)
class Gain:
    """Free-run error of one channel over the held-out records, before and after, with a 90 % interval of its ratio."""

    rmse_before: float
    rmse_after: float
    ratio_low: float
    ratio_high: float
    r2_before: float
    r2_after: float
    closed: float
    """Share of the gap to the noise floor that the extension closed."""
    own_before: float = math.nan
    own_after: float = math.nan
    """The errors with each record's own neutral rudder angle and start, fitted to it under their priors."""


@dataclass(frozen=True)
class Trace:
    """One record for the page: measured channels against the free runs before and after.

    time (T,) s; measured, before, after: channel name -> (T,), SI; nan where not scored.
    """

    record: str
    role: str
    time: np.ndarray
    rudder: np.ndarray
    measured: dict[str, np.ndarray]
    before: dict[str, np.ndarray]
    after: dict[str, np.ndarray]


@dataclass(frozen=True, repr=False)
class Diagnosis(RunsResult):
    """The outcome of `diagnose`: verdict, causes with sizes and intervals, the extended model and its gain.

    `causes` are the causes that are named, `bank` all that were tested, `gain` the free-run errors on the held-out
    records before and after the extension, `extended` the extended model, which `simulate`, `identify` and `diagnose`
    take like any other.  `calibrated` is the base model with all its numbers moved under their priors, where these were
    uncertain, and `calibrated_gain` its errors: naming is sparse, predicting is not.
    """

    model: Model
    extended: Model
    base_parameters: str
    records: tuple[tuple[str, str], ...]
    """(file or name, 'train' | 'held_out')."""
    alpha: float
    seed: int
    verdict: str
    reason: str
    """One sentence that supports the verdict."""
    causes: tuple[Finding, ...]
    bank: tuple[Entry, ...]
    gain: dict[str, Gain]
    hypothesis: dict[str, Any] | None
    """Of an unexplained effect that free runs do not show: the sparse term that fits best, and whether held-out records
    confirm it."""
    noise: dict[str, Any]
    """Sensor sds, force sds and correlation time that were estimated."""
    traces: tuple[Trace, ...]
    where: tuple[dict[str, Any], ...]
    """Where in the records the base model goes wrong: condition, share of the excess, one sentence."""
    next_manoeuvre: str | None
    wall_s: float
    cpu_s: float
    threads: int = 1
    """Threads that ran the filter; the results do not depend on them."""
    doubts: tuple[str, ...] = ()
    """What is doubtful about the records, a sentence each."""
    apart: tuple[str, ...] = ()
    """Training records that are not diagnosed, as the model errs in these by far more than in the others."""
    calibrated: Model | None = None
    """The extended model with all its numbers moved under their priors, where that predicts better; else None."""
    calibrated_gain: dict[str, Gain] = field(default_factory=dict)
    """Gain of the calibrated model by channel."""
    checks: tuple[CheckFinding, ...] = ()
    """What the records show of their files by themselves: corrected, or standing in the way of a diagnosis."""
    of_held_out: dict[str, dict[str, float]] = field(default_factory=dict)
    """Held-out record -> what belongs to it (current, wind), estimated on its first part: coefficients with which the
    extended model is run along it."""
    remaining: tuple[RemainingForce, ...] = ()
    """What describes the error that known causes leave."""
    evaluation: tuple[Record, ...] = ()
    """Records that models are compared with: held out, or else of training, as they were read but for columns that mean
    something else."""
    ahead: Validation | None = None
    """Errors some time ahead along these; None where none were computed."""
    room: ClassVar[str] = "diagnosis.page"
    files: ClassVar[tuple[str, ...]] = ("diagnosis.json", "diagnosis.html", "extended_model.json")
    pictured: ClassVar[str] = "measured channels and simulations"

    @property
    def extends(self) -> bool:
        """Whether the extended model differs from the base model, as motion in waves alone leaves it as it is."""
        base, grown = (
            (m.family, m.coefficients.tobytes(), m.constants.tobytes(), m.windage or {}, {**m.instruments})
            for m in (self.model, self.extended)
        )
        return base != grown

    def to_json(self) -> dict[str, Any]:
        """The document of schema version 3 (diagnosis.json), plain numbers only."""
        return {
            "schema": SCHEMA,
            "model": self.model.id,
            "base_parameters": self.base_parameters,
            "records": [{"file": name, "role": role} for name, role in self.records],
            "alpha": self.alpha,
            "seed": self.seed,
            "threads": self.threads,
            "verdict": self.verdict,
            "reason": self.reason,
            "causes": plain(self.causes),
            "gain": plain(self.gain),
            "calibrated_gain": plain(self.calibrated_gain),
            "of_held_out": plain(self.of_held_out),
            "ahead": None if self.ahead is None else plain(self.ahead.told_ahead()),
            "bank": plain(self.bank),
            "hypothesis": plain(self.hypothesis),
            "remaining": plain(self.remaining),
            "noise": plain(self.noise),
            "where": plain(self.where),
            "next_manoeuvre": self.next_manoeuvre,
            "doubts": list(self.doubts),
            "apart": list(self.apart),
            "checks": plain(self.checks),
            "wall_s": self.wall_s,
            "cpu_s": self.cpu_s,
        }

    def _models(self) -> dict[str, Model]:
        """The extended model, and the calibrated one where the base model's numbers were uncertain."""
        calibrated = {} if self.calibrated is None else {"calibrated_model.json": self.calibrated}
        return {self.files[2]: self.extended} | calibrated

    def __repr__(self) -> str:
        causes = ", ".join(finding.cause for finding in self.causes)
        return f"<Diagnosis of {self.model.id}: {self.verdict}{' ' + causes if causes else ''}>"
