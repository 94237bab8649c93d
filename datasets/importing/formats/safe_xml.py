"""XML of strangers: no entities, no documents of endless depth."""

from __future__ import annotations

import xml.etree.ElementTree as Tree
from pathlib import Path

from ....models.errors import BadInput


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
