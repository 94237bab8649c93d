"""Submissions: what somebody, with a method of any kind, says of the worlds of an exam.

The file comes from elsewhere: it is data, checked against the models of `submission_file`, whose JSON schema lies in
every exam.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.result import Size
from ...datasets.columns import to_canonical
from ...datasets.io import read_table
from ...diagnosis.result import Finding
from ...models.data_file import MOST_JSON_BYTES, json_of
from ...models.errors import BadInput
from ...models.model import Model, model_from_json
from ...models.suggestions import suggestion
from ...models.yaml_file import checked
from ..kinds.diagnosis.names import BASE
from .files import read_file
from .names import GROUP
from .submission_file import Answer, Named, SaidSize, Submission

if TYPE_CHECKING:
    from ...datasets.record import Record
    from .exam_file import WorldFiles
    from .folder import Exam
    from .motion import Motion

FILE = "submission.json"
MOST_PREDICTION, MOST_MODEL = 2**25, 2**24
SAME_TIME_S = 1e-6


@dataclass(frozen=True)
class Stated:
    """An answer as `judge` takes it."""

    model: Model
    verdict: str
    causes: tuple[Finding, ...]


@dataclass(frozen=True)
class Read:
    """A submission with the folder that its files are relative to."""

    file: Path
    content: Submission

    def answer(self, world: str) -> Answer:
        """What is said of a world."""
        return self.content.worlds.get(world, Answer())


def read_submission(path: Path, exam: Exam) -> Read:
    """A submission to an exam.

    path : its JSON file, or the folder that holds `submission.json`.

    Raises
    ------
    BadInput : it cannot be read, is not of this exam, or names a world, a cause, a record or a file that there is not;
        in one line with world and key.
    """
    path = path / FILE if path.is_dir() else path
    content = checked(Submission, json_of(read_file(path, MOST_JSON_BYTES), path), path)
    if content.exam != exam.id:
        raise BadInput(f"answers exam {content.exam!r}, not {exam.id!r}", file=path)
    for world, answer in content.worlds.items():
        if world not in exam.worlds:
            raise BadInput(f"worlds {world}: the exam has no such world", file=path)
        _check_names(answer, exam.worlds[world], exam.causes, f"{path}: worlds {world}")
    return Read(path, content)


def _check_names(answer: Answer, world: WorldFiles, causes: Mapping[str, Any], place: str) -> None:
    known = {*causes, *world.groups}
    records = {*world.train, *world.held_out}
    for i, one in enumerate(answer.named):
        at = f"{place} named {i}"
        for name in (one.cause, *one.tied_with):
            if name not in known:
                raise BadInput(f"unknown cause {name!r}", file=at, hint=suggestion(name, known, "causes.json has all"))
        for size in one.sizes:
            low, high = (size.value if x is None else x for x in (size.low, size.high))
            if (size.low is None) != (size.high is None) or not low <= size.value <= high:
                raise BadInput(f"size {size.parameter}: low <= value <= high does not hold", file=at)
            if size.record is not None and size.record not in records:
                raise BadInput(f"size {size.parameter}: no record {size.record!r}", file=at)
    for name in answer.motion:
        if name not in world.held_out:
            raise BadInput(f"motion {name}: no such held-out record", file=place)


def stated(answer: Answer, model: Model) -> Stated:
    """An answer in the form in which a diagnosis is judged."""
    found = tuple(map(_finding, answer.named))
    if not found:
        return Stated(model, "unexplained" if answer.unexplained else "adequate", ())
    return Stated(model, "tied" if any(one.tied_with for one in answer.named) else "named", found)


def _finding(one: Named) -> Finding:
    """A group of the base model's own numbers becomes the cause `base_coefficients` with that group."""
    details: dict[str, Any] = {} if one.regime is None else {"regime": one.regime.model_dump()}
    details |= {} if one.coefficient is None else {"coefficient": one.coefficient}
    cause, tied = one.cause, tuple(name for name in one.tied_with if not name.startswith(GROUP))
    if cause.startswith(GROUP):
        cause, details = BASE, {**details, "groups": [cause.removeprefix(GROUP)]}
    groups = [name.removeprefix(GROUP) for name in one.tied_with if name.startswith(GROUP)]
    details |= {"would do as well": groups} if groups else {}
    sizes = tuple(_size(size) for size in one.sizes)
    return Finding(cause, tied, "", float("nan"), float("nan"), sizes, details=details)


def _size(said: SaidSize) -> Size:
    low, high = (float("nan") if x is None else float(x) for x in (said.low, said.high))
    return Size(said.parameter, float(said.value), low, high, "", said.record)


def extended_model(read: Read, world: str) -> Model | None:
    """The extended model of a world, if one is given."""
    name = read.answer(world).model
    if name is None:
        return None
    path = _beside(read.file, name, f"worlds {world} model")
    read_file(path, MOST_MODEL)
    return model_from_json(path)


def given_motion(read: Read, world: str, handed_out: Sequence[Record], starts: Mapping[str, int]) -> dict[str, Motion]:
    """Name of a held-out record -> predicted motion (N,), of those that are given.

    starts : first sample that counts; from there on every number has to be finite.
    """
    files = read.answer(world).motion
    return {
        record.name: _motion(
            _beside(read.file, files[record.name], f"worlds {world} motion {record.name}"), record, starts
        )
        for record in handed_out
        if record.name in files
    }


def _motion(path: Path, record: Record, starts: Mapping[str, int]) -> Motion:
    read_file(path, MOST_PREDICTION)
    columns = to_canonical(read_table(path))
    time, start = columns.pop("time_s"), starts[record.name]
    if time.size != record.n or not np.abs(time - record.time_s).max() <= SAME_TIME_S:
        raise BadInput("has not the times of the held-out record", file=path, hint="fill in the file of the exam")
    for channel in [c for c in columns if c in record.channels]:
        wrong = np.flatnonzero(~np.isfinite(columns[channel][start:]))
        if wrong.size and np.isfinite(columns[channel][start:]).any():
            raise BadInput("no finite number", file=path, row=int(wrong[0]) + start + 2, column=channel)
    return {c: values for c, values in columns.items() if np.isfinite(values[start:]).all()}


def _beside(file: Path, name: str, key: str) -> Path:
    """A file that a submission names, in its folder or below; BadInput where it is elsewhere or reached by a link."""
    parts = PurePosixPath(name).parts
    if not parts or any(part in ("..", "/") or "\\" in part or ":" in part for part in parts):
        raise BadInput(f"{key}: {name!r} is no file beside the submission", file=file)
    path = file.parent
    for part in parts:
        path = path / part
        if path.is_symlink():
            raise BadInput(f"{key}: {name!r} is reached by a link", file=file)
    return path
