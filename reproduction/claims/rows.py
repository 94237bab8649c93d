"""Short form for tables: one entry of a claims file with a row of numbers for each line of the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def expanded(entry: Mapping[str, Any], number: str = "published") -> Iterator[dict[str, Any]]:
    """The claims (or references) of an entry: the entry itself, or one for every number of its `rows`.

    rows : {name: [numbers]}, a null where the table has none;  columns : {name: fields} in the order of the numbers,
    whose fields are added to those of the entry.  {row} and {column} are replaced in every text, and
    the number becomes the field `number`.

    Raises
    ------
    ValueError : a row has more or fewer numbers than there are columns.
    """
    if "rows" not in entry:
        yield dict(entry)
        return
    shared = {key: value for key, value in entry.items() if key not in ("rows", "columns")}
    for row, numbers in entry["rows"].items():
        if len(numbers) != len(entry["columns"]):
            raise ValueError(f"row {row} has {len(numbers)} numbers for {len(entry['columns'])} columns")
        for (column, own), value in zip(entry["columns"].items(), numbers, strict=True):
            if value is not None:
                yield _filled({**shared, **(own or {}), number: value}, {"row": row, "column": column})


def _filled(value: Any, names: Mapping[str, str]) -> Any:
    if isinstance(value, str):
        for name, text in names.items():
            value = value.replace("{" + name + "}", str(text))
        return value
    if isinstance(value, Mapping):
        return {key: _filled(inner, names) for key, inner in value.items()}
    return value
