"""Small SVG charts for the report, written by hand so that the page needs no plotting library."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 560, 260, 56, 130, 16, 34
COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#b8860b", "#6a4c93", "#3d5a6c", "#c2652a", "#008b8b")


def by_level(series: Mapping[str, Sequence[float | None]], levels: Sequence[str], title: str) -> str:
    """A line per name over ordered levels on a logarithmic axis; points that are not positive and finite are left out.

    Returns an empty text where fewer than two levels or no points are given.
    """
    values = [value for line in series.values() for value in line if value is not None and _drawable(value)]
    if len(levels) < 2 or not values:
        return ""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    high = max(high, low + 1)

    def x(place: int) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * (place + 0.5) / len(levels)

    def y(value: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (math.log10(value) - low) / (high - low)

    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title)}">']
    step = max(1, (high - low + 5) // 6)
    for exponent in range(low, high + 1, step):
        height = y(10.0**exponent)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{height:.1f}" y2="{height:.1f}"/>')
        parts.append(f'<text class="tick" x="{LEFT - 6}" y="{height + 4:.1f}" text-anchor="end">1e{exponent}</text>')
    for place, level in enumerate(levels):
        label = f'<text class="tick" x="{x(place):.1f}" y="{HEIGHT - 12}" text-anchor="middle">{escape(level)}</text>'
        parts.append(label)
    for number, (name, line) in enumerate(series.items()):
        points = [(x(place), y(value)) for place, value in enumerate(line) if value is not None and _drawable(value)]
        parts += _line(name, points, COLOURS[number % len(COLOURS)], TOP + 12 + 16 * number)
    return "\n".join([*parts, "</svg>"])


def rate_curves(series: Mapping[str, Sequence[tuple[float, float, float, float]]], title: str) -> str:
    """A line per name through (x, rate, low, high) with bars, x > 0 on a logarithmic axis, rates 0 .. 1.

    Returns an empty text where there are no points.
    """
    places = [point[0] for line in series.values() for point in line]
    if not places:
        return ""
    first, last = math.floor(math.log10(min(places))), max(math.ceil(math.log10(max(places))), 1)
    last = max(last, first + 1)

    def x(place: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * (math.log10(place) - first) / (last - first)

    def y(rate: float) -> float:
        return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * rate

    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title)}">']
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(share):.1f}" y2="{y(share):.1f}"/>')
        label = f'<text class="tick" x="{LEFT - 6}" y="{y(share) + 4:.1f}" text-anchor="end">{100 * share:.0f} %</text>'
        parts.append(label)
    for exponent in range(first, last + 1):
        label = (
            f'<text class="tick" x="{x(10.0**exponent):.1f}" y="{HEIGHT - 12}" text-anchor="middle">1e{exponent}</text>'
        )
        parts.append(label)
    for number, (name, line) in enumerate(series.items()):
        colour = COLOURS[number % len(COLOURS)]
        aside = 3.0 * number  # bars of several lines at one place stand side by side
        bars = [(x(place) + aside, y(low), y(high)) for place, _, low, high in line]
        parts += [
            f'<line class="bar" stroke="{colour}" x1="{a:.1f}" x2="{a:.1f}" y1="{b:.1f}" y2="{c:.1f}"/>'
            for a, b, c in bars
        ]
        parts += _line(
            name, [(x(place) + aside, y(rate)) for place, rate, _, _ in line], colour, TOP + 12 + 16 * number
        )
    return "\n".join([*parts, "</svg>"])


def _line(name: str, points: Sequence[tuple[float, float]], colour: str, legend: float) -> list[str]:
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    dots = [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in points]
    key = WIDTH - RIGHT + 12
    return [
        f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>',
        *dots,
        f'<circle cx="{key}" cy="{legend - 4}" r="4" fill="{colour}"/>',
        f'<text class="tick" x="{key + 10}" y="{legend}">{escape(name)}</text>',
    ]


def _drawable(value: float) -> bool:
    return math.isfinite(value) and value > 0.0
