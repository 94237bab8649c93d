"""What the page of `helmbench open` draws: the page of a result as plain values, records, and curves with no more
points than a screen can show, in the units that it shows."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.columns import in_order
from ...datasets.display import continuous, shown_name, shown_unit
from ...datasets.geometry import over_ground, position_over_ground, unwrapped
from ...datasets.signals import integral
from ..page import EquationList, Items, Note, Overlays, Section
from ..runs import POSITIONS, RecordRuns, lines_of, tracks_of
from ..tables import Table

if TYPE_CHECKING:
    from ...datasets.record import Record
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
    elif isinstance(block, Items):
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


# ---- Curves and records.

POINTS = 4000
"""Points of a curve at most."""


def numbers(values: np.ndarray) -> list[float | None]:
    """Each value (N,) with six digits of what it differs from the others by; None where it is not finite."""
    finite = np.isfinite(values)
    known = values[finite]
    spread = float(np.ptp(known)) if known.size else 0.0
    size = float(np.abs(known).max()) / spread if spread > 0.0 else 1.0
    digits = min(6 + max(int(np.ceil(np.log10(size))), 0), 17) if np.isfinite(size) and size > 0.0 else 6
    return [float(f"{v:.{digits}g}") if ok else None for v, ok in zip(values, finite, strict=True)]


def times(values: np.ndarray) -> list[float]:
    """Times to the millisecond."""
    return np.round(values, 3).tolist()


def envelope(values: np.ndarray, limit: int = POINTS) -> np.ndarray:
    """Indices of at most `limit` samples of (N,): the smallest and the largest of equal stretches, in their order."""
    if values.size <= limit:
        return np.arange(values.size)
    edges = np.linspace(0, values.size, limit // 2 + 1).astype(int)
    found = []
    for first, stop in pairwise(edges):
        part = values[first:stop]
        known = np.flatnonzero(np.isfinite(part))
        ends = known[[part[known].argmin(), part[known].argmax()]] if known.size else np.zeros(2, dtype=int)
        found.append(first + np.sort(ends))
    return np.unique(np.concatenate(found))


def stride(size: int, limit: int = POINTS) -> np.ndarray:
    """Indices of every so many-th of `size` samples, at most `limit`."""
    return np.arange(0, size, -(-size // limit) or 1)


def record_view(record: Record) -> dict[str, Any]:
    """A record for the page: every channel over time, the rudder first, and its tracks."""
    names = in_order(record.channels)
    return {"name": record.name, "curves": [_channel(record, name) for name in names], "tracks": tracks(record),
            "headings": headings(record)}  # fmt: skip


def _channel(record: Record, name: str) -> dict[str, Any]:
    unit, factor = shown_unit(name)
    values = factor * continuous(name, record.column(name))
    kept = envelope(values)
    return {"channel": name, "label": shown_name(name), "unit": unit, "time": times(record.time_s[kept]),
            "values": numbers(values[kept])}  # fmt: skip


# ---- channels against each other: a mirrored channel, or one in another unit, leaves the others


def tracks(record: Record) -> list[dict[str, Any]]:
    """North and east, m: of the positions, and of speed and heading added up; the latter two with the heading that the
    yaw rate gives."""
    found = {}
    if record.has("north_m", "east_m"):
        found["positions"] = position_over_ground(record)
    if record.has("surge_m_s", "heading_rad"):
        found["speed and heading"] = _sailed(record, _filled(record.heading_unwrapped()))
    if record.has("surge_m_s", "yaw_rate_rad_s"):
        found["speed and yaw rate"] = _sailed(record, _integrated(record))
    start = _first(next(iter(found.values()))) if found else 0.0
    kept = stride(record.n)
    moved = {label: (place - _first(place) + start)[kept] for label, place in found.items()}
    time = times(record.time_s[kept])
    return [{"label": label, "time": time, "north": numbers(place.real), "east": numbers(place.imag)}
            for label, place in moved.items()]  # fmt: skip


def headings(record: Record) -> dict[str, Any] | None:
    """The heading as it was recorded and as the yaw rate gives it, deg; None where one of them is not recorded."""
    if not record.has("heading_rad", "yaw_rate_rad_s"):
        return None
    kept = stride(record.n)
    runs = np.degrees(record.heading_unwrapped()), np.degrees(_integrated(record))
    return {"time": times(record.time_s[kept]), "heading": numbers(runs[0][kept]), "yaw_rate": numbers(runs[1][kept])}


def _first(place: np.ndarray) -> complex:
    known = np.flatnonzero(np.isfinite(place))
    return complex(place[known[0]]) if known.size else 0.0


def _filled(values: np.ndarray) -> np.ndarray:
    """Values (N,) with gaps bridged; zero where nothing is known."""
    known = np.isfinite(values)
    return np.interp(np.arange(values.size), np.flatnonzero(known), values[known]) if known.any() else 0.0 * known


def _integrated(record: Record) -> np.ndarray:
    """Heading (N,) by the yaw rate, rad, from the first one that was recorded."""
    turned = integral(_filled(record.column("yaw_rate_rad_s")), record.time_s)
    start = unwrapped(record.column("heading_rad")) if record.has("heading_rad") else turned
    known = np.flatnonzero(np.isfinite(start))
    return turned + (start[known[0]] - turned[known[0]] if known.size else 0.0)


def _sailed(record: Record, heading: np.ndarray) -> np.ndarray:
    """Place north + i east (N,), m, by speeds in body axes along a heading (N,), rad."""
    sway = _filled(record.column("sway_m_s")) if record.has("sway_m_s") else np.zeros(record.n)
    return integral(over_ground(_filled(record.column("surge_m_s")), sway, heading), record.time_s)
