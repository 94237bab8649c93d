"""What the sidecar of a record holds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from ..models.yaml_file import FileContent, Side, needs
from .columns import CANONICAL


def _known(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in CANONICAL:
            raise ValueError(f"{name!r} is not a channel; {', '.join(CANONICAL)}")
    return names


Words = Annotated[str, BeforeValidator(lambda v: str(v) if isinstance(v, bool | int | float) else v), needs("a text")]
"""A text; a number or a word such as `yes` as it stands in the file."""
Channels = Annotated[
    tuple[str, ...],
    BeforeValidator(lambda v: [] if v is None else v if isinstance(v, list) else [v]),
    AfterValidator(_known),
]


class SidecarFile(FileContent):
    """Keys of a sidecar; `extra` holds whatever else is to be kept with the record."""

    vessel: Words | None = None
    reference_point: Words | None = None
    source: Words | None = None
    licence: Words | None = None
    positive_rudder: Side | None = None
    manoeuvre: Words | None = None
    notes: Words | None = None
    constant: Channels = ()
    extra: dict[str, Any] | None = None
