"""Tracks as XML: GPX, and Training Center XML (TCX), in which sports watches write them."""

from __future__ import annotations

import xml.etree.ElementTree as Tree
from pathlib import Path

from ....models.errors import BadInput
from ..raw import RawColumn, RawTable
from .fields import stated_fields

KINDS = {"GPX": "<gpx", "TCX": "<TrainingCenterDatabase"}
"""Kind -> how its document begins."""


def read_track(text: str, path: Path) -> list[RawTable] | None:
    """The points of all tracks of a GPX or TCX file, None where the text is neither; BadInput where there are none, or
    the file declares entities."""
    kind = next((kind for kind, begin in KINDS.items() if begin in text[:4000]), None)
    if kind is None:
        return None
    ((tag, fields),) = stated_fields(kind).items()
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
