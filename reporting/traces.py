"""Charts of a diagnosis as hand-written SVG, each with its own style: time series, track, spectra, bars."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

WIDTH, LEFT, RIGHT, TOP, BOTTOM = 640, 56, 16, 8, 22
MEASURED, BEFORE, AFTER, SOFT, GRID = "#1d2733", "#c8553d", "#1b6ca8", "#5b6b7b", "#e3e8ee"
FONT = 'font-family="system-ui, sans-serif" font-size="11"'
POINTS = 320
"""Columns to which a long series is thinned; each keeps its smallest and largest sample."""


@dataclass(frozen=True)
class Curve:
    """One line: label, values (N,), colour, dash pattern, width."""

    label: str
    values: np.ndarray
    colour: str
    dash: str = ""
    width: float = 1.3


@dataclass(frozen=True)
class Axis:
    """Data range and pixel range of one direction."""

    low: float
    high: float
    start: float
    end: float

    def place(self, value: np.ndarray | float) -> np.ndarray | float:
        """Pixels of data values."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)


def series(
    time: np.ndarray,
    curves: Sequence[Curve],
    title: str,
    height: int = 190,
    zero: bool = False,
    limit: float = math.inf,
) -> str:
    """Values over time; an empty text where nothing is finite.  What lies beyond +- limit does not stretch it."""
    low, high = _range([c.values for c in curves], zero, limit)
    if low is None or high is None:
        return ""
    across = Axis(float(time[0]), float(time[-1]), LEFT, WIDTH - RIGHT)
    up = Axis(low, high, height - BOTTOM, TOP)
    parts = [*_open(height, title), *_grid(across, up, height, " s")]
    if zero:
        parts.append(f'<path d="M{LEFT} {up.place(0.0):.1f}H{WIDTH - RIGHT}" stroke="{SOFT}" stroke-width=".8"/>')
    parts += [_path(across.place(time), up.place(c.values), c) for c in curves]
    return "\n".join([*parts, "</svg>"])


def track(curves: Sequence[tuple[np.ndarray, np.ndarray, Curve]], title: str) -> str:
    """Positions (north, east) in metres, to equal scales; an empty text where nothing is finite.

    North points up, or to the left where the track is longer than wide, so that it fills the chart.
    """
    known = [(n, e) for n, e, _ in curves if np.isfinite(n + e).any()]
    if not known:
        return ""
    north, east = (_span([pair[i] for pair in known]) for i in (0, 1))
    lying = north[1] - north[0] > 1.3 * (east[1] - east[0])
    flat, steep = (north, east) if lying else (east, north)
    wide = WIDTH - LEFT - RIGHT
    height = TOP + BOTTOM + min(max(wide * (steep[1] - steep[0]) / (flat[1] - flat[0]), 120.0), 420.0)
    metres = max((flat[1] - flat[0]) / wide, (steep[1] - steep[0]) / (height - TOP - BOTTOM))
    across = _centred(flat, metres, (WIDTH - RIGHT, LEFT) if lying else (LEFT, WIDTH - RIGHT))
    up = _centred(steep, metres, (height - BOTTOM, TOP))
    parts = [*_open(height, title), *_grid(across, up, height, " N" if lying else " E")]
    places = [(across.place(n), up.place(e)) if lying else (across.place(e), up.place(n)) for n, e, _ in curves]
    parts += [_path(x, y, curve, thin=False) for (x, y), (_, _, curve) in zip(places, curves, strict=True)]
    first = int(np.argmax(np.isfinite(places[0][0] + places[0][1])))
    x, y = (float(np.asarray(pixels)[first]) for pixels in places[0])
    if math.isfinite(x + y):
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{MEASURED}"/>')
    side = "east up, north to the left" if lying else "north up"
    return "\n".join([*parts, _note(WIDTH - RIGHT, TOP + 10, side, "end"), "</svg>"])


def _span(arrays: Sequence[np.ndarray]) -> tuple[float, float]:
    low, high = _range(arrays, False)
    return (0.0, 1.0) if low is None or high is None else (low, high)


def _centred(span: tuple[float, float], metres: float, pixels: tuple[float, float]) -> Axis:
    """The axis through the middle of a span, at so many metres a pixel."""
    middle, half = (span[0] + span[1]) / 2.0, metres * abs(pixels[1] - pixels[0]) / 2.0
    return Axis(middle - half, middle + half, *pixels)


def spectra(frequency: np.ndarray, curves: Sequence[Curve], unit: str, title: str, height: int = 220) -> str:
    """Amplitudes over frequency on logarithmic axes; an empty text where nothing is positive."""
    values = np.concatenate([c.values for c in curves]) if curves else np.zeros(0)
    values = values[np.isfinite(values) & (values > 0.0)]
    if not values.size or frequency.size < 2:
        return ""
    low, high = math.floor(math.log10(values.min())), math.ceil(math.log10(values.max()) + 1e-9)
    across = Axis(math.log10(frequency[0]), math.log10(frequency[-1]), LEFT, WIDTH - RIGHT)
    up = Axis(low, max(high, low + 1), height - BOTTOM, TOP)
    parts = _open(height, title)
    for exponent in range(int(up.low), int(up.high) + 1):
        parts += _tick_y(up.place(float(exponent)), f"1e{exponent}")
    for exponent in range(math.ceil(across.low), math.floor(across.high) + 1):
        parts += _tick_x(across.place(float(exponent)), height, f"{10.0**exponent:g}")
    parts.append(_note(WIDTH - RIGHT, TOP + 12, f"{unit} over Hz", "end"))
    with np.errstate(all="ignore"):
        parts += [_path(across.place(np.log10(frequency)), up.place(np.log10(c.values)), c, thin=False) for c in curves]
    return "\n".join([*parts, "</svg>"])


def bars(groups: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], unit: str, title: str) -> str:
    """Horizontal bars: one group a line, one bar a name in it."""
    values = [v for group in groups.values() for v in group.values() if math.isfinite(v)]
    if not values or max(values) <= 0.0:
        return ""
    step = 14 * max(map(len, groups.values())) + 10
    height = TOP + step * len(groups) + BOTTOM
    across = Axis(0.0, max(values) * 1.05, 190, WIDTH - RIGHT - 60)
    parts = _open(height, title)
    for row, (group, bar) in enumerate(groups.items()):
        top = TOP + row * step
        parts.append(_note(182, top + step / 2, group, "end"))
        for place, (name, value) in enumerate(bar.items()):
            if not math.isfinite(value):
                continue
            y, end = top + 4 + 14 * place, across.place(value)
            parts.append(f'<rect x="190" y="{y}" width="{end - 190:.1f}" height="11" fill="{colours[name]}"/>')
            parts.append(_note(end + 5, y + 9, f"{value:.3g}", "start"))
    parts.append(_note(WIDTH - RIGHT, height - 8, unit, "end"))
    return "\n".join([*parts, "</svg>"])


# ---- pieces


def _open(height: float, title: str) -> list[str]:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" {FONT} '
    return [head + f'aria-label="{escape(title)}">', f'<rect width="{WIDTH}" height="{height}" fill="#fff"/>']


def _range(arrays: Sequence[np.ndarray], zero: bool, limit: float = math.inf) -> tuple[float | None, float | None]:
    """Padded range of what is finite; curves do not stretch it far beyond the first of several."""
    known = [a[np.isfinite(a)] for a in arrays]
    if not any(a.size for a in known):
        return None, None
    values = np.concatenate([np.clip(a, -limit, limit) for a in known])
    first = known[0]
    if zero:
        values = np.append(values, 0.0)
    elif first.size and first.max() > first.min():
        reach = 2.0 * (first.max() - first.min())
        values = np.clip(values, first.min() - reach, first.max() + reach)
    low, high = float(values.min()), float(values.max())
    pad = 0.06 * (high - low) or max(abs(low), 1.0) * 0.1
    return low - pad, high + pad


def _grid(across: Axis, up: Axis, height: float, unit: str) -> list[str]:
    """Lines and numbers; the unit stands behind the numbers along the bottom."""
    parts: list[str] = []
    for value in nice(up.low, up.high, 3 if height < 150 else 4):
        parts += _tick_y(up.place(value), f"{value:.6g}")
    for value in nice(across.low, across.high, 6):
        parts += _tick_x(across.place(value), height, f"{value:.6g}{unit}")
    return parts


def _tick_y(y: float | np.ndarray, text: str) -> list[str]:
    line = f'<path d="M{LEFT} {y:.1f}H{WIDTH - RIGHT}" stroke="{GRID}"/>'
    return [line, _note(LEFT - 6, float(y) + 4, text, "end")]


def _tick_x(x: float | np.ndarray, height: float, text: str) -> list[str]:
    line = f'<path d="M{x:.1f} {TOP}V{height - BOTTOM}" stroke="{GRID}"/>'
    return [line, _note(float(x), height - BOTTOM + 14, text, "middle")]


def _note(x: float | np.ndarray, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{SOFT}">{escape(text)}</text>'


def nice(low: float, high: float, count: int) -> list[float]:
    """About `count` round values between low and high."""
    raw = (high - low) / max(count, 1)
    size = 10.0 ** math.floor(math.log10(raw))
    step = next(size * m for m in (1, 2, 2.5, 5, 10) if size * m >= raw)
    values = [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
    return [0.0 if abs(v) < 1e-12 * step else v for v in values]


def _path(x, y, curve: Curve, thin: bool = True) -> str:
    """A polyline broken at gaps and where it leaves the chart by far."""
    x, y = thinned(np.asarray(x), np.asarray(y)) if thin else (np.asarray(x), np.asarray(y))
    known = np.isfinite(x) & np.isfinite(y) & (np.abs(y) < 5000.0)
    pen, words = "M", []
    for px, py, fine in zip(x, y, known, strict=True):
        if fine:
            words.append(f"{pen}{px:.1f} {py:.1f}")
        pen = "L" if fine else "M"
    style = f'stroke="{curve.colour}" stroke-width="{curve.width}"' + (
        f' stroke-dasharray="{curve.dash}"' if curve.dash else ""
    )
    return f'<path d="{"".join(words)}" fill="none" stroke-linejoin="round" {style}/>'


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Series (N,) thinned to the first, smallest and largest sample of each of `POINTS` columns."""
    if x.size <= 3 * POINTS:
        return x, y
    keep: list[int] = []
    for block in np.array_split(np.arange(x.size), POINTS):
        values = y[block]
        if np.isfinite(values).any():
            keep += sorted({int(block[0]), int(block[np.nanargmin(values)]), int(block[np.nanargmax(values)])})
        else:
            keep.append(int(block[0]))
    return x[keep], y[keep]
