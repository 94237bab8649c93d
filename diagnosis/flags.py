"""Gross faults of a record that come before everything else: the rudder's sign, frames and exchanged columns.

They need no dynamic model: headings are compared with integrated yaw rates, displacements with integrated velocities,
and the yaw acceleration with the rudder.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

WINDOW_S = 8.0
BETTER = 0.5
"""Share of the present disagreement below which another reading of the columns is believed."""


@dataclass(frozen=True)
class Flag:
    """A gross fault, how clearly it shows (in sd, roughly), and the records with it put right."""

    cause: str
    details: dict
    evidence: str
    statistic: float


def put_right(records: Sequence[Record], model: Model) -> tuple[list[Record], list[Flag]]:
    """Records with gross faults corrected, and what they were."""
    found: list[Flag] = []
    current = list(records)
    for test in (_yaw_rate_column, _velocity_reading, lambda r: _sign(r, model)):
        flag, current = test(current)
        found += [flag] if flag is not None else []
    return current, found


Fix = Callable[["Record"], "Record"]


def _column(record: Record, name: str) -> np.ndarray | None:
    return record.column(name) if record.has(name) else None


def _yaw_rate_column(records: list[Record]) -> tuple[Flag | None, list[Record]]:
    """The rate channel that goes with the heading: yaw rate, or what is called roll rate."""
    if not all(r.has("heading_rad") and r.has("yaw_rate_rad_s") and r.has("roll_rate_rad_s") for r in records):
        return None, records
    own = np.mean([_rate_error(r, "yaw_rate_rad_s") for r in records])
    other = np.mean([_rate_error(r, "roll_rate_rad_s") for r in records])
    if not (other < BETTER * own and own > 0.3):
        return None, records
    names = ("yaw_rate_rad_s", "roll_rate_rad_s")
    fixed = [_exchanged(r, *names) for r in records]
    said = (
        f"the heading moves with the roll-rate column (unexplained share {other:.3f}), "
        f"not with the yaw-rate column ({own:.3f})"
    )
    return Flag("channel_swap", {"channels": list(names)}, said, float((own / max(other, 1e-6)) ** 2)), fixed


def _rate_error(record: Record, name: str) -> float:
    """Share of the heading's changes over windows that a rate column does not give."""
    from scipy.integrate import cumulative_trapezoid

    psi, rate, time = record.heading_unwrapped(), record.column(name), record.time_s
    known = np.isfinite(psi) & np.isfinite(rate)
    psi, rate, time = psi[known], rate[known], time[known]
    step = max(2, round(WINDOW_S / 8.0 / np.median(np.diff(time))))
    turned = psi[step:] - psi[:-step]
    given = cumulative_trapezoid(rate, time, initial=0.0)
    error = turned - (given[step:] - given[:-step])
    return float(np.sqrt(np.mean(error**2) / max(np.mean(turned**2), 1e-300)))


def _velocity_reading(records: list[Record]) -> tuple[Flag | None, list[Record]]:
    """Body-axes velocities against displacement: as they are, earth-fixed, exchanged, or the positions exchanged."""
    need = ("heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m")
    usable = [r for r in records if r.has(*need)]
    if not usable:
        return None, records
    readings: dict[str, Fix] = {
        "earth_frame_velocity": _to_body,
        "surge_m_s sway_m_s": lambda r: _exchanged(r, "surge_m_s", "sway_m_s"),
        "north_m east_m": lambda r: _exchanged(r, "north_m", "east_m"),
    }
    present = np.mean([_track_error(r) for r in usable])
    errors = {name: np.mean([_track_error(fix(r)) for r in usable]) for name, fix in readings.items()}
    best = min(errors, key=lambda name: errors[name])
    if not (errors[best] < BETTER * present and present > 0.02):
        return None, records
    fixed = [readings[best](r) if r.has(*need) else r for r in records]
    statistic = float((present / max(errors[best], 1e-6)) ** 2)
    said = (
        f"the track disagrees with the velocities by {present:.3f} of the way made, by {errors[best]:.3f} when read so"
    )
    if best == "earth_frame_velocity":
        return Flag(best, {}, said, statistic), fixed
    return Flag("channel_swap", {"channels": best.split()}, said, statistic), fixed


def _track_error(record: Record) -> float:
    """Error of the displacement over windows that heading and velocities give, as a share of the way made."""
    from scipy.integrate import cumulative_trapezoid

    psi, u, v = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    x, y, time = record.column("north_m"), record.column("east_m"), record.time_s
    known = np.all(np.isfinite([psi, u, v, x, y]), axis=0)
    psi, u, v, x, y, time = (a[known] for a in (psi, u, v, x, y, time))
    step = max(2, round(WINDOW_S / np.median(np.diff(time))))
    north, east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    errors, way = [], []
    for place, rate in ((x, north), (y, east)):
        given = cumulative_trapezoid(rate, time, initial=0.0)
        moved = place[step:] - place[:-step]
        errors.append(moved - (given[step:] - given[:-step]))
        way.append(moved)
    return float(np.sqrt(np.mean(np.square(errors)) / max(np.mean(np.square(way)), 1e-300)))


def _to_body(record: Record) -> Record:
    """Velocities along north and east turned into body axes."""
    psi, north, east = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    surge, sway = north * np.cos(psi) + east * np.sin(psi), -north * np.sin(psi) + east * np.cos(psi)
    return record.with_channels(surge_m_s=surge, sway_m_s=sway)


def _exchanged(record: Record, first: str, second: str) -> Record:
    return record.with_channels(**{first: record.column(second), second: record.column(first)})


def _sign(records: list[Record], model: Model) -> tuple[Flag | None, list[Record]]:
    """The side to which the recorded rudder turns the ship: the sign of b in r_dot = a r + b delta + c."""
    rows, target = [], []
    for record in records:
        rate = _column(record, "yaw_rate_rad_s")
        if rate is None and not record.has("heading_rad"):
            continue
        time = record.time_s
        if rate is None:
            rate = np.gradient(record.heading_unwrapped(), time)
        rudder = record.rudder()
        step = max(1, round(time[-1] / 200.0 / np.median(np.diff(time))))
        n = time.size // step
        known = np.isfinite(rate) & np.isfinite(rudder)
        if known.sum() < 20:
            continue
        fill = [
            np.interp(time, time[known], a[known])[: n * step].reshape(n, step).mean(axis=1) for a in (rate, rudder)
        ]
        middle = time[: n * step].reshape(n, step).mean(axis=1)
        slope = np.diff(fill[0]) / np.diff(middle)
        mean = [0.5 * (a[1:] + a[:-1]) for a in fill]
        rows.append(np.column_stack([mean[0], mean[1], np.ones(n - 1)]))
        target.append(slope)
    if not rows:
        return None, records
    phi, y = np.vstack(rows), np.concatenate(target)
    b, *_ = np.linalg.lstsq(phi, y, rcond=None)
    error = y - phi @ b
    inverse = np.linalg.pinv(phi.T @ phi)
    sd = float(np.sqrt(max(inverse[1, 1], 0.0) * np.sum(error**2) / max(y.size - 3, 1)))
    z = model.starboard * b[1] / max(sd, 1e-300)
    if not z < -6.0:
        return None, records
    fixed = [_turned(r) for r in records]
    said = f"a rudder angle the record calls positive turns the ship to the other side than the model's ({-z:.0f} sd)"
    return Flag("rudder_sign", {}, said, float(z * z)), fixed


def _turned(record: Record) -> Record:
    names = [n for n in ("rudder_rad", "rudder_command_rad") if record.has(n)]
    return record.with_channels(**{n: -record.column(n) for n in names})
