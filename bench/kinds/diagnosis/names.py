"""What the findings of a diagnosis name: causes, and groups of the base model's own numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

from ....diagnosis.result import Finding
from ....models.coefficient_groups import stated_groups
from ....models.model import Model

BASE = "base_coefficients"
"""The cause under which a finding states groups of the base model's numbers in its details."""


class Said(Protocol):
    """What is judged of a diagnosis, or of an answer that no diagnosis of this package gave."""

    @property
    def model(self) -> Model: ...
    @property
    def verdict(self) -> str: ...
    @property
    def causes(self) -> Sequence[Finding]: ...


def named(diagnosis: Said) -> list[frozenset[str]]:
    """One set of interchangeable names for each thing that a diagnosis names, in its order.

    A single number counts as its group.  A finding of the base model's numbers names each of the groups in its details,
    by id or title; further details, "would do as well" or "coefficient", name ties or the number itself.
    """
    known = group_names(diagnosis.model)
    found = [sets for finding in diagnosis.causes for sets in _of_finding(finding, known)]
    return list(dict.fromkeys(found))


def group_names(model: Model) -> dict[str, str]:
    """Number, or title of a group in small letters -> id of the group; empty where the family states no groups."""
    groups = stated_groups(model)
    return {name: g.id for g in groups for name in g.every} | {g.title.lower(): g.id for g in groups}


def _of_finding(finding: Finding, known: Mapping[str, str]) -> list[frozenset[str]]:
    """Sets of interchangeable names of one finding."""
    ties = [*finding.tied_with, *_texts(finding.details.get("would do as well"))]
    ties = [_id(text, known) for text in ties if text != BASE]
    groups = [_id(text, known) for text in _texts(finding.details.get("groups"))]
    if finding.cause == BASE:
        return [frozenset({group, *ties}) for group in groups] or [frozenset({BASE, *ties})]
    number = finding.details.get("coefficient")
    return [frozenset({_id(str(number or finding.cause), known), *ties})]


def _texts(value: object) -> list[str]:
    """A text or a list of texts as a list."""
    if isinstance(value, str):
        return [value]
    return [str(one) for one in value] if isinstance(value, list | tuple) else []


def _id(text: str, known: Mapping[str, str]) -> str:
    """The group of a number or title, or of `group.number`; an id, also with blanks, as it is."""
    return known.get(text, known.get(text.lower(), text.replace(" ", "_").partition(".")[0]))
