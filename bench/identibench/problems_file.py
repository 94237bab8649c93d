"""What problems.json holds."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from ...models.yaml_file import FileContent, Text

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,120}$")]


class ProblemEntry(FileContent):
    """A problem: its folder, and the columns that are inputs and outputs; the other keys say what it is."""

    model_config = ConfigDict(extra="allow", frozen=True)

    name: Name
    inputs: tuple[Text, ...] = Field(min_length=1)
    outputs: tuple[Text, ...] = Field(min_length=1)


class ProblemsFile(FileContent):
    """problems.json."""

    schema_version: Literal[1]
    suite: Text
    title: Text
    version: Text
    units: dict[str, Any]
    problems: tuple[ProblemEntry, ...] = Field(min_length=1)
