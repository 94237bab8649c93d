"""The key of an exam: what was changed in every world, and the motion that was kept back.

It is kept outside the exam's folder.  The manifest of the exam holds its SHA-256, and the key the SHA-256 of every file
of the worlds, so that a key that is published later can be checked against the exam that was handed out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ...datasets.record import Record, RecordMeta
from ...models.data_file import json_of
from ...models.errors import BadInput
from ...models.files import read_utf8
from ...models.yaml_file import FileContent, checked
from ..faults import Injected
from ..faults.effects.base import Effect
from ..faults.regimes import TrueRegime
from ..faults.sensing import CHANNELS as RECORDED
from ..faults.ships import TrueShip, ship
from ..kinds.diagnosis.judge import detectable
from ..kinds.diagnosis.plan import CaseSpec
from .motion import Motion, errors, logged, opening, predicted, rounded
from .worlds import World

SCHEMA = 1
MOST_BYTES = 2**27
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
    case: CaseSpec
    factors: dict[str, float]
    effects: tuple[dict[str, Any], ...]
    right: tuple[str, ...]
    regimes: tuple[TrueRegime, ...]
    detectable: bool | None
    train: tuple[str, ...]
    held_out: dict[str, Kept]
    motion: dict[str, Numbers]
    rmse_base: dict[str, float]
    rmse_best: dict[str, float]

    @property
    def ship(self) -> TrueShip:
        """The ship without effects."""
        return ship(self.case.vessel, tuple(self.factors.items()))

    @property
    def injected(self) -> list[Effect]:
        """The effects with their parameters."""
        return [
            Effect(one["cause"], {n: tuple(v) if isinstance(v, list) else v for n, v in one["parameters"].items()})
            for one in self.effects
        ]

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


def world_key(world: World, case: Injected, handed_out: list[Record]) -> dict[str, Any]:
    """The entry of a world; handed_out : its held-out records without their motion."""
    held_out = [logged(record) for record in case.held_out]
    best = case.held_out_without_gusts()
    starts = {record.name: opening(record) for record in held_out}
    measured: dict[str, Motion] = {record.name: record.channels for record in held_out}
    true = {record.name: {c: rounded(x) for c, x in record.channels.items()} for record in best}
    base = errors(measured, predicted(world.base(), handed_out), starts)
    regimes = [e.kind.regime(e.at(0), case.case.ship) for e in case.effects if e.kind.regime]
    return {
        "kind": world.kind,
        "case": world.spec,
        "factors": dict(world.factors),
        "effects": [{"cause": effect.cause, "parameters": dict(effect.parameters)} for effect in case.effects],
        "right": world.right,
        "regimes": regimes,
        "detectable": detectable(case) if world.spec.injected else None,
        "train": [record.name for record in case.train],
        "held_out": {
            name: {"start": starts[name], "measured": _texts(measured[name], base), "best": _texts(true[name], base)}
            for name in measured
        },
        "motion": {run.name: _texts(_columns(run)) for run in case.true_motion()} if regimes else {},
        "rmse_base": base,
        "rmse_best": {c: x for c, x in errors(measured, true, starts).items() if c in base},
    }


def _columns(run: Record) -> dict[str, np.ndarray]:
    """Time and motion of a true run."""
    columns = {c: rounded(run.column(c)) for c in RECORDED if run.has(c)}
    return {"time_s": run.time_s, **columns}


def _texts(motion: Motion, channels: Mapping[str, object] | None = None) -> Numbers:
    kept = motion if channels is None else channels
    return {c: " ".join(map(repr, motion[c].tolist())) for c in kept if c in motion}


def digest(data: bytes) -> str:
    """SHA-256 in hexadecimal digits."""
    return hashlib.sha256(data).hexdigest()


def read_key(path: Path, expected: str) -> Key:
    """The key of an exam.

    expected : its SHA-256 as the exam's manifest says it.

    Raises
    ------
    BadInput : the file cannot be read, or is the key of another exam.
    """
    data = read_utf8(path, MOST_BYTES)
    if digest(data) != expected:
        raise BadInput("is not the key of this exam", file=path, hint="its SHA-256 is not the one in exam.json")
    return checked(Key, json_of(data, path), path)
