"""The page of a validation: free-run errors, errors ahead, manoeuvring indices, and overlays of every record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.display import shown_name, shown_unit
from ..diagnosis.charts import MEASURED, Curve, channel_chart, rudder_chart, track_chart
from ..numbers import DEG
from ..plots import COLOURS
from ..templating import render
from .tables import free_table, horizon_table, index_table, left_out_table, record_table, trusted_lines
from .text import count

if TYPE_CHECKING:
    from ...estimation.validation.result import Measured, Run, Validation

ORDER = ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s")
"""Channels with a chart each; positions make the track."""
POSITIONS = ("north_m", "east_m")
STYLES = ("-", (0, (5, 2)), (0, (2, 1)), (0, (6, 2, 1, 2)))
"""Line styles of the models in turn."""


@dataclass(frozen=True)
class Panel:
    """One record: its name, remarks on its runs, pairs of caption and SVG."""

    record: str
    remarks: tuple[str, ...]
    charts: tuple[tuple[str, str], ...]


def html(found: Validation) -> str:
    """The page, self-contained."""
    return render(
        "validation.html.j2",
        found=found,
        records=count(found),
        free=free_table(found),
        horizons=horizon_table(found),
        trusted=trusted_lines(found),
        by_record=record_table(found),
        indices=index_table(found),
        left_out=left_out_table(found),
        remarks=[f"{run.model} along {run.record}: {run.told}" for run in found.runs if run.told],
        panels=panels(found),
        key=key_of(found),
    )


def panels(found: Validation) -> list[Panel]:
    """The charts of every record."""
    return [_panel(found, record) for record in found.records]


def key_of(found: Validation) -> list[tuple[str, str]]:
    """Name and colour of every line in the charts."""
    return [("measured", MEASURED), *((name, _colour(found, name)) for name in found.models)]


def _panel(found: Validation, record: Measured) -> Panel:
    runs = [run for run in found.runs if run.record == record.name]
    charts = [("rudder", rudder_chart(record.time_s, DEG * record.rudder))]
    charts += [(f"{shown_name(c)}; below, measured − simulated", _chart(found, record, runs, c))
               for c in ORDER if any(c in run.predicted for run in runs)]  # fmt: skip
    charts.append(("track", _track(found, record, runs)))
    remarks = tuple(f"{run.model}: {run.told}" for run in runs if run.told)
    return Panel(record.name, remarks, tuple((caption, svg) for caption, svg in charts if svg))


def _chart(found: Validation, record: Measured, runs: list[Run], channel: str) -> str:
    unit, factor = shown_unit(channel)
    starts = np.unique([s for run in runs for s in np.searchsorted(record.time_s, run.starts_s[1:])]).astype(int)
    measured, errors = factor * record.channels[channel], []
    overlay = [Curve("measured", _broken(measured, starts), MEASURED, width=1.3)]
    for run in (run for run in runs if channel in run.predicted):
        values = factor * run.predicted[channel]
        overlay.append(_curve(found, run, _broken(values, starts)))
        errors.append(_curve(found, run, _broken(measured - values, starts)))
    time = np.insert(record.time_s, starts, record.time_s[starts])
    return channel_chart(time, overlay, errors, shown_name(channel), unit, _reach(measured, unit))


def _reach(measured: np.ndarray, unit: str) -> float:
    """How far a run may leave the measured values (N,) before it is cut off: twice their range, and a velocity at least
    half of itself."""
    known = measured[np.isfinite(measured)]
    return max(2.0 * float(np.ptp(known)), 0.5 * float(np.abs(known).max()) if unit == "m/s" else 0.0)


def _track(found: Validation, record: Measured, runs: list[Run]) -> str:
    if not set(POSITIONS) <= set(record.channels):
        return ""
    north, east = POSITIONS
    none = np.zeros(0)
    curves = [(record.channels[north], record.channels[east], Curve("measured", none, MEASURED, width=1.4))]
    curves += [
        (run.predicted[north], run.predicted[east], _curve(found, run, none))
        for run in runs
        if set(POSITIONS) <= set(run.predicted)
    ]
    return track_chart(curves, "track")


def _curve(found: Validation, run: Run, values: np.ndarray) -> Curve:
    return Curve(run.model, values, _colour(found, run.model), STYLES[_number(found, run.model) % len(STYLES)])


def _colour(found: Validation, model: str) -> str:
    places = (1, 0, *range(2, len(COLOURS)))
    return COLOURS[places[_number(found, model) % len(COLOURS)]]


def _number(found: Validation, model: str) -> int:
    return list(found.models).index(model)


def _broken(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Values (N,) with a gap before each of some samples, so that no line is drawn across."""
    return np.insert(values, starts, np.nan)
