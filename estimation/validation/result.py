"""What a validation finds: plain values, SI units and radians."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...models.extras import extras_told
from ...models.files import content_writer, write_together
from ...models.result import FilePath, RunsResult, above

if TYPE_CHECKING:
    import pandas as pd

    from ...models.model import Model
    from ..run.run import Measured, Run

FREE, ONE_STEP = "free run", "one step"
SCHEMA = 1


@dataclass(frozen=True)
class ErrorScore:
    """Errors of one model.  record None: all records together; channel None: all channels together, R^2 alone.

    horizon : 'free run', 'one step' or the time ahead as text;  horizon_s : that time, None of the first two;
    n : number of samples;  rmse : in the channel's SI unit, nan where there is none;  r2 : 1 - SSE/SST, where SST is
    about the mean of each run; of all channels together it is the mean over heading, yaw rate, surge and sway.
    """

    model: str
    record: str | None
    channel: str | None
    horizon: str
    horizon_s: float | None
    n: int
    rmse: float
    r2: float


@dataclass(frozen=True)
class Index:
    """A manoeuvring index of one record, measured and simulated by one model, rad or m; nan with a reason.

    lengths_m : the ship's length, nan where unknown.
    """

    model: str
    record: str
    manoeuvre: str
    name: str
    unit: str
    measured: float
    simulated: float
    reason: str = ""
    length_m: float = np.nan

    @property
    def difference(self) -> float:
        """Simulated less measured."""
        return self.simulated - self.measured


@dataclass(frozen=True)
class LeftOut:
    """What could not be computed, and why; model or record '' where it concerns all."""

    model: str
    record: str
    what: str
    reason: str


@dataclass(frozen=True, repr=False)
class Validation(RunsResult):
    """The outcome of `validate`: errors of free runs and of predictions ahead, manoeuvring indices, free runs.

    `scores` holds RMSE and R^2 by model, record, channel and horizon, `indices` the manoeuvring indices measured and
    simulated, `runs` the free runs, `left_out` what could not be computed and why.

    models : name -> model, the validated one first;  horizons_s : times ahead;  horizon_basis : how they were chosen;
    simple : errors over all records of two predictions without a model, `constant rate of turn` and `constant heading`;
    noise : channel -> standard deviation of the sensor's noise;  trusted_s : model -> time ahead up to which it is
    better than both, nan where no time ahead was tried;  doubts : what is doubtful about the records, a sentence each.
    """

    models: Mapping[str, Model]
    records: tuple[Measured, ...]
    horizons_s: tuple[float, ...]
    horizon_basis: str
    scores: tuple[ErrorScore, ...]
    indices: tuple[Index, ...]
    runs: tuple[Run, ...]
    left_out: tuple[LeftOut, ...]
    simple: tuple[ErrorScore, ...] = ()
    noise: Mapping[str, float] = field(default_factory=dict)
    trusted_s: Mapping[str, float] = field(default_factory=dict)
    doubts: tuple[str, ...] = ()
    room: ClassVar[str] = "validation.page"
    files: ClassVar[tuple[str, ...]] = ("validation.json", "validation.html")
    pictured: ClassVar[str] = "measured channels and free runs"

    def score(
        self, channel: str | None, model: str | None = None, record: str | None = None, horizon: str = FREE
    ) -> ErrorScore | None:
        """The score with these keys; model None: the first.  None where there is none."""
        wanted = (next(iter(self.models)) if model is None else model, record, channel, horizon)
        return next((s for s in self.scores if (s.model, s.record, s.channel, s.horizon) == wanted), None)

    def told_ahead(self) -> dict[str, Any]:
        """Plain values of what is told of errors some time ahead, over all records."""
        pooled = [s for s in self.scores if s.record is None and s.channel is not None and s.horizon_s is not None]
        return {
            "horizons_s": list(self.horizons_s),
            "horizon_basis": self.horizon_basis,
            "scores": [{name: value for name, value in vars(s).items() if name != "record"} for s in pooled],
            "simple": [{name: value for name, value in vars(s).items() if name != "record"} for s in self.simple],
            "noise": dict(self.noise),
            "trusted_s": dict(self.trusted_s),
        }

    def to_json(self) -> dict[str, Any]:
        """Plain values for validation.json, without the series."""
        return {
            "schema": SCHEMA,
            "models": [
                {"name": name, "id": model.id, "family": model.family, "positive_rudder": model.positive_rudder}
                for name, model in self.models.items()
            ],
            "records": [
                {
                    "name": one.name,
                    "n_samples": int(one.time_s.size),
                    "duration_s": float(one.time_s[-1] - one.time_s[0]),
                    "channels": list(one.channels),
                }
                for one in self.records
            ],
            "horizons_s": list(self.horizons_s),
            "horizon_basis": self.horizon_basis,
            "scores": [vars(score) for score in self.scores],
            "indices": [vars(index) | {"difference": index.difference} for index in self.indices],
            "runs": [
                {
                    "model": run.model,
                    "record": run.record,
                    "starts_s": list(run.starts_s),
                    "diverged": [{"start_s": start, "after_s": after} for start, after in run.diverged],
                }
                for run in self.runs
            ],
            "simple": [vars(score) for score in self.simple],
            "noise": dict(self.noise),
            "trusted_s": dict(self.trusted_s),
            "left_out": [vars(one) for one in self.left_out],
            "doubts": list(self.doubts),
        }

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The scores: a row a model, record (None: all), channel (None: all) and horizon, with n, rmse and r2."""
        import pandas as pd

        return pd.DataFrame([vars(score) for score in self.scores])

    def certificate(self) -> str:
        """One page (HTML, for one sheet of paper) on the first model: what it was tried on, errors ahead, limits."""
        return above("reporting.validation.certificate").certificate(self)

    def write_certificate(self, path: FilePath) -> Path:
        """Write the certificate, as PDF (extra `pdf`) where the file's name ends in .pdf.

        Raises
        ------
        BadInput : the file cannot be written, or WeasyPrint is not installed.
        """
        place, page = Path(path), self.certificate()
        content = above("reporting.media").pdf(page) if place.suffix.lower() == ".pdf" else page
        return write_together(place.parent, {place.name: content_writer(content)})[0]

    def __repr__(self) -> str:
        told: list[str] = []
        for name in self.models:
            score = self.score(None, name)
            told.append(f"{name} R2 {score.r2:.3f}" if score else f"{name} without a run")
        return f"<Validation on {len(self.records)} records, free runs: {', '.join(told)}>"
