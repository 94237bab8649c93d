"""What the key of an exam holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from ...datasets.record import Record, RecordMeta
from ...models.yaml_file import FileContent
from ..faults.effects import Effect
from ..faults.regimes import TrueRegime
from ..faults.ships import TrueShip, ship
from ..kinds.diagnosis.plan import CaseSpec

Numbers = dict[str, str]
"""Channel -> its numbers as one text, separated by blanks."""


class Kept(FileContent):
    """What is kept back of a held-out record: the measured motion, and what the ship with its changes does without
    gusts and noise (`best`); start : first sample that counts."""

    start: int
    measured: Numbers
    best: Numbers


class WorldKey(FileContent):
    """One world.

    case : with it the truth simulator makes the same records again.  factors : of the ship's numbers on the published
    ones.  effects : cause and parameters.  right : names each of which is right, of a base model that is wrong in its
    own numbers and of regimes.  regimes : where the effects act, with the true motion of the training records.
    rmse_base, rmse_best : of the free runs of the base model and of the true ship on the held-out records.
    """

    kind: str
    case: dict[str, Any]
    factors: dict[str, float]
    effects: tuple[dict[str, Any], ...]
    right: tuple[str, ...]
    regimes: tuple[dict[str, Any], ...]
    detectable: bool | None
    train: tuple[str, ...]
    held_out: dict[str, Kept]
    motion: dict[str, Numbers]
    rmse_base: dict[str, float]
    rmse_best: dict[str, float]

    @property
    def spec(self) -> CaseSpec:
        """The case."""
        case: dict[str, Any] = {**self.case, "injected": tuple(self.case["injected"])}
        return CaseSpec(**case)

    @property
    def ship(self) -> TrueShip:
        """The ship without effects."""
        return ship(self.spec.vessel, tuple(self.factors.items()))

    @property
    def injected(self) -> list[Effect]:
        """The effects with their parameters."""
        return [Effect(one["cause"], _tuples(one["parameters"])) for one in self.effects]

    def true_regimes(self) -> list[TrueRegime]:
        """Where the effects act."""
        return [TrueRegime(**one) for one in self.regimes]

    def true_motion(self) -> list[Record]:
        """Training records of the true motion; none where nothing acts in a regime."""
        side = "port" if self.ship.starboard < 0 else "starboard"
        runs = []
        for name, channels in self.motion.items():
            columns = motion_of(channels)
            runs.append(Record(columns.pop("time_s"), columns, name, RecordMeta(positive_rudder=side)))
        return runs


class Key(FileContent):
    """The key's file: suite and seed of the draw, SHA-256 of the worlds' files, and the worlds."""

    schema_version: Literal[1]
    suite: str
    seed: int
    version: str
    files: dict[str, str]
    worlds: dict[str, WorldKey]


def motion_of(texts: Mapping[str, str]) -> dict[str, np.ndarray]:
    """Channel -> values (N,) of the numbers of a key."""
    return {channel: np.array(text.split(), float) for channel, text in texts.items()}


def _tuples(parameters: Mapping[str, Any]) -> dict[str, Any]:
    return {name: tuple(value) if isinstance(value, list) else value for name, value in parameters.items()}
