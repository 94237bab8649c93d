"""What exam.json holds, how files of exams are read, and the public names of causes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from ...diagnosis.causes.registry import causes
from ...models.coefficient_groups import stated_groups
from ...models.errors import BadInput
from ...models.folders import check_regular, read_regular
from ...models.model import Model
from ...models.yaml_file import FileContent, Text
from ..faults import kinds
from ..kinds.diagnosis.judge import BASE

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,40}$")]


class WorldFiles(FileContent):
    """A world as it is handed out: names of its training and held-out records, files NAME.csv in its folder.

    base_numbers : whether the numbers of the base model are exact, or uncertain.  opening_s : time of each held-out
    record up to which its motion is shown.  groups : of the base model's own numbers.
    """

    base_numbers: Literal["exact", "uncertain"]
    train: tuple[Name, ...]
    held_out: tuple[Name, ...]
    opening_s: dict[Name, float]
    groups: dict[str, dict[str, Any]]


class Manifest(FileContent):
    """exam.json."""

    schema_version: Literal[1]
    exam: Text
    title: Text
    version: Text
    key_sha256: Text
    files: dict[str, Text]
    worlds: dict[Name, WorldFiles]


# ---- Files of exams and submissions, which may come from elsewhere.


def read_file(path: Path, most: int) -> bytes:
    """A regular file of at most `most` bytes; BadInput where it is missing, a link or larger."""
    if not check_regular(path):
        raise BadInput("no such file", file=path)
    return read_regular(path, most=most)


# ---- The public names of an exam: causes with what their sizes are called, and groups of a model's own numbers.

GROUP = "group:"
"""What the name of a group of a model's own numbers begins with: some causes have the same identifier."""
MORE = {
    "shallow_water": {"draught_over_depth": "1"},
    "speed_loss": {"loss_gain": "1"},
    "second_order_lead": {"lead": "1"},
}
"""Cause -> further sizes by which it may be stated."""


def cause_list() -> dict[str, dict[str, Any]]:
    """Cause -> what it is, and its sizes with their units; the same for every exam."""
    known = kinds()
    return {
        name: {
            "what": " ".join(cause.physics.split()),
            "sizes": ({k: u for k, u in known[name].units.items() if u} if name in known else {}) | MORE.get(name, {}),
        }
        for name, cause in causes().items()
        if name != BASE
    }


def group_list(model: Model) -> dict[str, dict[str, Any]]:
    """Group of a model's own numbers -> what it is, and its numbers."""
    return {GROUP + g.id: {"what": g.title, "numbers": sorted(g.every)} for g in stated_groups(model)}
