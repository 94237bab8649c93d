"""Submissions: what somebody, with a method of any kind, says of the worlds of an exam.

The file comes from elsewhere: it is data, checked against the models below, whose JSON schema lies in every exam.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field

from ...checks.result import Size
from ...datasets.columns import to_canonical
from ...datasets.io import read_table
from ...datasets.record import Record
from ...diagnosis.result import Finding
from ...models.data_file import MOST_JSON_BYTES, json_of
from ...models.errors import BadInput
from ...models.folders import path_within
from ...models.model import Model, model_from_json
from ...models.suggestions import suggestion
from ...models.yaml_file import FileContent, Flag, Real, Text, checked, needs
from ..faults.regimes import SIDES, VARIABLES
from ..kinds.diagnosis.judge import BASE
from .exam_file import GROUP, WorldFiles, read_file

if TYPE_CHECKING:
    from .folder import Exam
    from .motion import Motion

FILE = "submission.json"
MOST_PREDICTION, MOST_MODEL = 2**25, 2**24
SAME_TIME_S = 1e-6
MOST_NAMED, MOST_SIZES = 20, 200


def _printable(text: str) -> str:
    if not text.isprintable() or not text.strip():
        raise ValueError("hidden characters")
    return text


Short = Annotated[str, Field(min_length=1, max_length=120), needs("a text of 1 to 120 characters")]
EntrantName = Annotated[
    str, Field(min_length=1, max_length=120), AfterValidator(_printable), needs("1 to 120 printable characters")
]
Variable = Annotated[
    Literal["rudder", "drift", "yaw_rate", "speed", "side", "time"], needs(f"one of {', '.join(VARIABLES)}")
]
RegimeSide = Annotated[Literal["above", "below", "port", "starboard"], needs(f"one of {', '.join(SIDES)}")]


class SaidSize(FileContent):
    """A size of a cause, SI: value, interval if there is one, and the record that it belongs to (none: all)."""

    parameter: Short
    value: Real
    low: Real | None = None
    high: Real | None = None
    record: Short | None = None


class SaidRegime(FileContent):
    """Where a change acts: rudder, drift (rad), yaw_rate (rad/s), speed (m/s), side or time (s) above or below a
    threshold, or where it points to port or starboard by more than the threshold."""

    variable: Variable
    side: RegimeSide
    threshold: Real = 0.0


class NamedCause(FileContent):
    """One thing that is wrong.

    cause : a name of causes.json, or `group:` and a group of the base model's own numbers (exam.json).  tied_with :
    names that would do as well.  coefficient : the number of the model that a cause `coefficient_shift` is about.
    """

    cause: Short
    tied_with: Annotated[tuple[Short, ...], Field(max_length=MOST_NAMED)] = ()
    sizes: Annotated[tuple[SaidSize, ...], Field(max_length=MOST_SIZES)] = ()
    regime: SaidRegime | None = None
    coefficient: Short | None = None


class WorldAnswer(FileContent):
    """What is said of one world.

    named : what is wrong, the surest first; empty: nothing is.  unexplained : something is wrong that has no name here.
    motion : name of a held-out record -> CSV file beside the submission, the record's file with its empty cells filled
    in.  model : file of an extended model (helmbench's model.json), which is simulated where there is no such motion.
    """

    named: Annotated[tuple[NamedCause, ...], Field(max_length=MOST_NAMED)] = ()
    unexplained: Flag = False
    motion: dict[Short, Short] = Field(default_factory=dict)
    model: Short | None = None


class Submission(FileContent):
    """A submission's file; a world that it leaves out is answered by: nothing is wrong."""

    schema_version: Annotated[Literal[1], needs("1")]
    exam: Short
    entrant: EntrantName
    about: Text = ""
    worlds: dict[Short, WorldAnswer] = Field(default_factory=dict)


def submission_schema() -> dict[str, Any]:
    """The JSON schema of submissions (draft 2020-12)."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **Submission.model_json_schema()}


@dataclass(frozen=True)
class StatedDiagnosis:
    """An answer as `judge` takes it."""

    model: Model
    verdict: str
    causes: tuple[Finding, ...]


@dataclass(frozen=True)
class Read:
    """A submission with the folder that its files are relative to."""

    file: Path
    content: Submission

    def answer(self, world: str) -> WorldAnswer:
        """What is said of a world."""
        return self.content.worlds.get(world, WorldAnswer())


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


def read_submissions(paths: Sequence[Path], exam: Exam) -> list[Read]:
    """Submissions of different entrants; raises as `read_submission`, and where two have the same name.

    Names that differ only in case, blanks, marks or the form of a character are the same.
    """
    found: dict[str, Read] = {}
    for path in paths:
        read = read_submission(path, exam)
        letters = unicodedata.normalize("NFKC", read.content.entrant).casefold()
        own = "".join(filter(str.isalnum, letters)) or letters
        if own in found:
            told = f"entrant {read.content.entrant!r} is that of {found[own].file} too"
            raise BadInput(
                told, file=read.file, hint="one submission an entrant: take one of them, or give it another name"
            )
        found[own] = read
    return list(found.values())


def _check_names(answer: WorldAnswer, world: WorldFiles, causes: Mapping[str, Any], place: str) -> None:
    known = {*causes, *world.groups}
    records = {*world.train, *world.held_out}
    said = [(one.cause, one.coefficient) for one in answer.named]
    for i, one in enumerate(answer.named):
        at = f"{place} named {i}"
        for name in (one.cause, *one.tied_with):
            if name not in known:
                raise BadInput(f"unknown cause {name!r}", file=at, hint=suggestion(name, known, "causes.json has all"))
        if said.index(said[i]) < i:
            raise BadInput(f"{one.cause!r} is named twice", file=at, hint="name a cause once, with all its sizes")
        _check_sizes(one.sizes, records, at)
    for name in answer.motion:
        if name not in world.held_out:
            raise BadInput(f"motion {name}: no such held-out record", file=place)


def _check_sizes(sizes: Sequence[SaidSize], records: AbstractSet[str], at: str) -> None:
    seen: set[tuple[str, str | None]] = set()
    for size in sizes:
        low, high = (size.value if x is None else x for x in (size.low, size.high))
        if (size.low is None) != (size.high is None) or not low <= size.value <= high:
            raise BadInput(f"size {size.parameter}: low <= value <= high does not hold", file=at)
        if size.record is not None and size.record not in records:
            raise BadInput(f"size {size.parameter}: no record {size.record!r}", file=at)
        if (size.parameter, size.record) in seen:
            told = f"of record {size.record}" if size.record else "of all records"
            raise BadInput(f"size {size.parameter} {told} is stated twice", file=at, hint="state it once")
        seen.add((size.parameter, size.record))


def stated(answer: WorldAnswer, model: Model) -> StatedDiagnosis:
    """An answer in the form in which a diagnosis is judged."""
    found = tuple(map(_finding, answer.named))
    if not found:
        return StatedDiagnosis(model, "unexplained" if answer.unexplained else "adequate", ())
    return StatedDiagnosis(model, "tied" if any(one.tied_with for one in answer.named) else "named", found)


def _finding(one: NamedCause) -> Finding:
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
    path = path_within(read.file.parent, name, read.file, f"worlds {world} model")
    read_file(path, MOST_MODEL)
    return model_from_json(path)


def given_motion(read: Read, world: str, handed_out: Sequence[Record], starts: Mapping[str, int]) -> dict[str, Motion]:
    """Name of a held-out record -> predicted motion (N,), of those that are given.

    starts : first sample that counts; from there on every number has to be finite.
    """
    files, at = read.answer(world).motion, f"worlds {world} motion"
    records = {record.name: record for record in handed_out}
    return {
        name: _motion(path_within(read.file.parent, files[name], read.file, f"{at} {name}"), record, starts)
        for name, record in records.items()
        if name in files
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
