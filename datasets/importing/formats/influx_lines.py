"""InfluxDB's line protocol: a measurement with tags, its fields, and the nanoseconds since 1970, a line."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ....models.number_texts import DECIMAL
from ..raw import RawTable
from .object_tables import tables_or_refusal

LINE = re.compile(r"(?P<series>[^\s=]{1,200}(?:,[^\s,=]+=[^\s,=]+)*) (?P<fields>[^\s=,]+=\S.*) (?P<time>\d{10,19})\s*$")
FIELD = re.compile(rf"(?P<name>[^\s=,]+)=(?:(?P<number>{DECIMAL})[iu]?|\"[^\"]*\"|[a-zA-Z]+)(?:,|$)")


def looks_like_line_protocol(text: str) -> bool:
    """Whether the first lines are of the line protocol."""
    lines = [line for line in text[:20000].splitlines()[:50] if line.strip() and not line.startswith("#")][:-1]
    return len(lines) > 2 and all(len(line) < 5000 and LINE.match(line) for line in lines)


def read_line_protocol(text: str, path: Path) -> list[RawTable]:
    """A table for every measurement and set of tags; BadInput where no field holds numbers."""
    return tables_or_refusal(list(_rows(text)), path, "measurement")


def _rows(text: str) -> Iterator[tuple[int, dict[str, Any]]]:
    for number, line in enumerate(text.splitlines(), start=1):
        match = LINE.match(line) if len(line) < 5000 else None
        if match is not None:
            fields = {f["name"]: float(f["number"]) for f in FIELD.finditer(match["fields"]) if f["number"]}
            measurement, _, tags = match["series"].partition(",")
            yield number, {"measurement": f"{tags}/{measurement}".strip("/"), "time": int(match["time"])} | fields
