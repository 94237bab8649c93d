"""Claims of a paper, its errata, its figures, and independent references."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...models.errors import BadInput

ROMAN = {"i": 1, "ii": 2, "iii": 3, "iv": 4, "v": 5, "vi": 6, "vii": 7, "viii": 8, "ix": 9, "x": 10}


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
        not determine at all.
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
