"""Tracks as XML: GPX and TCX."""

from __future__ import annotations

import xml.etree.ElementTree as Tree
from pathlib import Path

import numpy as np

from ....models.errors import BadInput
from ..raw import RawColumn, RawTable

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


# ---- XML of strangers: no entities, no documents of endless depth.


def xml_root(text: str, path: Path, what: str) -> Tree.Element:
    """The root of an XML document.

    Raises
    ------
    BadInput : it declares entities, or is damaged.
    """
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput(f"{what} that declares entities", file=path, hint="export it again")
    try:
        return Tree.fromstring(text.encode("utf-8"))
    except (Tree.ParseError, ValueError, RecursionError) as error:
        raise BadInput(f"not {what} that can be read ({error})", file=path) from None


def tag_of(element: Tree.Element) -> str:
    """The tag of an element in lower case, without its namespace."""
    return str(element.tag).rpartition("}")[2].lower()


def texts_below(element: Tree.Element) -> dict[str, str]:
    """Tag -> text of all elements within one."""
    return {tag_of(child): (child.text or "").strip() for child in element.iter()}


# ---- Training Center XML (TCX): times and positions of sports watches, with the speed where it stands.

TCX_STATED = {
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
        for tag, (name, quantity, unit) in TCX_STATED.items()
        if any(point.get(tag) for point in points)
    ]
    if not columns:
        raise BadInput("no track in the TCX file", file=path)
    times = RawColumn("time", "", tuple(point["time"] for point in points), "", "TCX states it: UTC")
    rows = np.arange(1, len(points) + 1)
    return [RawTable(path.name, (times, *columns), rows, "", path.name, done=(f"TCX, {len(points)} points",))]
