"""Tracks as XML: GPX, and Training Center XML (TCX), in which sports watches write them."""

from __future__ import annotations

import xml.etree.ElementTree as Tree
from pathlib import Path

from ....models.errors import BadInput
from ..raw import RawColumn, RawTable

Fields = dict[str, tuple[str, str, str]]
KINDS: dict[str, tuple[str, str, Fields]] = {
    "GPX": ("<gpx", "trkpt", {
        "lat": ("latitude", "latitude", "deg"), "lon": ("longitude", "longitude", "deg"),
        "speed": ("speed", "speed_over_ground", "m/s"), "course": ("course", "course_over_ground", "deg"),
    }),
    "TCX": ("<TrainingCenterDatabase", "trackpoint", {
        "latitudedegrees": ("latitude", "latitude", "deg"), "longitudedegrees": ("longitude", "longitude", "deg"),
        "speed": ("speed", "speed_over_ground", "m/s"),
    }),
}  # fmt: skip
"""Kind -> how its document begins, the tag of a point, and tag or attribute of a point -> name, quantity, unit."""


def looks_like_track(text: str) -> bool:
    """Whether a text is a GPX or TCX file."""
    return _kind(text) is not None


def _kind(text: str) -> str | None:
    return next((kind for kind, (begin, *_) in KINDS.items() if begin in text[:4000]), None)


def read_track(text: str, path: Path) -> list[RawTable]:
    """The points of all tracks of a GPX or TCX file; BadInput where there are none, or the file declares entities."""
    kind = _kind(text) or ""
    _, tag, fields = KINDS[kind]
    points = [_texts(point) for point in _root(text, path, kind).iter() if _tag(point) == tag]
    points = [point for point in points if kind == "GPX" or point.get("time")]
    columns = [
        RawColumn(name, unit, tuple(point.get(field, "") for point in points), quantity, f"{kind} states it")
        for field, (name, quantity, unit) in fields.items()
        if any(point.get(field) for point in points)
    ]
    if not columns:
        raise BadInput(f"no track in the {kind} file", file=path)
    times = RawColumn("time", "", tuple(point.get("time", "") for point in points), "", f"{kind} states it: UTC")
    return [RawTable.of(path, (times, *columns), f"{kind}, {len(points)} points")]


def _root(text: str, path: Path, kind: str) -> Tree.Element:
    """The root of an XML document of a stranger: BadInput where it declares entities, or is damaged."""
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise BadInput(f"a {kind} file that declares entities", file=path, hint="export it again")
    try:
        return Tree.fromstring(text.encode("utf-8"))
    except (Tree.ParseError, ValueError, RecursionError) as error:
        raise BadInput(f"not a {kind} file that can be read ({error})", file=path) from None


def _tag(element: Tree.Element) -> str:
    """The tag of an element in lower case, without its namespace."""
    return str(element.tag).rpartition("}")[2].lower()


def _texts(point: Tree.Element) -> dict[str, str]:
    """Attribute of a point, or tag of an element within it -> its text."""
    return {**{_tag(child): (child.text or "").strip() for child in point.iter()}, **point.attrib}
