"""What a vessel file holds."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import StrictFloat, StrictInt

from .yaml_file import FileContent, Positive, Text, needs

Real = Annotated[StrictInt | StrictFloat, needs("a number")]


class _Number(FileContent):
    value: StrictInt | StrictFloat
    unit: Text
    source: Text


_WORDS = "value, unit and source, and nothing else; the value is a number (1.0e-3, not 1e-3)"
Numbers = dict[str, Annotated[_Number, needs(_WORDS)]]


class VesselFile(FileContent):
    """Keys of a vessel file; what `rudder`, `controller`, `windage` and `suite` hold is checked where it is used."""

    id: Text
    title: Text
    family: Text
    source: Text
    positive_rudder: Annotated[Literal["port", "starboard"], needs("port or starboard")]
    max_step_s: Positive
    parameters: Numbers
    speed_m_s: Real | None = None
    n0_rps: Real | None = None
    particulars: Numbers | None = None
    constants: Numbers | None = None
    rudder: dict[str, Any] | None = None
    controller: dict[str, Any] | None = None
    windage: dict[str, Any] | None = None
    suite: dict[str, Any] | None = None
