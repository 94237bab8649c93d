"""The page of a diagnosis, as an argument: measured against simulated, where it goes wrong, the bank, the extended
model's equations, before and after on held-out records."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..traces import AFTER, BEFORE, MEASURED, SOFT, Curve, series, track
from . import text as words

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, Entry, Trace

CHANNELS = ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s")
LONGEST_BAR = 16.0
"""-log10 p at which the evidence bar is full."""


@dataclass(frozen=True)
class Panel:
    """One record's charts: (caption, SVG) pairs."""

    record: str
    role: str
    charts: tuple[tuple[str, Any], ...]
    errors: str


def html(found: Diagnosis) -> str:
    """The page, self-contained."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    from ..equations import equations

    loader = FileSystemLoader(Path(__file__).parents[1] / "templates")
    page = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    page.filters["safe_math"] = Markup
    extended = found.extended is not found.model and bool(found.causes)
    return page.get_template("diagnosis.html.j2").render(
        found=found,
        words=words,
        verdict=words.verdict(found),
        panels=[_panel(trace, after=False) for trace in _shown_first(found)],
        held_out=[_panel(trace, after=extended) for trace in found.traces if trace.role != "train"],
        where=[where_row(entry) for entry in found.where],
        bank=[_bank_row(entry, found) for entry in words.ordered_bank(found)],
        alpha_mark=bar_width(found.alpha),
        equations=equations(found.extended, found.model) if extended else None,
        instruments=instrument_rows(found) if extended else [],
        gain=words.gain_rows(found),
        facts=facts(found),
        colours={"measured": MEASURED, "before": BEFORE, "after": AFTER},
    )


def _shown_first(found: Diagnosis) -> list[Trace]:
    """The traces that show what is wrong: those of training, or else all."""
    return [trace for trace in found.traces if trace.role == "train"] or list(found.traces)


def facts(found: Diagnosis) -> list[tuple[str, str]]:
    """What the diagnosis was made with, as pairs of texts."""
    given = {True: "the model file's, known", False: "identified with the causes"}
    files = {role: [name for name, own in found.records if own == role] for role in ("train", "held_out")}
    rows = [
        ("model", f"{found.model.id} ({found.model.family})"),
        ("base parameters", given[found.base_parameters == "file"]),
        ("training records", ", ".join(files["train"])),
        ("held-out records", ", ".join(files["held_out"]) or "none: the gain was not measured"),
        ("family-wise level", f"{found.alpha:g}"),
        ("seed", str(found.seed)),
        ("time", f"{found.wall_s:.1f} s ({found.cpu_s:.1f} s of processor)"),
    ]
    return [*rows, *noise_rows(found)]


def noise_rows(found: Diagnosis) -> list[tuple[str, str]]:
    """The estimated noise model, as pairs of texts."""
    noise, rows = found.noise, []
    sd = [_with_unit(name, value) for name, value in noise.get("sensor_sd", {}).items()]
    if "rudder_sd" in noise:
        sd.append(f"rudder {words.number(words.DEG * noise['rudder_sd'])} deg")
    if sd:
        rows.append(("sensor noise (sd)", ", ".join(sd)))
    forces = noise.get("force_sd", [])
    if len(forces):
        names = (("X", "N"), ("Y", "N"), ("N", "N m")) if len(forces) == 3 else [("yaw", "")] * len(forces)
        told = [
            f"{name} {words.number(value)} {unit}".rstrip() for (name, unit), value in zip(names, forces, strict=True)
        ]
        time = f", correlation time {words.number(noise.get('correlation_time_s'))} s" if max(forces) > 0.0 else ""
        rows.append(("gusts (sd)", ", ".join(told) + time if max(forces) > 0.0 else "none"))
    return rows


def _with_unit(name: str, value: float) -> str:
    word, unit, factor = words.channel(name)
    return f"{word} {words.number(factor * float(value))} {unit}".rstrip()


# ---- charts


def _panel(trace: Trace, after: bool) -> Panel:
    from markupsafe import Markup

    charts = [(caption, Markup(svg)) for caption, svg in _charts(trace, after) if svg]
    return Panel(trace.record, trace.role, tuple(charts), error_line(trace, after))


def _charts(trace: Trace, after: bool) -> list[tuple[str, str]]:
    """A chart a channel, overlay above residual; the first stands under the rudder; the track last."""
    charts = []
    for name in [c for c in CHANNELS if c in trace.measured]:
        word, unit, factor = words.channel(name)
        overlay = series(trace.time, _overlay(trace, name, factor, after), word)
        curves, limit = _residuals(trace, name, factor, after), 2.0 * factor * _extent(trace.measured[name])
        residual = series(trace.time, curves, f"{word} error", 110, zero=True, limit=limit)
        charts.append((f"{word} ({unit}), and measured − simulated", overlay + residual))
    if not charts:
        return []
    rudder = series(trace.time, [Curve("rudder", words.DEG * trace.rudder, SOFT)], "rudder", 90)
    return [("rudder (deg)", rudder), *charts, ("track (m)", track(_tracks(trace, after), "track"))]


def _overlay(trace: Trace, name: str, factor: float, after: bool) -> list[Curve]:
    measured = Curve("measured", factor * _unwrapped(name, trace.measured[name]), MEASURED, width=1.6)
    shift = _turns(name, trace) * factor
    curves = [measured, Curve("before", factor * trace.before[name] + shift, BEFORE, "5 3")]
    return [*curves, Curve("after", factor * trace.after[name] + shift, AFTER)] if after else curves


def _residuals(trace: Trace, name: str, factor: float, after: bool) -> list[Curve]:
    curves = [Curve("before", factor * residual(trace, name, "before"), BEFORE)]
    return [*curves, Curve("after", factor * residual(trace, name, "after"), AFTER)] if after else curves


def _extent(values: np.ndarray) -> float:
    """Largest less smallest of what is finite; infinite where nothing varies."""
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if known.size and np.ptp(known) > 0.0 else math.inf


def residual(trace: Trace, name: str, run: str) -> np.ndarray:
    """Measured minus simulated (T,), SI; headings the short way round."""
    error = trace.measured[name] - getattr(trace, run)[name]
    return error - 2.0 * np.pi * np.round(error / (2.0 * np.pi)) if name == "heading_rad" else error


def _unwrapped(name: str, values: np.ndarray) -> np.ndarray:
    if name != "heading_rad":
        return values
    out, known = values.copy(), np.isfinite(values)
    out[known] = np.unwrap(values[known])
    return out


def _turns(name: str, trace: Trace) -> float:
    """Full turns by which the simulated heading is off the unwrapped measured one where both begin."""
    if name != "heading_rad":
        return 0.0
    gap = _unwrapped(name, trace.measured[name]) - trace.before[name]
    known = gap[np.isfinite(gap)]
    return float(2.0 * np.pi * np.round(known[0] / (2.0 * np.pi))) if known.size else 0.0


def _tracks(trace: Trace, after: bool) -> list[tuple[np.ndarray, np.ndarray, Curve]]:
    if not {"north_m", "east_m"} <= trace.measured.keys():
        return []
    runs = [("measured", trace.measured, Curve("measured", np.zeros(0), MEASURED, width=1.8))]
    runs.append(("before", trace.before, Curve("before", np.zeros(0), BEFORE, "5 3")))
    if after:
        runs.append(("after", trace.after, Curve("after", np.zeros(0), AFTER)))
    return [(run["north_m"], run["east_m"], curve) for _, run, curve in runs if {"north_m", "east_m"} <= run.keys()]


def error_line(trace: Trace, after: bool) -> str:
    """Root mean square errors of a record's free runs, in one line."""
    told = []
    for name in [c for c in (*CHANNELS, "north_m", "east_m") if c in trace.measured and c in trace.before]:
        word, unit, factor = words.channel(name)
        values = [words.number(factor * rms(residual(trace, name, run))) for run in ("before", "after")[: 1 + after]]
        told.append(f"{word} {' → '.join(values)} {unit}")
    return ", ".join(told)


def rms(values: np.ndarray) -> float:
    """Root mean square of what is finite; nan if nothing is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else math.nan


# ---- tables


def where_row(entry: Mapping[str, Any]) -> dict[str, Any]:
    """One condition: its text, its share of the squared error as a bar and against its share of the time."""
    share, time = (float(entry.get(key) or 0.0) for key in ("share_of_error", "share_of_time"))
    where = words.channel(str(entry.get("channel", "")))[0]
    shares = f"{100.0 * share:.0f} % of the squared error in {100.0 * time:.0f} % of the time"
    condition = f"{where}: {entry.get('condition', '')}"
    return {"condition": condition, "width": 100.0 * min(max(share, 0.0), 1.0), "mark": 100.0 * time, "shares": shares}


def bar_width(p: float | None) -> float:
    """Evidence as a bar: -log10 p in per cent of the longest."""
    if p is None or math.isnan(p):
        return 0.0
    return 100.0 * min(-math.log10(max(p, 1e-300)), LONGEST_BAR) / LONGEST_BAR


def _bank_row(entry: Entry, found: Diagnosis) -> dict[str, Any]:
    finding = next((f for f in found.causes if entry.cause in (f.cause, *f.tied_with)), None)
    rivals = [c for c in (finding.cause, *finding.tied_with) if c != entry.cause] if finding is not None else []
    return {
        "cause": words.cause(entry.cause),
        "status": entry.status.replace("_", " "),
        "kind": entry.status,
        "tied": ", ".join(map(words.cause, rivals)),
        "width": bar_width(entry.p_adjusted),
        "statistic": words.number(entry.statistic),
        "p": words.p_value(entry.p_adjusted),
        "power": words.NOTHING if entry.power is None else f"{100.0 * entry.power:.0f} %",
        "why": entry.why,
    }


def instrument_rows(found: Diagnosis) -> list[tuple[str, str]]:
    """What the extension says of rudder linkage and sensors: name, value with unit."""
    from ...models.instruments import INSTRUMENTS, SWAPS

    own = {k: v for k, v in found.extended.instruments.items() if found.model.instruments.get(k) != v}
    rows = []
    for name, value in own.items():
        unit = words.IN_DEGREES.get(INSTRUMENTS[name], INSTRUMENTS[name])
        factor = words.DEG if INSTRUMENTS[name] in words.IN_DEGREES else 1.0
        switch = name in (*SWAPS, "earth_frame_velocity", "rudder_reversed")
        rows.append(
            (words.cause(name), "yes" if switch else f"{words.number(factor * value)} {unit}".removesuffix(" 1"))
        )
    return rows
