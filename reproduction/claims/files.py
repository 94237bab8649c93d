"""Reads claims files: `NNN.yaml` in this folder; one entry may hold a row of numbers for each line of a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

from pydantic import model_validator

from ...models.errors import BadInput
from ...models.yaml_file import FileContent, checked, read_yaml
from .claim import Claim, Erratum, Figure, Paper, Reference

FOLDER = Path(__file__).parent
ACROSS = "across"
"""The comparison on every vessel: no paper, but computed and shown as one."""
Entry = TypeVar("Entry", bound=FileContent)


def papers() -> tuple[str, ...]:
    """Numbers of the papers with a claims file."""
    return tuple(name for name in everything() if name != ACROSS)


def everything() -> tuple[str, ...]:
    """The papers, and the comparison on every vessel where there is its file."""
    return tuple(path.stem for path in sorted(FOLDER.glob("*.yaml")))


def load(paper: str) -> Paper:
    """The claims of a paper; raises `BadInput` for an unknown one, and for a damaged file."""
    if paper not in everything():
        raise BadInput(f"unknown paper {paper!r}", hint=f"known: {', '.join(everything())}")
    return read(FOLDER / f"{paper}.yaml")


@lru_cache
def published(paper: str) -> Mapping[str, Any]:
    """What a paper prints, by the ids of its claims."""
    return {claim.id: claim.published for claim in load(paper).claims}


def read(path: Path) -> Paper:
    """A claims file; raises `BadInput` naming file and entry."""
    data = read_yaml(path, "a claims file")
    data.pop("texts", None)  # what entries repeat by anchors
    parts = {
        "claims": _entries(Claim, data, "claims", path, "published"),
        "errata": _entries(Erratum, data, "errata", path),
        "figures": _entries(Figure, data, "figures", path),
        "references": _entries(Reference, data, "references", path, "value"),
    }
    return checked(Paper, data | {name: parts[name] for name in parts if name in data}, path)


def _entries(kind: type[Entry], data: dict[str, Any], name: str, path: Path, number: str = "") -> tuple[Entry, ...]:
    """The checked entries of a list in the file; number: the field that the numbers of short forms become."""
    listed = data.get(name) or []
    if not (isinstance(listed, list) and all(isinstance(entry, dict) for entry in listed)):
        raise BadInput(f"{name}: needs a list of entries", file=path)
    single = [each for entry in listed for each in (expanded(entry, number, path) if number else [entry])]
    return tuple(checked(kind, entry, f"{path}, {_name_of(entry)}") for entry in single)


def _name_of(entry: dict[str, Any]) -> Any:
    return next((entry[key] for key in ("id", "equation", "quantity", "key") if entry.get(key)), "an entry")


class ShortForm(FileContent):
    """The short form's own keys.

    rows : {name: [numbers]}, a null where the table has none;  columns : {name: fields} in the order of the numbers.
    """

    rows: dict[Any, tuple[Any, ...]]
    columns: dict[Any, dict[str, Any] | None]

    @model_validator(mode="after")
    def _columns_fit(self) -> ShortForm:
        for row, numbers in self.rows.items():
            if len(numbers) != len(self.columns):
                raise ValueError(f"row {row} has {len(numbers)} numbers for {len(self.columns)} columns")
        return self


def expanded(entry: Mapping[str, Any], number: str, file: object) -> Iterator[dict[str, Any]]:
    """The claims (or references) of an entry: the entry itself, or one for every number of its `rows`.

    The fields of a column are added to those of the entry.  {row} and {column} are replaced in every text, and the
    number becomes the field `number`.

    Raises
    ------
    BadInput : a row has more or fewer numbers than there are columns.
    """
    if "rows" not in entry:
        yield dict(entry)
        return
    shared = {key: value for key, value in entry.items() if key not in ShortForm.model_fields}
    own = {key: value for key, value in entry.items() if key in ShortForm.model_fields}
    table = checked(ShortForm, own, f"{file}, {entry.get('id', 'an entry')}")
    for row, numbers in table.rows.items():
        for (column, fields), value in zip(table.columns.items(), numbers, strict=True):
            if value is not None:
                yield _filled({**shared, **(fields or {}), number: value}, {"row": row, "column": column})


def _filled(value: Any, names: Mapping[str, str]) -> Any:
    if isinstance(value, str):
        for name, text in names.items():
            value = value.replace("{" + name + "}", str(text))
        return value
    if isinstance(value, Mapping):
        return {key: _filled(inner, names) for key, inner in value.items()}
    return value
