"""What a model file holds (`model.json`, written by `model_to_json`)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from .yaml_file import FileContent, NumberWithUnit, Positive, Real, Side, Text, needs

SCHEMA = 1
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False), needs("a number of at least 0")]
Speed = Annotated[float, Field(strict=True, ge=0.0, le=200.0), needs("a speed from 0 to 200 m/s")]
Angle = Annotated[float, Field(strict=True, gt=0.0, le=3.1416), needs("an angle above 0, at most 3.1416 rad")]


class _ModelGear(FileContent):
    """Steering gear in rad, rad/s and s; null: without that limit."""

    max_rad: Angle | None = None
    rate_rad_s: Positive | None = None
    lag_s: NotNegative = 0.0


class _ModelController(FileContent):
    kp: Real
    kd: Real = 0.0


class _WindForce(FileContent):
    """Constants of the wind force, by the names that the kernels use."""

    rho_air: NotNegative
    A_F: NotNegative
    A_L: NotNegative
    wind_cx: Real
    wind_cy: Real
    wind_cn: Real = 0.0
    wind_kn: Real = 0.0
    wind_delta: Real = 0.0


class _Measured(FileContent):
    value: Real
    unit: Text


class ModelFile(FileContent):
    """Keys of a model file.

    Either `coefficients`, or `parameters` from which they follow; where both stand they must agree.  Numbers without a
    unit beside them are in SI units and radians.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, protected_namespaces=())

    schema_: Annotated[Literal[1], needs(f"{SCHEMA}, the schema of this version")] = Field(alias="schema")
    family: Text
    positive_rudder: Side
    id: Text = ""
    title: Text = ""
    source: Text = ""
    vessel: Text | None = None
    speed_m_s: Speed | None = None
    n0_rps: Real | None = None
    max_step_s: Positive = 0.1
    coefficients: dict[str, Real | None] | None = None
    parameters: dict[str, NumberWithUnit] = {}  # noqa: RUF012, pydantic copies it
    constants: dict[str, Real | None] = {}  # noqa: RUF012
    rudder: _ModelGear = _ModelGear()
    controller: _ModelController | None = None
    windage: _WindForce | None = None
    particulars: dict[str, Real] = {}  # noqa: RUF012
    instruments: dict[str, _Measured] = {}  # noqa: RUF012
