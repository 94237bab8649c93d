"""The fields of NMEA 0183 sentences that are read, with the quantities, units and signs that the standard states."""

from __future__ import annotations

from typing import Any

from .nmea_makers import LOGS, MAKERS, Field, Read


def _plain(name: str) -> Read:
    return lambda m: getattr(m, name)


def _if(name: str, status: str, good: str = "A") -> Read:
    """A field that counts where its status does."""
    return lambda m: getattr(m, name) if getattr(m, status, "") in (*good, "") else None


def _west(name: str, side: str) -> Read:
    """A field with its letter of direction as a number that is positive to east."""

    def read(m: Any) -> Any:
        number = getattr(m, name)
        return None if number in (None, "") else float(number) * (-1.0 if getattr(m, side) == "W" else 1.0)

    return read


def _revolutions(source: str) -> Read:
    return lambda m: m.rpm if m.source == source and m.status in ("A", "") else None


def _is_true_wind(m: Any) -> bool:
    return m.reference == "T" and m.status in ("A", "")


def _wind_speed(m: Any) -> Any:
    factor = {"N": 1852.0 / 3600.0, "K": 1.0 / 3.6, "M": 1.0}.get(m.speedu)
    return float(m.speed) * factor if _is_true_wind(m) and factor is not None else None


def _ordered(m: Any) -> Any:
    """The rudder that an autopilot orders: L is to port."""
    return None if not m.cmdrudderdir else float(m.cmdrudderang) * (-1.0 if m.cmdrudderdir == "L" else 1.0)


def _transducer(name: str) -> Read:
    """The angle of the transducer in whose name a word stands."""

    def read(m: Any) -> Any:
        found = (i for i in range(1, 10) if name in str(getattr(m, f"tdrid_{i:02d}", "")).lower())
        place = next((i for i in found if getattr(m, f"tdrtype_{i:02d}", "") == "A"), 0)
        return getattr(m, f"data_{place:02d}") if place else None

    return read


NOT = "not used"
POSITION = (Field("latitude", "latitude", "deg", _plain("lat")), Field("longitude", "longitude", "deg", _plain("lon")))
FIX = (
    Field("latitude", "latitude", "deg", lambda m: m.lat if m.quality else None),
    Field("longitude", "longitude", "deg", lambda m: m.lon if m.quality else None),
)
KINDS: dict[str, tuple[Field, ...]] = {
    "RMC": (
        *POSITION,
        Field("speed over ground", "speed_over_ground", "kn", _plain("spd")),
        Field("course over ground", "course_over_ground", "deg", _plain("cog")),
        Field("magnetic variation", "magnetic_variation", "deg", _west("mv", "mvEW")),
    ),
    "GGA": FIX,
    "GLL": POSITION,
    "GNS": POSITION,
    "VTG": (
        Field("course over ground", "course_over_ground", "deg", _plain("cogt")),
        Field("speed over ground", "speed_over_ground", "kn", _plain("sogn")),
    ),
    "HDT": (Field("true heading", "heading", "deg", _plain("headingT")),),
    "THS": (Field("true heading", "heading", "deg", _if("headt", "mi", "AE")),),
    "HDM": (Field("magnetic heading", "heading_magnetic", "deg", _plain("headingM")),),
    "HDG": (
        Field("magnetic heading", "heading_magnetic", "deg", _plain("headingM")),
        Field("magnetic deviation", "magnetic_deviation", "deg", _west("deviation", "deviationEW")),
        Field("magnetic variation", "magnetic_variation", "deg", _west("variation", "variationEW")),
    ),
    "ROT": (Field("rate of turn", "yaw_rate", "deg/min", _if("rot", "valid")),),
    "RSA": (
        Field("rudder, starboard or single", "rudder", "deg", _if("stbdangle", "stbdstatus")),
        Field("rudder, port", "rudder", "deg", _if("portangle", "portstatus")),
    ),
    "RPM": (
        Field("shaft revolutions", "propeller", "rpm", _revolutions("S")),
        Field("engine revolutions", NOT, "rpm", _revolutions("E")),
        Field("propeller pitch", NOT, "%", _plain("pitch")),
    ),
    "VHW": (
        Field("true heading", "heading", "deg", _plain("hdgT")),
        Field("magnetic heading", "heading_magnetic", "deg", _plain("hdgM")),
        Field("speed through water", "speed_through_water", "kn", _plain("spdN")),
    ),
    "VBW": (
        Field("longitudinal ground speed", "surge", "kn", _if("longgroundspd", "groundspdstatus")),
        Field("transverse ground speed", "sway", "kn", _if("transgroundspd", "groundspdstatus")),
        Field("longitudinal water speed", NOT, "kn", _if("longwaterspd", "waterspdstatus")),
        Field("transverse water speed", NOT, "kn", _if("transwaterspd", "waterspdstatus")),
    ),
    "MWD": (
        Field("true wind direction", "wind_direction", "deg", _plain("dirT")),
        Field("wind speed", "wind_speed", "m/s", _plain("speedM")),
    ),
    "MWV": (
        Field("true wind speed", "wind_speed", "m/s", _wind_speed),
        Field("true wind angle from the bow", NOT, "deg", lambda m: m.angle if _is_true_wind(m) else None),
    ),
    "PASHR": (Field("true heading", "heading", "deg", _plain("trueHdg")), Field("roll", "", "deg", _plain("roll"))),
    "ROR": (
        Field("rudder order, starboard or single", "rudder_command", "deg", _if("stbdrudderorder", "stbdrudderstatus")),
        Field("rudder order, port", "rudder_command", "deg", _if("portrudderorder", "portrudderstatus")),
    ),
    "HTC": (Field("rudder order", "rudder_command", "deg", _ordered),),
    "HTD": (Field("rudder order", "rudder_command", "deg", _ordered),),
    "XDR": (Field("rudder", "", "deg", _transducer("rud")), Field("roll", "", "deg", _transducer("roll"))),
    "ZDA": (),
    **MAKERS, **LOGS,
}  # fmt: skip
"""Sentence -> its columns.  The standard states units and signs: turns, rudder and sway positive to starboard."""


def is_void(message: Any) -> bool:
    """Whether the data of a sentence are void, its time is not: status V, or the mode of every receiver is N."""
    if message.msgID == "lost":
        return True
    status = getattr(message, "status", "") if message.msgID in ("RMC", "GLL") else ""
    mode = str(getattr(message, "posMode", "") or "")
    return status == "V" or (mode != "" and set(mode) == {"N"})
