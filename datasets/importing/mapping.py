"""The mapping of a log's columns: a YAML file that is written at the first import and used at the next."""

from __future__ import annotations

from collections.abc import Mapping as Dict
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from ...models.yaml_file import FileContent, checked, read_yaml
from .clock import FORMS, Form
from .draft import NOT_USED
from .quantities import QUANTITIES
from .units import UNITS

VERSION = 1
HEAD = """\
# How the columns of a log become channels of a record (helmbench import --map).
# to: {quantities}
# unit: {units}
# sign: -1 turns a column round.  Columns that are not named here are kept aside.
# time, form: {forms}
"""


class ColumnMap(FileContent):
    """One column: its name in the log, the quantity, the unit of its numbers, and 1 or -1."""

    column: str
    to: str
    unit: str
    sign: Literal[1, -1] = 1

    @model_validator(mode="after")
    def check_quantity(self) -> ColumnMap:
        if self.to not in QUANTITIES:
            raise ValueError(f"needs one of {', '.join(QUANTITIES)} as 'to', not {self.to}")
        needed = QUANTITIES[self.to].dimension
        if self.unit not in UNITS or UNITS[self.unit].dimension != needed:
            known = ", ".join(unit.name for unit in UNITS.values() if unit.dimension == needed)
            raise ValueError(f"needs a unit of {self.to}, which are {known}, not {self.unit}")
        return self


class TimeMap(FileContent):
    """The time: its column, or those of date and time of day, and its form."""

    columns: Annotated[tuple[str, ...], Field(min_length=1, max_length=2)]
    form: Form


class TableMap(FileContent):
    """One logger: the file (and sheet) it was first read from, its time, columns, and what its clock is behind by.

    clock_offset_s : is added to the times; null: estimated where loggers share a channel.
    """

    file: str
    sheet: str = ""
    time: TimeMap
    clock_offset_s: float | None = None
    columns: tuple[ColumnMap, ...]

    @property
    def label(self) -> str:
        """File and sheet, as tables of a log are called."""
        return f"{self.file} [{self.sheet}]" if self.sheet else self.file


class Mapping(FileContent):
    """What an import needs to be told."""

    version: Literal[1] = VERSION
    vessel: str | None = None
    positive_rudder: Literal["port", "starboard"] | None = None
    magnetic_variation_deg: float | None = None
    step_s: Annotated[float, Field(gt=0.0)] | None = None
    tables: Annotated[tuple[TableMap, ...], Field(min_length=1)]

    @field_validator("tables")
    @classmethod
    def check_once(cls, tables: tuple[TableMap, ...]) -> tuple[TableMap, ...]:
        for table in tables:
            names = [column.column for column in table.columns]
            twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
            if twice:
                raise ValueError(f"needs every column once, not {twice[0]} twice")
        return tables


def read_mapping(path: Path) -> Mapping:
    """The mapping of a YAML file; BadInput names file and key of whatever is wrong."""
    from ...models.files import read_utf8

    read_utf8(path)
    return checked(Mapping, read_yaml(path, "a mapping of columns"), path)


def with_columns(mapping: Mapping, said: Dict[tuple[str, str], Dict[str, Any]]) -> Mapping:
    """The mapping with (table, column) -> `to`, a quantity or 'not used', `unit`, `sign`; or BadInput."""
    tables: list[dict[str, Any]] = []
    for table in mapping.tables:
        own = {column: entry for (label, column), entry in said.items() if label == table.label}
        kept = [column.model_dump() for column in table.columns if column.column not in own]
        kept += [{"column": column, **entry} for column, entry in own.items() if entry["to"] != NOT_USED]
        tables.append(table.model_dump() | {"columns": kept})
    return checked(Mapping, mapping.model_dump() | {"tables": tables}, Path("mapping"))


def mapping_text(mapping: Mapping) -> str:
    """The mapping as YAML, with what may stand in it at its head."""
    import yaml

    content: dict[str, Any] = mapping.model_dump(mode="json", exclude_none=True)
    head = HEAD.format(quantities=", ".join(QUANTITIES), units=", ".join(UNITS), forms=", ".join(FORMS))
    return head + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=110)
