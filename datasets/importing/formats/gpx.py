"""GPX tracks: times and positions, with speed and course where they stand."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ..raw import RawColumn, RawTable
from .safe_xml import tag_of, texts_below, xml_root

STATED = {"latitude": ("latitude", "deg"), "longitude": ("longitude", "deg"), "speed": ("speed_over_ground", "m/s"),
          "course": ("course_over_ground", "deg")}  # fmt: skip


def looks_like_gpx(text: str) -> bool:
    """Whether a text is a GPX file."""
    return "<gpx" in text[:4000]


def read_gpx(text: str, path: Path) -> list[RawTable]:
    """The points of all tracks of a GPX file; BadInput where there are none, or the file declares entities."""
    root = xml_root(text, path, "a GPX file")
    points = [point for point in root.iter() if tag_of(point) == "trkpt"]
    if not points:
        raise BadInput("no track in the GPX file", file=path)
    below = [texts_below(point) for point in points]
    table = {
        "latitude": [point.get("lat", "") for point in points],
        "longitude": [point.get("lon", "") for point in points],
        "speed": [point.get("speed", "") for point in below],
        "course": [point.get("course", "") for point in below],
    }
    times = RawColumn("time", "", tuple(point.get("time", "") for point in below), "", "GPX states it: UTC")
    columns = [_column(name, values) for name, values in table.items() if any(values)]
    rows = np.arange(1, len(points) + 1)
    return [RawTable(path.name, (times, *columns), rows, "", path.name, done=(f"GPX, {len(points)} points",))]


def _column(name: str, values: list[str]) -> RawColumn:
    quantity, unit = STATED[name]
    return RawColumn(name, unit, tuple(values), quantity, "GPX states it")
