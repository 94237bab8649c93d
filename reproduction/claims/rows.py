"""Short form for tables: one entry of a claims file with a row of numbers for each line of the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import model_validator

from ...models.yaml_file import FileContent, checked


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
