"""The track against heading and log where the model holds no track: sensor causes that need no dynamics.

A response model says nothing of sway and positions, yet (north, east)' = R(psi) (surge, sway) must hold among the
records' own channels.  What is left of the positions, less the velocities' integral, is regressed on what each sensor
error would leave there; a steady drift of each record (a current, where speeds are through the water) is estimated
along, the log's noise is a random walk and the positions' noise white (a local-level Kalman filter whitens both).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.instruments import corrected
from ..methods.series import bridged, sensor_sd
from .evidence import MOST_TIED, TIE_NATS, log_tail
from .result import Finding, Size
from .sizes import NORMAL_90

if TYPE_CHECKING:
    from ..datasets.record import Record

NEEDED = ("heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m")
ALIKE = {"heading_offset": "axis_misalignment"}
"""What the track alone cannot tell apart."""
CAUSES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "speed_scale": ("s", "1", ("surge_scale", "sway_scale")),
    "sway_offset": ("b", "m/s", ("sway_bias",)),
    "heading_offset": ("b", "rad", ("heading_bias",)),
    "velocity_delay": ("tau", "s", ("surge_delay", "sway_delay")),
    "velocity_delay:all": ("tau", "s", ("surge_delay", "sway_delay", "yaw_rate_delay", "heading_delay")),
}
"""Cause, with a variant after a colon -> name and unit of its size, and the instruments that it sets."""
SHARE = 0.1
"""Share of the family-wise level that this stage spends."""
STEPS, MOST = 4, 2
LEAST_DELAY = 0.1
"""Share of the sampling step below which a delay is not told from how velocities were made."""
SEPARATE = "rudder manoeuvres with a model that holds sway, or the compass and the log checked each by itself"


@dataclass(frozen=True)
class Tracks:
    """What the stage found: findings, instruments that put the records right, and each cause's statistic."""

    findings: tuple[Finding, ...] = ()
    instruments: tuple[tuple[str, float], ...] = ()
    statistics: tuple[tuple[str, float], ...] = ()


def usable(records: Sequence[Record]) -> list[Record]:
    """Records that hold heading, both speeds and both positions."""
    return [r for r in records if r.has(*NEEDED) and np.isfinite(r.column("north_m")).sum() > 20]


def compare(records: Sequence[Record], alpha: float, only: Sequence[str] | None = None) -> Tracks:
    """Sensor causes that the tracks ask for, at most two, by forward selection at a share of the level `alpha`."""
    records = usable(records)
    bank = [name for name in CAUSES if only is None or _cause(name) in only]
    if not records or not bank:
        return Tracks()
    threshold = np.log(SHARE * alpha / (len(bank) * MOST))
    chosen: dict[str, tuple[str, ...]] = {}
    first: dict[str, float] = {}
    told: list[float] = []
    while True:
        values, spread = _fitted(records, [*chosen])
        if len(chosen) == MOST:
            break
        open_ = [name for name in bank if _cause(name) not in map(_cause, chosen)]
        statistics = {name: _statistic(records, [*chosen], values, name) for name in open_}
        first = first or dict(statistics)
        best = max(statistics, key=lambda name: statistics[name], default=None)
        if best is None or log_tail(statistics[best], 1) > threshold:
            break
        near = [best, *(name for name in statistics if statistics[best] - statistics[name] < 2.0 * TIE_NATS)]
        alike = dict.fromkeys(x for name in map(_cause, near) for x in (name, ALIKE.get(name, name)))
        chosen[best] = tuple(x for x in alike if x != _cause(best))
        told.append(statistics[best])
    instruments = {slot: float(v) for name, v in zip(chosen, values, strict=True) for slot in CAUSES[name][2]}
    findings = tuple(
        _finding(name, ties[:MOST_TIED], float(v), float(sd), statistic, len(bank))
        for (name, ties), v, sd, statistic in zip(chosen.items(), values, spread, told, strict=True)
    )
    best_of = {_cause(name): max(first[x] for x in first if _cause(x) == _cause(name)) for name in first}
    best_of |= {other: best_of[name] for name, other in ALIKE.items() if name in best_of}
    return Tracks(findings, tuple(instruments.items()), tuple(best_of.items()))


def _cause(name: str) -> str:
    return name.partition(":")[0]


def _finding(name: str, ties: tuple[str, ...], value: float, sd: float, statistic: float, tests: int) -> Finding:
    parameter, unit, _ = CAUSES[name]
    size = Size(parameter, value, value - NORMAL_90 * sd, value + NORMAL_90 * sd, unit)
    said = f"heading and log lead off the positions as it would; twice the log likelihood rises by {statistic:.1f}"
    adjusted = float(min(1.0, np.exp(log_tail(statistic, 1)) * tests))
    return Finding(
        _cause(name),
        ties,
        "kinematics",
        statistic,
        adjusted,
        (size,),
        evidence=said,
        separate_by=SEPARATE if ties else None,
    )


def _fitted(records: Sequence[Record], chosen: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Sizes of the chosen causes and their standard errors: Gauss-Newton steps on records put right."""
    values, spread = np.zeros(len(chosen)), np.zeros(len(chosen))
    for _ in range(STEPS if chosen else 0):
        y, x = _rows(records, chosen, values, chosen)
        inverse = np.linalg.pinv(x.T @ x)
        step = inverse @ x.T @ y
        error = y - x @ step
        values = values + step[: len(chosen)]
        late = [i for i, name in enumerate(chosen) if _cause(name) == "velocity_delay"]
        values[late] = np.maximum(values[late], 0.0)
        spread = np.sqrt(np.diag(inverse)[: len(chosen)] * np.mean(error**2) / _own_share(error))
    return values, spread


def _statistic(records: Sequence[Record], chosen: Sequence[str], values: np.ndarray, name: str) -> float:
    """N log(RSS0 / RSS1) of one cause more; 0 for a delay that would be negative or is far below the sampling step."""
    y, x = _rows(records, chosen, values, [*chosen, name])
    column = len(chosen)
    rest = np.delete(x, column, axis=1)
    without = y - rest @ np.linalg.lstsq(rest, y, rcond=None)[0]
    solution = np.linalg.lstsq(x, y, rcond=None)[0]
    with_it = y - x @ solution
    if _cause(name) == "velocity_delay" and solution[column] < LEAST_DELAY * records[0].dt:
        return 0.0
    gain = np.log(max(without @ without, 1e-300) / max(with_it @ with_it, 1e-300))
    return float(_own_share(with_it) * y.size * gain)


def _own_share(error: np.ndarray) -> float:
    """Share of the samples that count by themselves where whitened errors (N,) are still correlated."""
    size = float(error @ error)
    rho = float(np.clip(error[1:] @ error[:-1] / size, 0.0, 0.98)) if size > 0.0 else 0.0
    return (1.0 - rho) / (1.0 + rho)


def _rows(records: Sequence[Record], chosen: Sequence[str], values: np.ndarray, names: Sequence[str]):
    """Whitened departures of the tracks (N,) and columns (N, k + drifts) at records put right for `chosen`."""
    instruments = {slot: float(v) for name, v in zip(chosen, values, strict=True) for slot in CAUSES[name][2]}
    parts = [_whitened(corrected(r, instruments), names) for r in records]
    drifts = sum(p[2].shape[1] for p in parts)
    y, x, at = [], [], 0
    for departure, columns, drift in parts:
        wide = np.zeros((len(departure), drifts))
        wide[:, at : at + drift.shape[1]] = drift
        at += drift.shape[1]
        y.append(departure)
        x.append(np.hstack([columns, wide]))
    return np.concatenate(y), np.vstack(x)


def _whitened(record: Record, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of one record: departure (2T,), columns (2T, k) of the causes and (2T, 2) of a steady drift, whitened."""
    time = record.time_s - record.time_s[0]
    psi = bridged(record.heading_unwrapped(), time)
    u, v, north, east = (bridged(record.column(name), time) for name in NEEDED[1:])
    cosine, sine = np.cos(psi), np.sin(psi)
    rates = np.stack([u * cosine - v * sine, u * sine + v * cosine])
    path = _integral(rates, time)
    made = {
        "speed_scale": -path,
        "sway_offset": _integral(np.stack([sine, -cosine]), time),
        "heading_offset": np.stack([path[1], -path[0]]),
        "velocity_delay": _late(u, v, psi),
        "velocity_delay:all": rates - rates[:, :1],
    }
    zero = np.zeros_like(time)
    nuisance = [np.stack([time, zero]), np.stack([zero, time])]
    series = [np.stack([north, east]) - path, *(made[name] for name in names), *nuisance]
    place = max(sensor_sd(north), sensor_sd(east), 1e-6)
    walk = np.hypot(max(sensor_sd(u), sensor_sd(v)), np.mean(np.hypot(u, v)) * sensor_sd(psi)) * np.median(
        np.diff(time)
    )
    known = np.isfinite(record.column("north_m")) & np.isfinite(record.column("east_m"))
    rows = _local_level(np.stack([s.ravel() for s in series]).reshape(len(series), 2, -1), known, place, walk)
    return rows[0], rows[1 : 1 + len(names)].T, rows[1 + len(names) :].T


def _integral(rates: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Integrals (2, T) of rates (2, T), 0 at the start."""
    from scipy.integrate import cumulative_trapezoid

    return cumulative_trapezoid(rates, time, initial=0.0)


def _late(u: np.ndarray, v: np.ndarray, psi: np.ndarray) -> np.ndarray:
    """(2, T) sums of the speeds' changes, turned north and east: the way that speeds a second late leave out."""
    middle = 0.5 * (psi[1:] + psi[:-1])
    cosine, sine, along, across = np.cos(middle), np.sin(middle), np.diff(u), np.diff(v)
    steps = np.stack([along * cosine - across * sine, along * sine + across * cosine])
    return np.concatenate([np.zeros((2, 1)), np.cumsum(steps, axis=1)], axis=1)


def _local_level(series: np.ndarray, known: np.ndarray, place: float, walk: float) -> np.ndarray:
    """Whitened innovations (m, 2 T) of series (m, 2, T) under white noise on a random walk from an unknown start."""
    level = series[:, :, 0].copy()
    variance = place**2
    out = np.zeros_like(series)
    for k in range(1, series.shape[2]):
        variance += walk**2
        if not known[k]:
            continue
        total = variance + place**2
        error = series[:, :, k] - level
        out[:, :, k] = error / np.sqrt(total)
        level += variance / total * error
        variance *= place**2 / total
    return out.reshape(len(series), -1)
