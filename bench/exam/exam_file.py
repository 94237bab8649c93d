"""What exam.json holds."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from ...models.yaml_file import FileContent, Text

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
