"""The key of an exam: what was changed in every world, and the motion that was kept back.

It is kept outside the exam's folder.  The manifest of the exam holds its SHA-256, and the key the SHA-256 of every file
of the worlds, so that a key that is published later can be checked against the exam that was handed out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.record import Record
from ...models.data_file import json_of
from ...models.errors import BadInput
from ...models.files import read_utf8
from ...models.yaml_file import checked
from ..faults.effects import RegimeKind
from ..faults.sensing import CHANNELS as RECORDED
from ..kinds.diagnosis.judge import detectable
from .key_file import Key, Numbers
from .motion import Motion, errors, logged, opening, predicted, rounded
from .worlds import World

if TYPE_CHECKING:
    from ..faults import Injected

SCHEMA = 1
MOST_BYTES = 2**27


def world_key(world: World, case: Injected, handed_out: list[Record]) -> dict[str, Any]:
    """The entry of a world; handed_out : its held-out records without their motion."""
    held_out = [logged(record) for record in case.held_out]
    best = case.held_out_without_gusts()
    starts = {record.name: opening(record) for record in held_out}
    measured: dict[str, Motion] = {record.name: record.channels for record in held_out}
    true = {record.name: {c: rounded(x) for c, x in record.channels.items()} for record in best}
    base = errors(measured, predicted(world.base(), handed_out), starts)
    regimes = [e.kind.regime(e.at(0), case.case.ship) for e in case.effects if isinstance(e.kind, RegimeKind)]
    return {
        "kind": world.kind,
        "case": asdict(world.spec),
        "factors": dict(world.factors),
        "effects": [{"cause": effect.cause, "parameters": dict(effect.parameters)} for effect in case.effects],
        "right": world.right,
        "regimes": [vars(regime) for regime in regimes],
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
