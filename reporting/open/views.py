"""The page of a result as plain values for the page of `helmbench open`, which draws the runs itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.columns import in_order
from ...datasets.display import shown_name
from ..page import EquationList, Items, Note, Overlays, Pairs, Section
from ..runs import POSITIONS, RecordRuns, lines_of, tracks_of
from ..tables import Table
from .curves import numbers, stride, times

if TYPE_CHECKING:
    from ..page import Block, Page

LARGEST = 1e6
"""Values that are drawn, in the unit that is shown."""


def view_of(page: Page) -> dict[str, Any]:
    """The verdict, the parts with their blocks, and the runs along every record."""
    return {
        "tone": page.verdict.tone,
        "label": page.verdict.label,
        "sentence": page.verdict.sentence,
        "told": [*page.verdict.told, *page.doubts],
        "parts": [part for part in map(_part, page.parts) if part["blocks"]],
        "traces": [_runs_view(one) for one in page.records()],
    }


def _part(part: Section) -> dict[str, Any]:
    return {
        "title": part.title,
        "folded": part.folded,
        "blocks": [one for block in part.blocks for one in _block(block)],
    }


def _block(block: Block) -> Iterator[dict[str, Any]]:
    """The block as values; nothing of what the page draws itself."""
    if isinstance(block, str | Note):
        yield {"kind": "text", "text": block if isinstance(block, str) else block.text, "note": isinstance(block, Note)}
    elif isinstance(block, Table):
        rows = [[{"text": cell.text, "key": cell.key} for cell in row] for row in block.rows]
        yield {"kind": "table", "title": block.title, "note": block.note, "columns": list(block.columns),
               "numeric": list(block.numeric), "rows": rows}  # fmt: skip
    elif isinstance(block, Items | Pairs):
        yield {"kind": "items", "rows": [list(row) for row in block.rows]}
    elif isinstance(block, EquationList):
        yield {"kind": "equations", "lines": [{"html": line.html, "new": line.new} for line in block.lines()]}
    elif isinstance(block, Overlays) and block.together:
        yield {"kind": "runs"}


def _runs_view(record: RecordRuns) -> dict[str, Any]:
    """Measured channels and runs of a record: curves with errors, and tracks."""
    kept = stride(record.time.size)
    names = [n for n in in_order(record.measured) if any(n in run for run in record.runs.values())]
    panels = [_panel(record, name, kept) for name in names if name not in POSITIONS]
    tracks = [{"label": label, "north": numbers(north[kept]), "east": numbers(east[kept])}
              for label, north, east in tracks_of(record)]  # fmt: skip
    return {"record": record.record, "role": record.role.replace("_", " "), "time": times(record.time[kept]),
            "rudder": numbers(np.degrees(record.rudder[kept])), "panels": panels, "tracks": tracks}  # fmt: skip


def _panel(record: RecordRuns, name: str, kept: np.ndarray) -> dict[str, Any]:
    lines = lines_of(record, name)
    runs = {label: np.where(np.abs(values) < LARGEST, values, np.nan) for label, values in lines.runs.items()}
    curves = [
        {"label": label, "values": numbers(values[kept])}
        for label, values in {"measured": lines.measured, **runs}.items()
    ]
    errors = [{"label": label, "values": numbers((lines.measured - values)[kept])} for label, values in runs.items()]
    return {"channel": name, "label": shown_name(name), "unit": lines.unit, "curves": curves, "residuals": errors}
