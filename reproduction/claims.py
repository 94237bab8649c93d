"""A paper's claims, errata and figures, from `claims/NNN.yaml`."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ..models.errors import BadInput
from .compact import expanded

FOLDER = Path(__file__).parent / "claims"
KINDS = ("value", "at_most", "at_least", "holds")
SCALES = ("linear", "log")
ROMAN = {"i": 1, "ii": 2, "iii": 3, "iv": 4, "v": 5, "vi": 6, "vii": 7, "viii": 8, "ix": 9, "x": 10}
Entry = TypeVar("Entry")


@dataclass(frozen=True)
class Tolerance:
    """What counts as equal: `relative` of the published value, or `absolute` in its unit, or the larger of both."""

    relative: float = 0.0
    absolute: float = 0.0

    def around(self, value: float) -> float:
        """Half the width of the interval that counts as `value`."""
        return max(abs(value) * self.relative, self.absolute)


@dataclass(frozen=True)
class Reference:
    """What an independent computation of the same quantity gave: ours must lie within the tolerance of it.

    With `kind` 'at_most' or 'at_least' it is a bound that ours must keep.

    `study` and `key` default to those of the claim it belongs to (`corrected`).
    """

    value: float
    tolerance: Tolerance
    id: str = ""
    quantity: str = ""
    unit: str = ""
    study: str = ""
    key: str = ""
    kind: str = "value"
    note: str = ""


@dataclass(frozen=True)
class Claim:
    """One number or statement of a paper, and how it is computed.

    Parameters
    ----------
    item : table, figure or section, "Table 5".
    published : the number as printed, in `unit`; true for a statement (kind 'holds').
    kind : 'value'; 'at_most' and 'at_least' for bounds; 'holds'.
    study, corrected, as_printed : the study and the keys of its values under corrected and printed equations.
    protocol : how it is computed, and what the paper leaves unsaid.
    equation : the wrong equation, "(26)".
    reason : one sentence, or one for each verdict; {published}, {corrected}, {as_printed}, {low}, {high} are filled in.
    missing : why nothing can be computed, instead of a study.
    nonzero : the value only counts as reproduced by an interval that excludes zero; for coefficients that records may
        not tell at all.
    widest : an interval wider than this multiple of the published value reproduces nothing.
    scale : 'log' for errors and other positive sizes, whose interval is taken of the logarithms; 'linear'.
    """

    id: str
    item: str
    quantity: str
    published: Any
    unit: str = ""
    kind: str = "value"
    tolerance: Tolerance = Tolerance()
    study: str = ""
    corrected: str = ""
    as_printed: str = ""
    protocol: str = ""
    equation: str = ""
    reason: str | Mapping[str, str] = ""
    missing: str = ""
    nonzero: bool = False
    widest: float = math.inf
    scale: str = "linear"
    reference: Reference | None = None


@dataclass(frozen=True)
class Erratum:
    """A printed equation, the corrected one and what follows; `claims` are the ids that show it."""

    equation: str
    printed: str
    corrected: str
    consequence: str
    claims: tuple[str, ...] = ()


@dataclass(frozen=True)
class Figure:
    """A figure that the function `draw` of the paper's module draws from a study's results."""

    id: str
    title: str
    caption: str
    study: str
    draw: str


@dataclass(frozen=True)
class Paper:
    """Everything that is claimed of one paper."""

    paper: str
    title: str
    citation: str
    claims: tuple[Claim, ...]
    errata: tuple[Erratum, ...] = ()
    figures: tuple[Figure, ...] = ()
    references: tuple[Reference, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def studies(self) -> tuple[str, ...]:
        """Names of the studies that claims, references and figures need."""
        named = [entry.study for entry in (*self.claims, *self.references, *self.figures) if entry.study]
        return tuple(dict.fromkeys(named))

    @property
    def tables(self) -> tuple[int, ...]:
        """Numbers of the tables that claims are about."""
        numbers = {table_number(claim.item) for claim in self.claims}
        return tuple(sorted(n for n in numbers if n is not None))

    def logarithmic(self, study: str) -> set[str]:
        """Keys of the study whose interval is taken on a logarithmic scale."""
        own = [claim for claim in self.claims if claim.study == study and claim.scale == "log"]
        return {key for claim in own for key in (claim.corrected, claim.as_printed) if key}

    def checks(self) -> list[Reference]:
        """All references, those of claims with their study, key and quantity filled in."""
        return [*(filled(claim) for claim in self.claims if claim.reference is not None), *self.references]

    def only_table(self, number: int) -> Paper:
        """The claims of one table, without errata, figures and references.

        Raises `BadInput` for a table without claims.
        """
        kept = tuple(claim for claim in self.claims if table_number(claim.item) == number)
        if not kept:
            known = ", ".join(map(str, self.tables))
            raise BadInput(f"paper {self.paper} has no table {number}", hint=f"it has {known}")
        return dataclasses.replace(self, claims=kept, errata=(), figures=(), references=())


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


def table_number(item: str) -> int | None:
    """5 of "Table 5", 2 of "Table II"; None of what is no table."""
    words = item.lower().split()
    if len(words) < 2 or words[0] != "table":
        return None
    number = words[1].strip(",.:()")
    return int(number) if number.isdigit() else ROMAN.get(number)


def filled(claim: Claim) -> Reference:
    """A claim's reference with what it takes from the claim."""
    reference = claim.reference
    assert reference is not None
    return dataclasses.replace(
        reference,
        id=reference.id or claim.id,
        quantity=reference.quantity or f"{claim.item}: {claim.quantity}",
        unit=reference.unit or claim.unit,
        study=reference.study or claim.study,
        key=reference.key or claim.corrected,
    )


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
