"""Hints for names that do not exist."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def near(name: str, known: Iterable[str], most: int = 1, cutoff: float = 0.6) -> str:
    """`did you mean X?` where a known name is near, whatever the case of its letters; else empty."""
    by_lower = {one.lower(): one for one in known}
    found = get_close_matches(name.lower(), by_lower, n=most, cutoff=cutoff)
    return f"did you mean {', '.join(by_lower[one] for one in found)}?" if found else ""


def suggestion(name: str, known: Iterable[str], otherwise: str = "") -> str:
    """`did you mean X?` where a known name is near, else `otherwise`, or else all that are known."""
    names = list(known)
    return near(name, names) or otherwise or f"known: {', '.join(names) or 'none'}"
