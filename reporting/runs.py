"""Measured channels of a record with the runs along it: lines in the units that are shown, and their charts."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..datasets.display import continuous, shown_name, shown_unit, time_figure
from ..models.errors import BadInput
from .numbers import DEG, number
from .plots import COLOURS, INK, SOFT, chart

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..diagnosis.result import Trace
    from ..estimation.validation.result import Validation

CHANNELS = ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s")
"""Channels with a chart each, in this order; positions make the track."""
POSITIONS = ("north_m", "east_m")
BASE, EXTENDED = "base model", "extended model"
MEASURED, BEFORE, AFTER = INK, "#c8553d", "#1b6ca8"
RUN_COLOURS = (BEFORE, AFTER, *COLOURS[2:])
DASHES = ("-", (0, (5, 3)), (0, (2, 1)), (0, (6, 2, 1, 2)))
"""Line styles of the runs, the last run first."""
WIDTH = 6.4
SEEN_WIDTH = 4.6
ROW, FOOT, HEAD, BEFORE_AXIS, BEFORE_TICKS = 1.05, 0.45, 0.1, 0.95, 0.6
"""Inches: widths of a figure, of a record in the first figure; a channel, the time axis, what is above and left, and
left of an axis the label's end."""
RIGHT, TICKS, FEW_TICKS = 0.97, 6, 3
"""Right end of the axes as a share of the width; steps of a vertical axis at most, and of a low one."""


@dataclass(frozen=True)
class RecordRuns:
    """A record and the runs along it.

    role : 'train', 'held_out' or empty.  time, rudder : (T,) s and rad.  measured, and each of the runs by its label:
    channel -> (T,), SI, nan where nothing was measured or run.  starts : samples at which runs start anew behind a gap.
    remarks : what else is to be said of the runs.
    """

    record: str
    role: str
    time: np.ndarray
    rudder: np.ndarray
    measured: Mapping[str, np.ndarray]
    runs: Mapping[str, Mapping[str, np.ndarray]]
    starts: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()

    def channels(self) -> list[str]:
        """Channels of `CHANNELS` that were measured and that a run has."""
        return [name for name in CHANNELS if name in self.measured and any(name in run for run in self.runs.values())]


@dataclass(frozen=True)
class Lines:
    """One channel of a record in the unit that is shown: measured (T,), and label -> values and errors (T,) of runs."""

    unit: str
    measured: np.ndarray
    runs: Mapping[str, np.ndarray]
    errors: Mapping[str, np.ndarray]


def of_trace(trace: Trace, extends: bool) -> RecordRuns:
    """A record of a diagnosis or calibration; with the run of the extended model if the model was extended."""
    runs = {BASE: trace.before} | ({EXTENDED: trace.after} if extends else {})
    return RecordRuns(trace.record, trace.role, trace.time, trace.rudder, trace.measured, runs)


def of_validation(validation: Validation, role: str = "") -> list[RecordRuns]:
    """The records of a validation with the runs of all its models, that of the validated one last and so on top."""
    out = []
    for one in validation.records:
        own = [run for run in validation.runs if run.record == one.name]
        starts = {int(s) for run in own for s in np.searchsorted(one.time_s, run.starts_s[1:])}
        remarks = tuple(f"{run.model}: {run.told}" for run in own if run.told)
        runs = {run.model: run.predicted for run in reversed(own)}
        out.append(
            RecordRuns(one.name, role, one.time_s, one.rudder, one.channels, runs, tuple(sorted(starts)), remarks)
        )
    return out


@np.errstate(over="ignore", invalid="ignore")
def lines_of(record: RecordRuns, channel: str) -> Lines:
    """The lines of a channel; a heading begins within half a turn of the measured one."""
    unit, factor = shown_unit(channel)
    measured = factor * continuous(channel, record.measured[channel])
    runs = {label: factor * continuous(channel, run[channel]) for label, run in record.runs.items() if channel in run}
    if channel == "heading_rad":
        runs = {label: values + _turns(measured - values) for label, values in runs.items()}
    return Lines(unit, measured, runs, {label: measured - values for label, values in runs.items()})


def _turns(gap: np.ndarray) -> float:
    """Full turns, deg, between two headings (N,) where both begin."""
    known = gap[np.isfinite(gap)]
    return float(360.0 * np.round(known[0] / 360.0)) if known.size else 0.0


def rms(values: np.ndarray) -> float:
    """Root mean square of what is finite; nan if nothing is."""
    known = values[np.isfinite(values)]
    if not known.size:
        return math.nan
    largest = float(np.abs(known).max()) or 1.0
    return largest * float(np.sqrt(np.mean((known / largest) ** 2)))  # the square of what is huge is not finite


def error_line(record: RecordRuns) -> str:
    """Root mean square errors of a record's runs, in one line."""
    texts = []
    for channel in [c for c in (*CHANNELS, *POSITIONS) if c in record.measured]:
        lines = lines_of(record, channel)
        values = [
            number(rms(_wrapped(error) if channel == "heading_rad" else error)) for error in lines.errors.values()
        ]
        texts += [f"{shown_name(channel)} {' → '.join(values)} {lines.unit}"] if values else []
    return ", ".join(texts)


@np.errstate(invalid="ignore")
def _wrapped(error: np.ndarray) -> np.ndarray:
    """Errors of a heading (N,), deg, within half a turn."""
    return error - 360.0 * np.round(error / 360.0)


# ---- charts


def figure_of(records: Sequence[RecordRuns], name: str | None, what: str) -> Figure:
    """Channels of a record and of the runs along it over time; None: the first held-out record, else the first.

    what : what has the records, for the message.

    Raises
    ------
    BadInput : there is no such record.
    """
    in_order = sorted(records, key=lambda one: one.role == "train")
    record = next((one for one in in_order if name in (None, one.record)), None)
    if record is None:
        hint = f"it has {', '.join(one.record for one in records) or 'none'}"
        raise BadInput(f"the {what} has no such record", file=name, hint=hint)
    every = {"measured": record.measured, **record.runs}
    panels = {
        channel: [
            (label, record.time, continuous(channel, run[channel])) for label, run in every.items() if channel in run
        ]
        for channel in record.measured
    }
    return time_figure(panels, f"free runs along {record.record}")


def key_of(records: Iterable[RecordRuns]) -> list[tuple[str, str, bool]]:
    """Name and colour of every line in the charts, and whether it is dashed."""
    labels = list(dict.fromkeys(label for record in records for label in record.runs))
    runs = [(label, _colour(labels, label), label != labels[-1]) for label in labels]
    return [("measured", MEASURED, False), *runs]


def _colour(labels: Sequence[str], label: str) -> str:
    return RUN_COLOURS[labels.index(label) % len(RUN_COLOURS)]


def _style(record: RecordRuns, label: str) -> dict[str, Any]:
    """Colour, dashes and width of a line, as matplotlib takes them."""
    if label == "measured":
        return {"color": MEASURED, "linewidth": 1.3}
    labels = list(record.runs)
    dashes = DASHES[(len(labels) - 1 - labels.index(label)) % len(DASHES)]
    return {"color": _colour(labels, label), "linestyle": dashes, "linewidth": 1.0}


class Panel(NamedTuple):
    """Curves over time, (N,) each with its style, with label and range of their axis, and how high it is."""

    label: str
    curves: Sequence[tuple[np.ndarray, Mapping[str, Any]]]
    limits: tuple[float, float] | None = None
    rows: float = 1.0


def together(records: Sequence[RecordRuns]) -> list[tuple[str, str]]:
    """Pairs of record and chart: its channels below each other, without errors; each channel to one scale in all."""
    channels = [c for c in CHANNELS if any(c in one.channels() for one in records)]
    lines = [{c: lines_of(one, c) for c in channels if c in one.channels()} for one in records]
    scales = {c: _scale([own[c] for own in lines if c in own]) for c in channels}
    return [
        (one.record, _over_time(one, [_values(one, c, own[c], scales[c]) for c in own], SEEN_WIDTH))
        for one, own in zip(records, lines, strict=True)
        if own
    ]


def _scale(lines: Sequence[Lines]) -> tuple[float, float] | None:
    """Range of a channel over several records; runs are cut off sooner than in its own chart."""
    ranges = [value_range([one.measured, *one.runs.values()], 0.25 * _reach(one)) for one in lines]
    known = [one for one in ranges if one is not None]
    return (min(low for low, _ in known), max(high for _, high in known)) if known else None


def charts_of(record: RecordRuns) -> list[tuple[str, str]]:
    """Pairs of caption and chart: the rudder and every channel above its errors, and the track; without those of which
    nothing is finite."""
    if not record.channels():
        return []
    panels = [Panel("rudder\ndeg", [(DEG * record.rudder, {"color": SOFT, "linewidth": 1.0})])]
    for channel in record.channels():
        lines = lines_of(record, channel)
        reach = _reach(lines)
        limits = value_range([lines.measured, *lines.runs.values()], reach)
        if limits is not None:
            errors = [(values, _style(record, label)) for label, values in lines.errors.items()]
            panels.append(_values(record, channel, lines, limits, 2.0))
            panels.append(Panel("error", errors, value_range([np.zeros(1), *lines.errors.values()], reach)))
    caption = "rudder, and each channel above its errors: measured − simulated"
    found = [(caption, _over_time(record, panels, WIDTH)), ("track", track_chart(record))]
    return [(caption, drawn) for caption, drawn in found if drawn]


def _values(
    record: RecordRuns, channel: str, lines: Lines, limits: tuple[float, float] | None, rows: float = 1.0
) -> Panel:
    """The measured values of a channel, and the runs."""
    every = {"measured": lines.measured, **lines.runs}
    curves = [(values, _style(record, label)) for label, values in every.items()]
    return Panel(f"{shown_name(channel)}\n{lines.unit}", curves, limits, rows)


def _over_time(record: RecordRuns, panels: Sequence[Panel], width: float) -> str:
    """A chart of panels below each other, with a gap before each new start.

    Its margins and the places of its labels are fixed: a page has dozens of such charts, and fitting them is slow.
    """
    starts = list(record.starts)
    time = np.insert(record.time, starts, record.time[starts])
    height = HEAD + FOOT + ROW * sum(panel.rows for panel in panels)

    def draw(figure) -> None:
        rows = [panel.rows for panel in panels]
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False, height_ratios=rows)[:, 0]
        for own, panel in zip(axes, panels, strict=True):
            for values, style in panel.curves:
                own.plot(time, np.insert(values, starts, np.nan), **style)
            own.set(xlim=(time[0], time[-1]), ylabel=panel.label, ylim=panel.limits)
            own.yaxis.set_label_coords(-BEFORE_TICKS / (RIGHT * width - BEFORE_AXIS), 0.5)
            own.yaxis.get_major_locator().set_params(nbins=TICKS if panel.rows > 1.0 else FEW_TICKS)
            if panel.label == "error":
                own.axhline(0.0, color=SOFT, linewidth=0.7)
        axes[-1].set_xlabel("time, s")

    margins = _margins(width, height) | {"hspace": 0.15}
    return chart(draw, (width, height), f"{record.record}: measured and simulated", margins)


def _reach(lines: Lines) -> float:
    """How far a run may leave the measured values before it is cut off: twice their range, and a velocity at least half
    of itself; infinite where nothing varies."""
    known = lines.measured[np.isfinite(lines.measured)]
    spread = float(np.ptp(known)) if known.size else 0.0
    if spread == 0.0:
        return math.inf
    return max(2.0 * spread, 0.5 * float(np.abs(known).max()) if lines.unit == "m/s" else 0.0)


def tracks_of(record: RecordRuns) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Label, north and east (T,), m, of the measured track and of those of the runs; empty where none was measured."""
    if not set(POSITIONS) <= record.measured.keys():
        return []
    every = {"measured": record.measured, **record.runs}
    north, east = POSITIONS
    return [(label, run[north], run[east]) for label, run in every.items() if {north, east} <= run.keys()]


def track_chart(record: RecordRuns) -> str:
    """The tracks to equal scales, north up; empty where nothing is finite."""
    known = [track for track in tracks_of(record) if np.isfinite(track[1] + track[2]).any()]
    if not known:
        return ""

    def draw(figure) -> None:
        axes = figure.subplots()
        for label, north, east in known:
            drawn = _within(east, [e for _, _, e in known]), _within(north, [n for _, n, _ in known])
            axes.plot(*drawn, **_style(record, label))
        _, north, east = known[0]
        first = int(np.argmax(np.isfinite(north + east)))
        axes.plot(east[first], north[first], "o", color=MEASURED, markersize=4)
        axes.set(xlabel="east, m", ylabel="north, m", aspect="equal", adjustable="datalim")

    return chart(draw, (WIDTH, WIDTH), "track", _margins(WIDTH, WIDTH))


def _margins(width: float, height: float) -> dict[str, float]:
    """Margins of a figure of so many inches."""
    return {"left": BEFORE_AXIS / width, "bottom": FOOT / height, "top": 1.0 - HEAD / height, "right": RIGHT}


def value_range(arrays: Sequence[np.ndarray], limit: float | None = None) -> tuple[float, float] | None:
    """Padded range of what is finite, at most `limit` (None: twice its range) beyond the first array; None where
    nothing is."""
    known = [a[np.isfinite(a)] for a in arrays]
    if not any(a.size for a in known):
        return None
    values, first = np.concatenate(known), known[0]
    if first.size:
        reach = 2.0 * float(np.ptp(first)) or math.inf if limit is None else limit
        values = np.clip(values, first.min() - reach, first.max() + reach)
    low, high = float(values.min()), float(values.max())
    pad = 0.06 * (high - low) or max(abs(low), 1.0) * 0.1
    return low - pad, high + pad


def _within(values: np.ndarray, arrays: Sequence[np.ndarray]) -> np.ndarray:
    """The values with nan where they lie outside the range of what is drawn."""
    low, high = value_range(arrays) or (-math.inf, math.inf)
    return np.where((values >= low) & (values <= high), values, np.nan)
