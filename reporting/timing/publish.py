"""The published timings: `python -m helmbench.reporting.timing.publish ROWS FOLDER`, which `make timing` calls."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ...bench.environment import environment
from ...models.errors import BadInput
from ...models.folders import make_folder, write_atomic
from . import study_page
from .page import AXES, drawing, readme
from .rows import read_rows

README, ROWS, STUDY = "README.md", "rows.jsonl", "study.md"


def publish(source: Path, folder: Path, machine: Mapping[str, Any]) -> tuple[Path, ...]:
    """Write README, rows, drawings and the study of very many runs into a folder; the paths.

    Raises
    ------
    BadInput : the file of rows cannot be used.
    """
    rows = sorted(read_rows(source), key=lambda row: row.what)
    texts = {README: readme(rows, machine), ROWS: "".join(json.dumps(asdict(row)) + "\n" for row in rows)}
    for tiny in (row for row in rows if row.run):
        texts[STUDY] = study_page.page(tiny, rows)
    for axis in AXES:
        if own := [row for row in rows if row.axis == axis]:
            texts[f"{axis}.svg"] = drawing(own, axis)
    make_folder(folder)
    for name, text in texts.items():
        write_atomic(folder / name, text.encode())
    return tuple(folder / name for name in texts)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python -m helmbench.reporting.timing.publish ROWS FOLDER")
    try:
        for path in publish(Path(sys.argv[1]), Path(sys.argv[2]), environment()):
            print(f"wrote {path}")
    except BadInput as error:
        print(f"helmbench: {error}", file=sys.stderr)
        sys.exit(2)
