"""What submission.json holds; its JSON schema lies in every exam."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from ...models.yaml_file import FileContent, Flag, Real, Text, needs
from ..faults.regimes import SIDES, VARIABLES

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
