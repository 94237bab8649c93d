"""Training Center XML (TCX): times and positions of sports watches, with the speed where it stands."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ..raw import RawColumn, RawTable
from .safe_xml import tag_of, texts_below, xml_root

STATED = {
    "latitudedegrees": ("latitude", "latitude", "deg"),
    "longitudedegrees": ("longitude", "longitude", "deg"),
    "speed": ("speed", "speed_over_ground", "m/s"),
}
"""Tag -> name, quantity, unit."""


def looks_like_tcx(text: str) -> bool:
    """Whether a text is a TCX file."""
    return "<TrainingCenterDatabase" in text[:4000]


def read_tcx(text: str, path: Path) -> list[RawTable]:
    """The points of all tracks; BadInput where there are none, or the file declares entities."""
    root = xml_root(text, path, "a TCX file")
    points = [texts_below(point) for point in root.iter() if tag_of(point) == "trackpoint"]
    points = [point for point in points if point.get("time")]
    columns = [
        RawColumn(name, unit, tuple(point.get(tag, "") for point in points), quantity, "TCX states it")
        for tag, (name, quantity, unit) in STATED.items()
        if any(point.get(tag) for point in points)
    ]
    if not columns:
        raise BadInput("no track in the TCX file", file=path)
    times = RawColumn("time", "", tuple(point["time"] for point in points), "", "TCX states it: UTC")
    rows = np.arange(1, len(points) + 1)
    return [RawTable(path.name, (times, *columns), rows, "", path.name, done=(f"TCX, {len(points)} points",))]
