"""The channels of a record from the quantities of a log."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..columns import RUDDERS, TWIN
from ..geometry import body_velocities
from .geodesy import on_plane
from .quantities import quantities
from .result import FileFault


class Channels:
    """Channels in the making: `found` by name, the quantities that each is made of in `sources`, what was done in
    `steps`, faults, and facts for the sidecar."""

    def __init__(self, label: str, time: np.ndarray, values: dict[str, np.ndarray]) -> None:
        self.label, self.time, self.q = label, time, values
        self.found: dict[str, np.ndarray] = {}
        self.sources: dict[str, tuple[str, ...]] = {}
        self.steps: list[str] = []
        self.faults: list[FileFault] = []
        self.facts: dict[str, Any] = {}
        self.variation: float | None = None
        for quantity, samples in values.items():
            if channel := quantities()[quantity].channel:
                self.add((quantity,), **{channel: samples})

    def add(self, sources: tuple[str, ...], **channels: np.ndarray) -> None:
        """Add channels (N,) that are made of quantities."""
        self.found |= channels
        self.sources |= dict.fromkeys(channels, sources)

    def warn(self, message: str, hint: str = "") -> None:
        """Add a fault that does not end the import."""
        self.faults.append(FileFault(self.label, message, hint))


def derive(label: str, time: np.ndarray, values: dict[str, np.ndarray], variation_deg: float | None) -> Channels:
    """All channels that quantities give, each (N,).

    variation_deg : magnetic variation, positive to east, for a magnetic heading without one in the log.
    """
    made = Channels(label, time, values)
    _heading(made, variation_deg)
    _positions(made)
    _velocities(made)
    found = made.found
    if set(TWIN) <= found.keys() and not set(RUDDERS) & found.keys():
        made.add(("thrust_port", "thrust_starboard"), **{RUDDERS[1]: found[TWIN[0]] - found[TWIN[1]]})
        made.steps.append("steering command: port less starboard thrust, N; there is no rudder")
    for name in values:
        other = quantities()[name].partner
        if other and other not in values:
            made.warn(f"{name.replace('_', ' ')} without {other.replace('_', ' ')}: it makes no channel of the record")
    return made


def _heading(made: Channels, variation_deg: float | None) -> None:
    q = made.q
    if "heading" in q:
        made.add(("heading",), heading_rad=q["heading"])
        return
    if "heading_magnetic" not in q:
        return
    variation = q.get("magnetic_variation")
    size = np.nanmean(variation) if variation is not None else math.radians(variation_deg or 0.0)
    made.variation = float(size) if variation is not None or variation_deg is not None else None
    deviation = q.get("magnetic_deviation", np.zeros(made.time.size))
    known = np.isfinite(deviation)  # of each heading another one
    correction = size + np.where(known, deviation, deviation[known].mean() if known.any() else 0.0)
    sources = ("heading_magnetic", "magnetic_variation", "magnetic_deviation")
    made.add(sources, heading_rad=q["heading_magnetic"] + correction)
    degrees = math.degrees(float(correction.mean()))
    made.steps.append(f"heading: magnetic heading {degrees:+.3g} deg of variation, deviation")


def _positions(made: Channels) -> None:
    q = made.q
    if "north" in q and "east" in q:
        made.add(("north",), north_m=q["north"])
        made.add(("east",), east_m=q["east"])
        return
    if "latitude" not in q or "longitude" not in q:
        return
    valid = np.isfinite(q["latitude"]) & np.isfinite(q["longitude"])
    nothing = valid & (q["latitude"] == 0.0) & (q["longitude"] == 0.0)
    if nothing.any():
        made.warn(f"{int(nothing.sum())} positions at 0 N 0 E", "taken as gaps: a receiver without a fix")
    if not (valid & ~nothing).any():
        return
    latitude, longitude = (np.where(nothing, np.nan, q[name]) for name in ("latitude", "longitude"))
    north, east, plane = on_plane(latitude, longitude)
    made.add(("latitude", "longitude"), north_m=north, east_m=east)
    origin = math.degrees(plane.latitude_rad), math.degrees(plane.longitude_rad)
    made.facts["origin_deg"] = [round(value, 8) for value in origin]
    made.steps.append(
        f"north, east: plane through {origin[0]:.6f}, {origin[1]:.6f} deg; distances to {plane.scale_error:.1g} of "
        f"their size, plane north to {math.degrees(plane.convergence_rad):.2g} deg; at the receiver's antenna"
    )


def _velocities(made: Channels) -> None:
    q, heading = made.q, made.found.get("heading_rad")
    if "surge" in q:
        for name in ("surge", "sway"):
            if name in q:
                made.add((name,), **{f"{name}_m_s": q[name]})
        return
    if "velocity_north" in q and "velocity_east" in q:
        parts, told = (q["velocity_north"], q["velocity_east"]), "velocities to north and east"
        of = ("velocity_north", "velocity_east")
    elif "speed_over_ground" in q and "course_over_ground" in q:
        speed, course = q["speed_over_ground"], q["course_over_ground"]
        parts, told = (speed * np.cos(course), speed * np.sin(course)), "speed and course over ground"
        of = ("speed_over_ground", "course_over_ground")
    elif "speed_over_ground" in q:
        made.warn("a speed over ground without a course: surge and sway cannot be told apart", "speed kept aside")
        return
    else:
        return
    if heading is None:
        made.warn(f"{told} without a heading: surge and sway cannot be told apart", "kept aside")
        return
    surge, sway = body_velocities(*parts, heading)
    made.add((*of, *made.sources["heading_rad"]), surge_m_s=surge, sway_m_s=sway)
    made.steps.append(f"surge, sway: {told}, turned by the heading; at the receiver's antenna")
