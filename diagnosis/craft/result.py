"""What a craft's diagnosis says: what steers it, what simpler models lack, how far ahead the model can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ...models.plain import plain
from ...models.result import RunsResult

if TYPE_CHECKING:
    import numpy as np

    from ...estimation.validation.result import Validation
    from ...models.model import Model
    from ..result import Finding

SCHEMA = 1
ADEQUATE, PARTLY, UNEXPLAINED, INCONCLUSIVE = "adequate", "partly_named", "unexplained", "inconclusive"
NO_EFFECT, FOLLOWS = "input_hardly_acts", "input_follows_output"
OUTSIDE = "outside_training"
FIRST, BUILT, SHIP, OWN_SPEED = "law alone", "built model", "particulars", "own speed"
"""Names of the models whose errors ahead stand beside each other: the law alone, all steps, the simulation of
particulars, and all steps with surge and sway of its own."""


@dataclass(frozen=True)
class Rise:
    """One step of the ladder: fall of the logarithm of left-out errors with its standard error (0.05: by 5 %), and the
    shares of the motion of left-out windows that the model with it explains."""

    id: str
    title: str
    gain: float
    error: float
    r2_yaw_rate: float
    r2_heading: float
    numbers: int


@dataclass(frozen=True)
class LawTold(Rise):
    """A steering law alone: by how much its left-out errors are below those of the best (0: it is the best; negative:
    they are larger, -0.05 by 5 %), what was chosen, and whether the records cannot tell it from the best."""

    chosen: bool
    tied: bool


def by_thrust(laws: Sequence[LawTold]) -> bool:
    """Whether orders are forces, N, and no angles: the records have those of two thrusters, and that law was tried."""
    return any(law.id == "twin_thrusters" for law in laws)


@dataclass(frozen=True)
class NumberTold:
    """A number of the model with its 90 % interval, SI."""

    name: str
    unit: str
    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Band:
    """How far heading can be trusted: standard deviation, rad, after a time, s."""

    after_s: float
    sd_rad: float


@dataclass(frozen=True, repr=False)
class CraftDiagnosis(RunsResult):
    """The outcome of `build_model`: what steers the craft, what simpler models lack, how far ahead to trust the model.

    `simulate`, `validate` and `diagnose` take the built model like any other; `steps` is the ladder, `band` how far
    heading can be trusted.

    first, model : the chosen steering law alone, and the model that was built.
    ship : the simulation of the particulars, corrected by the training records; None where none were given.
    own_speed : the model with surge and sway of its own, which needs no measured speed; None where none was measured.
    window_s : length of the windows, s.
    ahead : both models along the held-out records (the training records where none is held out).
    inside : share of held-out heading errors within one standard deviation of the band; nan without held-out records.
    refused : rungs that were tried last: id, fall of the errors, standard error.
    covariance : (p, p) of the model's coefficients.
    own_angles : record -> its own neutral angle beside the common one, rad or the command's unit.
    causes : what the channels show of their sensors; errors of the yaw rate were corrected in the records, and are
    instruments of the models.
    notes : what a reader must know, a sentence each.
    """

    model: Model
    first: Model
    records: tuple[tuple[str, str], ...]
    verdict: str
    reason: str
    window_s: float
    laws: tuple[LawTold, ...]
    steps: tuple[Rise, ...]
    numbers: tuple[NumberTold, ...]
    refused: tuple[tuple[str, float, float], ...]
    band: tuple[Band, ...]
    inside: float
    own_angles: tuple[tuple[str, float], ...]
    ahead: Validation
    trusted_s: float
    next_runs: str
    covariance: np.ndarray
    wall_s: float
    ship: Model | None = None
    own_speed: Model | None = None
    causes: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    room: ClassVar[str] = "craft"
    files: ClassVar[tuple[str, ...]] = ("diagnosis.json", "diagnosis.html", "extended_model.json")
    pictured: ClassVar[str] = "measured channels and free runs"

    def to_json(self) -> dict[str, Any]:
        """The diagnosis as plain data, without the models' equations."""
        hidden = ("model", "first", "ship", "own_speed", "ahead", "covariance")
        told = plain({name: value for name, value in self.__dict__.items() if name not in hidden})
        return {"schema": SCHEMA, "family": self.model.family, **told, "ahead": self.ahead.to_json()}

    def _models(self) -> dict[str, Model]:
        """The built model, the one with surge and sway of its own, and the corrected simulation of particulars."""
        every = {
            self.files[2]: self.model,
            "own_speed_model.json": self.own_speed,
            "particulars_model.json": self.ship,
        }
        return {name: model for name, model in every.items() if model is not None}

    def __repr__(self) -> str:
        return f"<CraftDiagnosis: {self.verdict}, {self.model.family}>"
