"""Effects in records: `inject` makes the records of a case, `inject_in_record` changes a measured one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput
from . import sensing
from .effects.base import Effect, kind_of, kinds
from .frames import FaultCase, Frames
from .strength import draw_effect


@dataclass(frozen=True, eq=False)
class Injected:
    """The records of a case and what is in them.

    noncentrality: of the weakest of the drawn effects, each on its own on the training records (nan for a case
    without effects that have a size).  frames: the case, and what its records share.
    """

    frames: Frames
    train: list[Record]
    held_out: list[Record]
    effects: tuple[Effect, ...]
    noncentrality: float

    @property
    def case(self) -> FaultCase:
        """The case with its defaults filled in."""
        return self.frames.case

    @property
    def truth(self) -> list[dict[str, Any]]:
        """[{cause, parameters, units}], per-record values as lists (training records first)."""
        return [{"cause": e.cause, "parameters": dict(e.parameters), "units": dict(e.kind.units)} for e in self.effects]

    def held_out_without_gusts(self) -> list[Record]:
        """What the ship with its effects does in the held-out records under the same rudder without gusts, recorded
        without noise and gaps: the best that a model of the ship could predict."""
        out = []
        for i in range(len(self.train), self.frames.count):
            run = self.frames.run(self.effects, i)
            if self.frames.gusts is not None:
                run = self.frames.run(self.effects, i, run.rudder, calm=True)
            out.append(self.frames.record(self.effects, i, run, np.random.default_rng(0), noise=False))
        return out

    def true_motion(self) -> list[Record]:
        """The motion of the training records as it was, in all channels without errors of the sensors."""
        frames, rng = self.frames.changed(channels=sensing.CHANNELS), np.random.default_rng(0)
        runs = [frames.run(self.effects, i) for i in range(len(self.train))]
        return [frames.record((), i, run, rng, noise=False) for i, run in enumerate(runs)]


def inject(case: FaultCase, rng: np.random.Generator) -> Injected:
    """Draw the effects of a case, scale each to the strength, and make the records."""
    frames = Frames.draw(case, rng)
    drawn = [draw_effect(frames.changed(foreign=False), cause, rng) for cause in case.causes]
    found = (*case.effects, *(effect.spread(case.spread, frames.count, rng) for effect, _ in drawn))
    power = min((power for _, power in drawn if not np.isnan(power)), default=float("nan"))
    runs = [frames.run(found, i) for i in range(frames.count)]
    records = [frames.record(found, i, run, rng) for i, run in enumerate(runs)]
    n = len(frames.case.train)
    return Injected(frames, records[:n], records[n:], found, power)


def inject_in_record(record: Record, cause: str, parameters: dict[str, Any], rng: np.random.Generator) -> Record:
    """The record as it would read under an effect of the sensors or the rudder channel, with gaps where a delayed
    channel has no value.  `BadInput` for another effect or a missing channel."""
    kind = kind_of(cause)
    if not kind.fits_measured:
        able = ", ".join(name for name, known in kinds().items() if known.fits_measured)
        raise BadInput(f"{cause} cannot be injected in a measured record", hint=f"{able} can")
    columns = {name: record.column(name).copy() for name in record.channels}
    if "heading_rad" in columns:
        columns["heading_rad"] = record.heading_unwrapped().copy()
    try:
        (kind.change_record or kind.apply)(columns, record.time_s, parameters, {}, rng)
    except KeyError as error:
        raise BadInput(f"{cause} needs the column {error}", file=record.name) from None
    return record.with_channels(**columns)
