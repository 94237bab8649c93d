"""The page of a diagnosis as Markdown with figures, for publishing: it carries no series, measured or simulated, only
statistics of the errors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..traces import AFTER, BEFORE, Curve, bars, spectra
from . import text as words
from .page import CHANNELS, facts, instrument_rows, residual, rms, where_row

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Trace

BANDS = 14
"""Frequency bands, equally wide on a logarithmic axis, into which a spectrum of errors is averaged."""
CORRELATED = (1.0, 10.0)
"""Lags in s at which the correlation of the errors with themselves is told."""


def write_markdown(found: Diagnosis, folder: str | Path, name: str, title: str, note: str = "") -> tuple[Path, ...]:
    """Write `name`.md and its figures `name`-*.svg into a folder, all of them or none; the paths."""
    from ...datasets.files import replace_together

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    drawn = figures(found)
    texts = {f"{name}.md": markdown(found, title, note, {key: f"{name}-{key}.svg" for key in drawn})}
    texts |= {f"{name}-{key}.svg": svg + "\n" for key, svg in drawn.items()}
    paths = {folder / file: text for file, text in texts.items()}
    replace_together({path: _writer(text) for path, text in paths.items()})
    for stale in set(folder.glob(f"{name}-*.svg")) - set(paths):
        stale.unlink()
    return tuple(paths)


def _writer(text: str) -> Any:
    return lambda place: place.write_text(text, "utf-8")


def markdown(found: Diagnosis, title: str, note: str, files: dict[str, str]) -> str:
    """The Markdown text; `files` says under which name each of `figures` lies."""
    parts = [f"# {title}", note, f"**{found.verdict.capitalize()}.** {words.verdict(found)}", found.reason]
    parts += [_finding(finding) for finding in found.causes]
    parts += ["## 1. What the simulation said against what was measured", STATISTICS, error_table(found)]
    parts += [_figure(files, "errors", "Root mean square errors of the free runs"), *_where(found)]
    parts += ["## 3. The causes that were considered", bank_table(found)]
    parts += ["## 4. The extended model", *_equations(found)]
    parts += ["## 5. Before and after, on records that took no part", *_gain(found)]
    parts += [
        _figure(files, f"spectrum-{name}", f"Spectrum of the {words.channel(name)[0]} errors") for name in CHANNELS
    ]
    parts += ["## Made with", "\n".join(f"- {name}: {value}" for name, value in facts(found) if name != "time")]
    return "\n\n".join(part for part in parts if part) + "\n"


STATISTICS = (
    "Statistics of the free-run errors (measured minus simulated) record by record; the series themselves are not "
    "published here. Correlation: of the error with itself some seconds later (0 for sensor noise)."
)


def _finding(finding: Any) -> str:
    lines = [f"- **{words.tie(finding)}** ({finding.stage}, adjusted p {words.p_value(finding.p_adjusted)})"]
    lines += [f"  - {words.size(item)} ({100 * finding.level:.0f} % interval)" for item in finding.sizes]
    lines += [f"  - {finding.evidence}"] if finding.evidence else []
    if finding.tied_with and finding.separate_by:
        lines.append(f"  - to tell them apart: {finding.separate_by}")
    return "\n".join(lines)


def error_table(found: Diagnosis) -> str:
    """RMS, mean and correlation of the errors of every record and channel, before and after."""
    lags = [f"correlation {lag:g} s" for lag in CORRELATED]
    head = ("record", "role", "channel", "run", "RMS", "mean", *lags)
    rows = []
    for trace in found.traces:
        for name in [c for c in CHANNELS if c in trace.measured]:
            word, unit, factor = words.channel(name)
            for run in ("before", "after")[: 1 + bool(found.causes)]:
                error = residual(trace, name, run)
                size, mean = (words.number(factor * value) for value in (rms(error), _mean(error)))
                told = [words.number(correlation(trace.time, error, lag), 2) for lag in CORRELATED]
                rows.append((trace.record, trace.role.replace("_", " "), word, run, f"{size} {unit}", mean, *told))
    return _table([head, *rows]) if rows else ""


def _mean(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if known.size else float("nan")


def correlation(time: np.ndarray, error: np.ndarray, lag_s: float) -> float:
    """Correlation of an error (T,) with itself `lag_s` seconds later; nan for records that are too short."""
    lag = max(1, round(lag_s / float(np.median(np.diff(time)))))
    if lag >= error.size // 2:
        return float("nan")
    early, late = error[:-lag], error[lag:]
    known = np.isfinite(early) & np.isfinite(late)
    if known.sum() < 10 or min(np.std(early[known]), np.std(late[known])) == 0.0:
        return float("nan")
    return float(np.corrcoef(early[known], late[known])[0, 1])


def _where(found: Diagnosis) -> list[str]:
    rows = [where_row(entry) for entry in found.where]
    table = _table([("condition", "share"), *((row["condition"], row["shares"]) for row in rows)]) if rows else ""
    return ["## 2. Where it goes wrong", table or "Nowhere in particular."]


def bank_table(found: Diagnosis) -> str:
    """Every cause with its status, evidence and power."""
    head = ("cause", "status", "adjusted p", "statistic", "power", "why")
    rows = [
        (
            words.cause(entry.cause),
            entry.status.replace("_", " "),
            words.p_value(entry.p_adjusted),
            words.number(entry.statistic),
            words.NOTHING if entry.power is None else f"{100.0 * entry.power:.0f} %",
            entry.why,
        )
        for entry in words.ordered_bank(found)
    ]
    return _table([head, *rows])


def _equations(found: Diagnosis) -> list[str]:
    from ..equations import equations

    if not found.causes:
        return ["The model stays as it is."]
    told = equations(found.extended, found.model)
    blocks = [f"$$\n{line.latex}\n$$" for line in (*told.relations, *told.dynamics) if line.new]
    values = [f"- ${symbol}$ ({name}): {words.number(value, 4)} {'' if unit == '1' else unit}".rstrip()
              for _, symbol, name, value, unit in told.added]  # fmt: skip
    values += [f"- {name}: {value}" for name, value in instrument_rows(found)]
    return ["Equations that are new or changed:", *blocks, "\n".join(values)]


def _gain(found: Diagnosis) -> list[str]:
    if not found.gain:
        return ["No gain was measured."]
    return [_table([words.GAIN_COLUMNS, *words.gain_rows(found)])]


# ---- figures


def figures(found: Diagnosis) -> dict[str, str]:
    """Name -> SVG: errors by record, and a spectrum of the errors for each channel."""
    drawn = {"errors": error_bars(found)}
    drawn |= {f"spectrum-{name}": spectrum_figure(found, name) for name in CHANNELS}
    return {name: svg for name, svg in drawn.items() if svg}


def error_bars(found: Diagnosis) -> str:
    """RMS error of the yaw rate (or of what there is) by record, before and after."""
    name = next((c for c in CHANNELS if any(c in trace.measured for trace in found.traces)), None)
    if name is None:
        return ""
    word, unit, factor = words.channel(name)
    runs = ("before", "after")[: 1 + bool(found.causes)]
    groups = {
        f"{trace.record} ({trace.role.replace('_', ' ')})": {
            run: factor * rms(residual(trace, name, run)) for run in runs
        }
        for trace in found.traces
        if name in trace.measured
    }
    return bars(groups, {"before": BEFORE, "after": AFTER}, f"{word} error, {unit}", f"{word} error by record")


def spectrum_figure(found: Diagnosis, name: str) -> str:
    """Amplitude spectrum of a channel's errors on the held-out records (or all), before and after, in bands."""
    traces = [t for t in found.traces if name in t.measured]
    traces = [t for t in traces if t.role != "train"] or traces
    if not traces:
        return ""
    word, unit, factor = words.channel(name)
    edges = _bands(traces)
    if edges is None:
        return ""
    curves = []
    for run, colour in (("before", BEFORE), ("after", AFTER))[: 1 + bool(found.causes)]:
        levels = [banded(t.time, residual(t, name, run), edges) for t in traces]
        known = np.nanmean(np.stack(levels), axis=0)
        curves.append(Curve(run, factor * np.sqrt(known), colour, width=1.8))
    return spectra(np.sqrt(edges[:-1] * edges[1:]), curves, f"{unit}/√Hz", f"spectrum of the {word} errors")


def _bands(traces: Sequence[Trace]) -> np.ndarray | None:
    longest = max(float(t.time[-1] - t.time[0]) for t in traces)
    step = max(float(np.median(np.diff(t.time))) for t in traces)
    low, high = 4.0 / longest, 0.5 / step
    return np.geomspace(low, high, BANDS + 1) if high > 2.0 * low else None


def banded(time: np.ndarray, error: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Power spectral density (bands,) of an error (T,), averaged in frequency bands; nan where a band is empty."""
    from scipy.signal import periodogram

    known = np.isfinite(error)
    empty = np.full(edges.size - 1, np.nan)
    if known.sum() < 32:
        return empty
    step = float(np.median(np.diff(time)))
    grid = np.arange(time[known][0], time[known][-1], step)
    frequency, density = periodogram(np.interp(grid, time[known], error[known]), 1.0 / step, "hann", detrend="constant")
    place = np.digitize(frequency, edges) - 1
    return np.array([density[place == k].mean() if (place == k).any() else np.nan for k in range(edges.size - 1)])


def _figure(files: dict[str, str], name: str, caption: str) -> str:
    after = "red: before, blue: after"
    return f"![{caption}]({files[name]})\n\n*{caption}; {after}.*" if name in files else ""


def _table(rows: Sequence[Sequence[str]]) -> str:
    cells = [[str(text).replace("|", "\\|").replace("\n", " ") for text in row] for row in rows]
    head, *body = ("| " + " | ".join(row) + " |" for row in cells)
    return "\n".join([head, "|" + "---|" * len(rows[0]), *body])
