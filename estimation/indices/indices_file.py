"""What a file of manoeuvring indices holds."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, create_model

from ...models.yaml_file import FileContent, Positive, Text, needs
from .given import DISTANCES, OVERSHOOT

Angle = Annotated[float, Field(strict=True, gt=0.0, lt=180.0), needs("an angle above 0 and below 180 degrees")]
Share = Annotated[float, Field(strict=True, gt=0.0, le=1.0), needs("a share above 0, at most 1")]
Length = Annotated[float, Field(strict=True, ge=0.1, le=1000.0), needs("a length from 0.1 to 1000 m")]
Speed = Annotated[float, Field(strict=True, ge=0.01, le=100.0), needs("a speed from 0.01 to 100 m/s")]
Knots = Annotated[float, Field(strict=True, ge=0.01, le=200.0), needs("a speed from 0.01 to 200 kn")]
Rate = Annotated[float, Field(strict=True, gt=0.0, le=1000.0), needs("a rate above 0, at most 1000 deg/s")]


UNITS = {
    **{f"{name}_{unit}": Positive for name in DISTANCES for unit in ("m", "lengths", "cables")},
    **{"speed_ratio": Share, "steady_speed_m_s": Speed, "steady_speed_kn": Knots},
    **{"yaw_rate_deg_s": Rate, "yaw_rate_deg_min": Positive},
    **{f"{name}_deg": Angle for name in OVERSHOOT},
}
"""Index by name and unit -> what it may be; each is left out or stands in one of its units."""
_fields: dict[str, Any] = {key: (kind | None, None) for key, kind in UNITS.items()}
Numbers: Any = create_model("Numbers", __base__=FileContent, **_fields)


class Accuracy(Numbers):
    """Standard deviations of the indices, in the same unit as each."""


class Performed(Numbers):
    """The indices of one manoeuvre."""

    manoeuvre: Text
    accuracy: Accuracy = Accuracy()


class Ship(FileContent):
    """A ship with her indices."""

    name: Text = "ship"
    length_m: Length
    speed_m_s: Speed | None = None
    speed_kn: Knots | None = None
    rudder_rate_deg_s: Rate | None = None
    rudder_max_deg: Angle | None = None
    indices: Annotated[tuple[Performed, ...], Field(min_length=1)]
