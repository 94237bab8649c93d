"""What the sidecar of a record holds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator

from ..models.yaml_file import FileContent, Side, needs
from .columns import CANONICAL


def _text(value: Any) -> Any:
    """A number or a word such as `yes` as the text that stands in the file."""
    return str(value) if isinstance(value, bool | int | float) else value


def _channels(value: Any) -> Any:
    return [] if value is None else value if isinstance(value, list) else [value]


def _known(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if name not in CANONICAL:
            raise ValueError(f"{name!r} is not a channel; {', '.join(CANONICAL)}")
    return names


Words = Annotated[str, BeforeValidator(_text), needs("a text")]


class SidecarFile(FileContent):
    """Keys of a sidecar; `extra` holds whatever else is to be kept with the record."""

    vessel: Words | None = None
    reference_point: Words | None = None
    source: Words | None = None
    licence: Words | None = None
    positive_rudder: Side | None = None
    manoeuvre: Words | None = None
    notes: Words | None = None
    constant: Annotated[tuple[str, ...], BeforeValidator(_channels), AfterValidator(_known)] = ()
    extra: dict[str, Any] | None = None
