"""What a model file (`model.json`, written by `model_to_json`) and a vessel file hold."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field, model_validator

from .yaml_file import FileContent, NumberWithUnit, Positive, Real, Side, Text, Texts, needs

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


# ---- Vessel files.

Degrees = Annotated[float, Field(strict=True, gt=0.0, le=180.0), needs("an angle above 0, at most 180 degrees")]


class _Number(_Measured):
    source: Text


_WORDS = "value, unit and source, and nothing else; the value is a number"
Numbers = dict[str, Annotated[_Number, needs(_WORDS)]]


class _Gear(FileContent):
    """Steering gear; null: without that limit."""

    max_deg: Degrees | None = None
    rate_deg_s: Positive | None = None
    lag_s: NotNegative | None = None
    source: Text = ""


class _Controller(FileContent):
    kp: Real
    kd: Real | None = None
    source: Text = ""


class _Windage(FileContent):
    """Areas above water and coefficients of one of two forms of the wind force."""

    form: Literal["sinusoidal", "blendermann"]
    rho_air: Positive
    A_F_m2: Positive
    A_L_m2: Positive
    cx: Real | None = None
    cy: Real | None = None
    cn: Real | None = None
    CDt: Real | None = None
    CDl_AF: Real | None = None
    delta: Real | None = None
    source: Text = ""

    @model_validator(mode="after")
    def _has_its_coefficients(self) -> _Windage:
        needed = ("cx", "cy", "cn") if self.form == "sinusoidal" else ("CDt", "CDl_AF", "delta")
        missing = [name for name in needed if getattr(self, name) is None]
        if missing:
            raise ValueError(f"the form {self.form} needs {', '.join(missing)}")
        return self


class _Suggested(FileContent):
    """What the benchmark trains on and predicts."""

    dt_s: Positive
    duration_s: Positive
    execute_s: NotNegative | None = None
    train: Texts
    held_out: Texts
    note: Text = ""


class VesselFile(FileContent):
    """Keys of a vessel file."""

    id: Text
    title: Text
    family: Text
    source: Text
    positive_rudder: Side
    max_step_s: Positive
    parameters: Numbers
    speed_m_s: Annotated[float, Field(strict=True, ge=0.0, le=200.0), needs("a number from 0 to 200")] | None = None
    n0_rps: Real | None = None
    particulars: Numbers | None = None
    constants: Numbers | None = None
    rudder: _Gear | None = None
    controller: _Controller | None = None
    windage: _Windage | None = None
    suite: _Suggested | None = None
