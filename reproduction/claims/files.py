"""Reads claims files: `NNN.yaml` in this folder."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from ...models.errors import BadInput
from .claim import Claim, Erratum, Figure, Paper, Reference, Tolerance
from .rows import expanded

FOLDER = Path(__file__).parent
KINDS = ("value", "at_most", "at_least", "holds")
SCALES = ("linear", "log")
Entry = TypeVar("Entry")


def papers() -> tuple[str, ...]:
    """Numbers of the papers with a claims file."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def load(paper: str) -> Paper:
    """The claims of a paper; raises `BadInput` for an unknown one, and for a damaged file."""
    if paper not in papers():
        raise BadInput(f"unknown paper {paper!r}", hint=f"known: {', '.join(papers())}")
    return read(FOLDER / f"{paper}.yaml")


def read(path: Path) -> Paper:
    """A claims file; raises `BadInput` naming file and entry."""
    import yaml

    data = yaml.safe_load(path.read_text(encoding="utf-8"))
    try:
        found = _paper(data)
        _check(found)
    except (TypeError, ValueError, KeyError) as error:
        raise BadInput(f"is not a claims file ({error})", file=path) from None
    return found


def _paper(data: Mapping[str, Any]) -> Paper:
    parts: dict[str, Any] = {
        "claims": [_claim(claim) for entry in data["claims"] for claim in expanded(entry)],
        "errata": _each(Erratum, data.get("errata")),
        "figures": _each(Figure, data.get("figures")),
        "references": [_reference(each) for entry in data.get("references") or () for each in expanded(entry, "value")],
        "notes": data.get("notes") or (),
    }
    parts = {name: tuple(entries) for name, entries in parts.items()}
    data = {name: value for name, value in data.items() if name != "texts"}  # texts: what entries repeat by anchors
    return Paper(**{**data, **parts, "paper": str(data["paper"])})


def _each(kind: type[Entry], entries: Iterable[Mapping[str, Any]] | None) -> list[Entry]:
    return [_entry(kind, entry) for entry in entries or ()]


def _entry(kind: type[Entry], entry: Mapping[str, Any]) -> Entry:
    named = {name: tuple(value) if isinstance(value, list) else value for name, value in entry.items()}
    try:
        return kind(**named)
    except TypeError as error:
        raise ValueError(f"{entry.get('id') or entry.get('equation') or entry}: {error}") from None


def _claim(entry: Mapping[str, Any]) -> Claim:
    own = dict(entry)
    if "reference" in own:
        own["reference"] = _reference(own["reference"])
    return _entry(Claim, own | {"tolerance": Tolerance(**own.get("tolerance", {}))})


def _reference(entry: Mapping[str, Any]) -> Reference:
    return _entry(Reference, {**entry, "tolerance": Tolerance(**entry["tolerance"])})


def _check(paper: Paper) -> None:
    ids = [claim.id for claim in paper.claims]
    if twice := {name for name in ids if ids.count(name) > 1}:
        raise ValueError(f"{sorted(twice)[0]}: the id occurs twice")
    for claim in paper.claims:
        _check_claim(claim)
    for reference in paper.references:
        if not (reference.study and reference.key and reference.quantity):
            raise ValueError(f"reference {reference.id or reference.key}: needs quantity, study and key")
    for erratum in paper.errata:
        for name in erratum.claims:
            if name not in ids:
                raise ValueError(f"erratum {erratum.equation}: there is no claim {name}")


def _check_claim(claim: Claim) -> None:
    if claim.kind not in KINDS:
        raise ValueError(f"{claim.id}: unknown kind {claim.kind!r}, known: {', '.join(KINDS)}")
    if claim.scale not in SCALES:
        raise ValueError(f"{claim.id}: unknown scale {claim.scale!r}, known: {', '.join(SCALES)}")
    if bool(claim.missing) == bool(claim.study):
        raise ValueError(f"{claim.id}: needs either a study or what is missing")
    if claim.study and not claim.corrected:
        raise ValueError(f"{claim.id}: needs the key of the corrected value")
    computed = claim.study and claim.kind != "holds"
    if computed and not (isinstance(claim.published, int | float) and math.isfinite(claim.published)):
        raise ValueError(f"{claim.id}: published is {claim.published!r}, a number is needed")
    if claim.kind == "holds" and not isinstance(claim.published, bool):
        raise ValueError(f"{claim.id}: published must be true or false")
