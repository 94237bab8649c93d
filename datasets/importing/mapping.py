"""The mapping of a log's columns: a YAML file that is written at the first import and used at the next."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping as Dict
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from ...models.yaml_file import FileContent, checked, read_yaml
from .clock import FORMS, Form
from .draft import NOT_USED, TIME
from .quantities import UNITS, quantities

if TYPE_CHECKING:
    from .draft import DraftColumn, Question

VERSION = 1
PLAIN = re.compile(r"[A-Za-z_](?:[A-Za-z0-9_ /%.]*[A-Za-z0-9_/%])?")
WORDS_OF_YAML = frozenset({"yes", "no", "on", "off", "y", "n", "t", "f", "true", "false", "null"})
HEAD = """\
# How the columns of a log become channels of a record (helmbench import --map).
# to: {quantities}, not used
# unit: {units}
# value = sign * unit * (factor * number) + offset * unit; sign: -1 turns a column round.
# '?' is open: put an answer there.
# Of the whole log: rudder: none (there is none); rows_of: VESSEL (of several in one table); scale: model or ship.
# time, form: {forms}
"""


class ColumnMap(FileContent):
    """One column: its name in the log, the quantity, the unit of its numbers, 1 or -1, and a scale; '?' is open."""

    column: str
    to: str
    unit: str | None = None
    sign: Literal[1, -1, "?"] = 1
    factor: Annotated[float, Field(allow_inf_nan=False)] = 1.0
    offset: Annotated[float, Field(allow_inf_nan=False)] = 0.0

    @model_validator(mode="after")
    def check_quantity(self) -> ColumnMap:
        if self.to in (NOT_USED, "?"):
            return self
        known = quantities()
        if self.to not in known:
            raise ValueError(f"needs one of {', '.join(known)} or {NOT_USED} as 'to', not {self.to}")
        needed = known[self.to].dimension
        if self.unit != "?" and (self.unit not in UNITS or UNITS[self.unit].dimension != needed):
            units = ", ".join(unit.name for unit in UNITS.values() if unit.dimension == needed)
            raise ValueError(f"needs a unit of {self.to}, which are {units}, not {self.unit}")
        return self

    @property
    def open(self) -> bool:
        """Whether something of a column that is used is open."""
        return self.to != NOT_USED and "?" in (self.to, self.unit, self.sign)


PARTS = {"date parts": 6, "clock parts": 3}
"""Forms of a time in a column for every part -> number of columns; one more holds a fraction of the second."""


def _known_form(form: Form) -> Form:
    if form not in (*FORMS, "?"):
        raise ValueError(f"needs one of {', '.join(FORMS)} or ? as form, not {form}")
    return form


class TimeMap(FileContent):
    """The time: its column, or those of its parts, and its form; of rows without a time their step."""

    columns: Annotated[tuple[str, ...], Field(max_length=7)] = ()
    form: Annotated[Form, AfterValidator(_known_form)]
    step_s: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def check_columns(self) -> TimeMap:
        if self.form == "rows" and self.step_s is None:
            raise ValueError("needs step_s, the seconds between the rows, where the form is rows")
        if not self.columns and self.form not in ("rows", "?"):
            raise ValueError("needs the column of the time")
        most, more = PARTS.get(self.form, 2), int(self.form in PARTS)
        if len(self.columns) > most + more or (more and len(self.columns) < most):
            raise ValueError(f"a time of the form {self.form} is in {most} columns")
        return self


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


def uses(table: TableMap) -> bool:
    """Whether a column of a table is used."""
    return any(column.to != NOT_USED for column in table.columns)


class Mapping(FileContent):
    """What an import needs to be told."""

    version: Literal[1] = VERSION
    vessel: str | None = None
    positive_rudder: Literal["port", "starboard"] | None = None
    magnetic_variation_deg: float | None = None
    step_s: Annotated[float, Field(gt=0.0)] | None = None
    rudder: Literal["none"] | None = None
    """'none': no column is the rudder, and it is not asked."""
    rows_of: str | int | None = None
    """The vessel whose rows are used, where a table holds those of several."""
    scale: Literal["model", "ship"] | None = None
    """The scale whose columns are used, where a table holds those of two."""
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
    """The mapping with (table, column) -> `to`, a quantity, 'time' or 'not used', `unit`, of a time its form, `sign`;
    or BadInput."""
    tables: list[dict[str, Any]] = []
    for table in mapping.tables:
        own = {column: entry for (label, column), entry in said.items() if label == table.label}
        time = table.time.model_dump()
        for name in [name for name, entry in own.items() if entry["to"] == TIME][::-1]:
            time = {"columns": (name,), "form": own.pop(name).get("unit") or "?"}
        columns = []
        for column in (c for c in table.columns if c.column not in time["columns"]):
            before, entry = column.model_dump(), own.pop(column.column, None)
            if entry is None:
                columns.append(before)
            elif entry["to"] == NOT_USED:
                columns.append({"column": column.column, "to": NOT_USED})
            else:  # its scale stays where quantity and unit do
                same = entry["to"] == column.to and entry.get("unit") == column.unit
                columns.append((before if same else {"column": column.column}) | dict(entry))
        known = {column.column for column in table.columns}
        columns += [{"column": name, **entry} for name, entry in own.items() if name not in known]
        tables.append(table.model_dump() | {"time": time, "columns": columns})
    return checked(Mapping, mapping.model_dump() | {"tables": tables}, Path("mapping"))


def mapping_text(mapping: Mapping, columns: Sequence[DraftColumn] = ()) -> str:
    """The mapping as YAML, with what may stand in it at its head; `columns` give the reason behind every line."""
    told = {(row.table, row.column): row for row in columns}
    head = HEAD.format(quantities=", ".join(quantities()), units=", ".join(UNITS), forms=", ".join(FORMS))
    content: dict[str, Any] = mapping.model_dump(mode="json", exclude_none=True, exclude={"tables"})
    lines = [f"{key}: {scalar(value)}" for key, value in content.items()]
    if mapping.positive_rudder is None:
        why = "the side to which a positive rudder turns the ship, where nothing tells it"
        lines.append(f"# positive_rudder: port  # {why}")
    for question in dict.fromkeys(q for row in columns for q in row.questions if _of_whole(q)):
        lines += _comments(question)
    lines.append("tables:")
    for table in mapping.tables:
        lines += _table_lines(table, told)
    return head + "\n".join(lines) + "\n"


def _of_whole(question: Question) -> bool:
    """Whether the answers of a question stand above the tables."""
    return question.about != "time" and not any(answer.line.startswith("- ") for answer in question.answers)


def _table_lines(table: TableMap, told: Dict[tuple[str, str], DraftColumn]) -> list[str]:
    time = table.time.model_dump(mode="json", exclude_none=True)
    first = {"file": table.file} | ({"sheet": table.sheet} if table.sheet else {})
    lines = [f"  {'-' if i == 0 else ' '} {key}: {scalar(value)}" for i, (key, value) in enumerate(first.items())]
    listed = ", ".join(str(scalar(name)) for name in time.pop("columns"))
    rest = "".join(f", {key}: {scalar(value)}" for key, value in time.items())
    timed = (told.get((table.label, name)) for name in table.time.columns)
    lines += [f"    {line}" for row in timed if row is not None for line in _comments(*_of_column(row))]
    lines.append(f"    time: {{columns: [{listed}]{rest}}}")
    if table.clock_offset_s is not None:
        lines.append(f"    clock_offset_s: {scalar(table.clock_offset_s)}")
    lines.append("    columns:" + ("" if table.columns else " []"))
    for column in table.columns:
        row = told.get((table.label, column.column))
        lines += [f"      {line}" for line in _comments(*_of_column(row))] if row is not None else []
        why = f"  # {one_line(row.why)}" if row is not None else ""
        unused = {"unit", "sign", "factor", "offset"} if column.to == NOT_USED else None
        entry = column.model_dump(mode="json", exclude_none=True, exclude_defaults=True, exclude=unused)
        lines.append(f"      {flow(entry)}{why}")
    return lines


def _of_column(row: DraftColumn) -> list[Question]:
    """The questions of a column whose answers stand at it."""
    return [question for question in row.questions if not _of_whole(question)]


def _comments(*questions: Question) -> list[str]:
    """Comments with questions, and then with their answers."""
    lines = [f"# ASKED: {one_line(question.text)}" for question in questions]
    answers = [answer for question in questions for answer in question.answers]
    return lines + [f"#   {one_line(answer.text)}: {one_line(answer.line)}" for answer in answers]


def one_line(text: str) -> str:
    """A text that is safe in a comment."""
    return " ".join("".join(letter if letter.isprintable() else " " for letter in text).split())


def flow(entry: Dict[str, object]) -> str:
    """A line of a list in YAML."""
    return "- {" + ", ".join(f"{key}: {scalar(value)}" for key, value in entry.items()) + "}"


def scalar(value: object) -> str:
    """A value in YAML's flow style; texts in quotes where they need them."""
    if isinstance(value, str) and not (PLAIN.fullmatch(value) and value.lower() not in WORDS_OF_YAML):
        return json.dumps(value, ensure_ascii=not value.isprintable())
    return f"{value:.12g}" if isinstance(value, float) else str(value)
