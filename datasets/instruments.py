"""Records as a model's instruments show them, and the true motion behind such a record.

`models.instruments` names the numbers and their equations.  `observed` is what the sensors show of a true record;
`corrected` undoes that and turns the recorded rudder angle into the one that acted on the hull.  Methods are given
corrected records; `simulate` writes observed ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from ..models.errors import BadInput
from ..models.instruments import SENSORS, SWAPS, bent, checked, linkage, similar, straightened
from ..models.linear_algebra import pinv
from .columns import POSITIONS, RUDDERS, TURN
from .record import Record
from .signals import noise_in

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

    from ..models.model import Model

RATE_LIMIT = "rudder_rate_limit"
HEADING, SURGE, SWAY, REVOLUTIONS = "heading_rad", "surge_m_s", "sway_m_s", "propeller_rps"
SMOOTHED, EVEN = 11, 1e-6
"""Samples whose polynomial gives a noisy channel's slope, and scatter of the time steps up to which they are even."""


def corrected(record: Record, instruments: Mapping[str, float]) -> Record:
    """The true motion at true times: sensor errors removed, and the rudder angle that acted on the hull.

    A delayed channel loses its last samples; gaps stay gaps.  Waves are not removed: they are a random motion.

    Raises
    ------
    BadInput : an unknown instrument, or velocities in the earth frame without a heading.
    """
    q = checked(instruments)
    if not q:
        return record
    scale, q = 1.0 + q.get("ship_scale", 0.0), similar(q)
    record = _timed(record, 1.0 / (1.0 + q.get("clock_rate", 0.0)))
    channels = _swapped(dict(record.channels), q)
    if scale != 1.0 and REVOLUTIONS in channels:
        channels[REVOLUTIONS] = channels[REVOLUTIONS] * np.sqrt(scale)
    channels = {name: _sensed(name, record.time_s, values, q, back=True) for name, values in channels.items()}
    if HEADING in channels:
        channels[HEADING] = later(record.time_s, channels[HEADING], q.get("heading_delay", 0.0), angle=True)
    channels = _turned(channels, q, record.name, back=True)
    for short, (name, _) in SENSORS.items():
        if name in channels and name != HEADING:
            channels[name] = later(record.time_s, channels[name], q.get(f"{short}_delay", 0.0))
    channels = _at_point(record.time_s, channels, -q.get("point_ahead", 0.0))
    record = record.with_channels(**_gone(record, channels))
    for name in RUDDERS:  # of two columns the one that methods read, and the order as it was
        if record.has(name):
            return record.with_channels(**{name: felt_rudder(record.time_s, record.column(name), q)})
    return record


def hull_record(record: Record, model: Model) -> Record:
    """The true motion, as `corrected`, with the rudder in the model's sign, an order behind the vessel's own gear.

    A record that does not say its rudder's sign is taken to have the model's.
    """
    return corrected(record.turned(model.positive_rudder), {**gear_of(record, model), **model.instruments})


def gear_of(record: Record, model: Model) -> dict[str, float]:
    """The rate limit of the vessel's own gear, as an instrument, where the record holds the rudder's order alone and no
    instrument of the model limits its rate."""
    rate = model.rudder.rate_rad_s
    is_order = record.has(RUDDERS[1]) and not record.has(RUDDERS[0])
    return {RATE_LIMIT: rate} if is_order and np.isfinite(rate) and RATE_LIMIT not in model.instruments else {}


def observed(record: Record, instruments: Mapping[str, float], rng: np.random.Generator | None = None) -> Record:
    """What the sensors show of a record whose channels are true.

    Rudder and revolutions are the recorded ones already and stay (the rudder cannot be computed from the angle that
    acts on the hull, because of play and limits).  Waves are added where `rng` is given.  A delayed channel starts with
    its first value.

    Raises
    ------
    BadInput : an unknown instrument, or velocities in the earth frame without a heading.
    """
    q = similar(checked(instruments))
    if not q:
        return record
    true = _at_point(record.time_s, dict(record.channels), q.get("point_ahead", 0.0))
    channels = dict(true)
    for short, (name, _) in SENSORS.items():
        if name in channels:
            late = q.get(f"{short}_delay", 0.0)
            channels[name] = moved(record.time_s, channels[name], -late, name == HEADING, hold=True)
    if HEADING in true:
        channels = {**_turned(channels | {HEADING: true[HEADING]}, q, record.name), HEADING: channels[HEADING]}
    else:
        channels = _turned(channels, q, record.name)
    channels = _rocked(record.time_s, channels, q, rng)
    channels = {name: _sensed(name, record.time_s, values, q) for name, values in channels.items()}
    shown = record.with_channels(**_gone(record, _swapped(channels, q)))
    return _timed(shown, 1.0 + q.get("clock_rate", 0.0))


def _timed(record: Record, factor: float) -> Record:
    """The record with its times from its first sample on multiplied by a factor."""
    if factor == 1.0:
        return record
    first_s = record.time_s[0]
    return replace(record, time_s=first_s + factor * (record.time_s - first_s))


def felt_rudder(time_s: np.ndarray, recorded: np.ndarray, instruments: Mapping[str, float]) -> np.ndarray:
    """Rudder angle (N,) that the hull felt where `recorded` (N,) was measured or ordered; gaps stay gaps."""
    from ..models.rudder_chain import run_chain

    numbers, known = linkage(checked(instruments)), np.isfinite(recorded)
    late_s, play = (instruments.get(f"rudder_{error}", 0.0) for error in ("sensor_delay", "hysteresis"))
    if not (numbers.any() or play or late_s) or not known.any():
        return recorded
    series, noise = np.interp(time_s, time_s[known], recorded[known]), 0.0
    if play:
        series = before_play(time_s, series, play)
    series = np.interp(time_s + late_s, time_s, series)
    quiet, felt = series, np.empty(series.size)
    if instruments.get("rudder_backlash", 0.0) > 0.0:
        noise = rudder_noise(series)
        quiet = quietened(series, noise)
    run_chain(np.array(time_s, float), series, quiet, numbers, noise, 1, felt)
    return np.where(known, felt, np.nan)


def before_play(time_s: np.ndarray, shown: np.ndarray, play: float) -> np.ndarray:
    """The angle (N,) of which a sensor with play of +- play, rad, shows (N,): ahead of it by the play in the direction
    in which it moved last.  Just before it moves the other way the angle crosses the play, at the largest rate of the
    record."""
    noise = rudder_noise(shown)
    quiet = behind_play(quietened(shown, noise), noise)
    steps = np.diff(quiet)
    moving = np.flatnonzero(steps)
    turns = moving[np.diff(np.sign(steps[moving]), prepend=0.0) != 0.0]
    if not turns.size:
        return shown
    after = play * np.sign(steps[turns])
    before = np.concatenate([[0.0], after[:-1]])
    rate = float(np.max(np.abs(steps) / np.diff(time_s)))
    ends = time_s[turns]
    starts = np.maximum(ends - np.abs(after - before) / rate, np.concatenate([time_s[:1], ends[:-1]]))
    return shown + np.interp(time_s, np.ravel([starts, ends], "F"), np.ravel([before, after], "F"))


def behind_play(angle: np.ndarray, play: float) -> np.ndarray:
    """Angle (N,) behind play of +- play, at rest in its middle at first; both rad."""
    from ..models.rudder_chain import follow

    out = np.empty(angle.size)
    follow(np.array(angle, float), play, out)
    return out


def rudder_noise(series: np.ndarray) -> float:
    """Sensor noise (sd) of a rudder series (N,), from its second differences: its motion has kinks."""
    return noise_in(series, 2)


def quietened(series: np.ndarray, sd: float) -> np.ndarray:
    """A rudder series (N,) freed of its sensor's noise of sd `sd`; see `models.rudder_chain.quieten`."""
    from ..models.rudder_chain import quieten

    if not sd > 0.0:
        return series
    out = np.empty(series.size)
    quieten(np.ascontiguousarray(series, dtype=float), sd, out)
    return out


def _gone(record: Record, channels: dict[str, np.ndarray]) -> dict[str, np.ndarray | None]:
    """The channels, and None for each other channel of the record (`with_channels` then leaves it out)."""
    return {**dict.fromkeys(record.channels), **channels}


def _swapped(channels: dict[str, np.ndarray], q: Mapping[str, float]) -> dict[str, np.ndarray]:
    for swap, (a, b) in SWAPS.items():
        if q.get(swap, 0.0) != 0.0:
            found = {b: channels.pop(a, None), a: channels.pop(b, None)}
            channels |= {name: values for name, values in found.items() if values is not None}
    return channels


def _sensed(name: str, time: np.ndarray, values: np.ndarray, q: Mapping[str, float], back: bool = False) -> np.ndarray:
    """A channel (N,) as its sensor shows it, by its gain, the growth of that with the channel, bias and drift; back:
    the true one of what it shows."""
    short = next((short for short, (column, _) in SENSORS.items() if column == name), "")
    bias, drift = q.get(f"{short}_bias", 0.0), q.get(f"{short}_drift", 0.0)
    error = bias if drift == 0.0 else bias + drift * (time - time[0])
    gain, curve = 1.0 + q.get(f"{short}_scale", 0.0), q.get(f"{short}_curve", 0.0)
    if back and gain == 0.0:
        raise BadInput(f"a scale of -1 of {name} is not invertible")
    if gain == 1.0 and not curve and not np.any(error):
        return values
    return straightened(values - error, gain, curve) if back else bent(values, gain, curve) + error


def _at_point(time: np.ndarray, channels: dict[str, np.ndarray], ahead_m: float) -> dict[str, np.ndarray]:
    """Channels with sway and positions of a point further ahead: sway by the yaw rate or else the slope of the heading,
    which tells the positions."""
    if not ahead_m or not {*TURN} & channels.keys():
        return channels
    out = dict(channels)
    if SWAY in out:
        rate = out[TURN[1]] if TURN[1] in out else np.gradient(np.unwrap(out[HEADING]), time)
        out[SWAY] = out[SWAY] + ahead_m * rate
    if {HEADING, *POSITIONS} <= out.keys():
        out |= {
            name: out[name] + ahead_m * of(out[HEADING]) for name, of in zip(POSITIONS, (np.cos, np.sin), strict=True)
        }
    return out


def _turned(channels: dict[str, np.ndarray], q: Mapping[str, float], record: str, back: bool = False):
    """Surge and sway between the hull's axes and those of their sensor."""
    angle: float | np.ndarray = q.get("axis_misalignment", 0.0)
    if q.get("earth_frame_velocity", 0.0) != 0.0:
        if HEADING not in channels:
            raise BadInput("velocities in the earth frame need the heading", file=record, column=HEADING)
        angle = angle - channels[HEADING]
    if not np.any(angle) or SURGE not in channels or SWAY not in channels:
        return channels
    cosine, sine = np.cos(angle), np.sin(angle) * (-1.0 if back else 1.0)
    along, across = channels[SURGE], channels[SWAY]
    return {**channels, SURGE: along * cosine + across * sine, SWAY: -along * sine + across * cosine}


def moved(time: np.ndarray, values: np.ndarray, ahead: float, angle: bool = False, hold: bool = False) -> np.ndarray:
    """A channel (N,) as it is `ahead` s later, by a cubic spline; nan in gaps, and at the ends unless they are held."""
    known = np.isfinite(values)
    if ahead == 0.0 or known.sum() < 4:
        return values
    return _splined(time, known, _spline(time[known], values[known], angle), ahead, hold)


def later(time: np.ndarray, values: np.ndarray, ahead: float, angle: bool = False) -> np.ndarray:
    """A measured channel (N,) as it is `ahead` s later; nan in gaps and at the ends.

    The nearest sample and the change from there, by the slope of a polynomial through SMOOTHED samples: each value
    keeps the noise of one sample.  A spline between samples mixes the noise of several, and noise that was white would
    look like an effect; it is taken where the noise is too small to matter, and of uneven times.
    """
    known = np.isfinite(values)
    if ahead == 0.0 or known.sum() < SMOOTHED or np.ptp(np.diff(time)) > EVEN * np.median(np.diff(time)):
        return moved(time, values, ahead, angle)
    step_s = float(np.median(np.diff(time)))
    series = np.full(time.size, np.nan)
    series[known] = np.unwrap(values[known]) if angle else values[known]
    spline = _spline(time[known], series[known])
    splined = _splined(time, known, spline, ahead)
    whole, noise = spline(time), noise_in(series[known], 4) / step_s
    low, high = (_slope(whole, step_s, order) for order in (2, 4))
    if np.median(np.abs(high - spline(time, 1))) > 2.0 * noise:
        return splined
    slope = low if np.median(np.abs(low - high)) < 0.25 * noise else high
    steps = round(ahead / step_s)
    nearest = np.clip(np.arange(time.size) + steps, 0, time.size - 1)
    left_s = ahead - steps * step_s
    return series[nearest] + left_s * np.interp(time + ahead - 0.5 * left_s, time, slope) + 0.0 * splined


def _spline(time: np.ndarray, values: np.ndarray, angle: bool = False) -> CubicSpline:
    """A cubic spline through a channel without gaps."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(time, np.unwrap(values) if angle else values)


def _splined(time: np.ndarray, known: np.ndarray, spline: CubicSpline, ahead: float, hold: bool = False) -> np.ndarray:
    """A spline through the known samples, `ahead` s later: nan in gaps, and at the ends unless they are held."""
    first, last = time[known][0], time[known][-1]
    gap = np.interp(np.clip(time + ahead, first, last), time, (~known).astype(float)) > 0.0
    if not hold:
        gap |= (time + ahead > last) | (time + ahead < first)
    return np.where(gap, np.nan, spline(np.clip(time + ahead, first, last)))


def _slope(series: np.ndarray, step_s: float, order: int) -> np.ndarray:
    """Slope (N,), 1/s, of polynomials through SMOOTHED samples each; at the ends of those through the last ones
    (Savitzky and Golay 1964)."""
    rows, middle = _slope_weights(order), SMOOTHED // 2
    inside = np.convolve(series, rows[middle, ::-1], mode="valid")
    ends = rows[:middle] @ series[:SMOOTHED], rows[middle + 1 :] @ series[-SMOOTHED:]
    return np.concatenate([ends[0], inside, ends[1]]) / step_s


@cache
def _slope_weights(order: int) -> np.ndarray:
    """Weights (SMOOTHED, SMOOTHED) of samples in the slope at each of them, for a step of one."""
    powers, place = np.arange(order + 1), np.arange(SMOOTHED) - SMOOTHED // 2
    fit = pinv(place[:, None].astype(float) ** powers)
    return (powers * place[:, None] ** np.maximum(powers - 1, 0)) @ fit


def _rocked(
    time: np.ndarray, channels: dict[str, np.ndarray], q: Mapping[str, float], rng: np.random.Generator | None
) -> dict[str, np.ndarray]:
    """Heading and yaw rate with narrow-band motion: x'' + 2 z w x' + w^2 x = white noise, rms of x given."""
    rms = q.get("wave_rms", 0.0)
    if rng is None or rms <= 0.0:
        return channels
    motion = narrow_band(time, q.get("wave_frequency", 0.7), q.get("wave_damping", 0.1), rms, rng)
    added = dict(zip((HEADING, "yaw_rate_rad_s"), motion.T, strict=True))
    return {name: values + added[name] if name in added else values for name, values in channels.items()}


def narrow_band(time: np.ndarray, omega: float, damping: float, rms: float, rng: np.random.Generator) -> np.ndarray:
    """Stationary second-order motion and its rate, (N, 2), exactly discretised at the given times."""
    from scipy.linalg import expm

    slope = np.array([[0.0, 1.0], [-(omega**2), -2.0 * damping * omega]])
    stationary = np.diag([rms**2, (rms * omega) ** 2])
    out = np.empty((time.size, 2))
    out[0] = np.sqrt(np.diag(stationary)) * rng.standard_normal(2)
    factors: dict[float, tuple[np.ndarray, np.ndarray]] = {}
    for k, dt in enumerate(np.round(np.diff(time), 9)):
        if dt not in factors:
            phi = np.asarray(expm(slope * dt))
            factors[dt] = phi, np.linalg.cholesky(stationary - phi @ stationary @ phi.T)
        phi, root = factors[dt]
        out[k + 1] = phi @ out[k] + root @ rng.standard_normal(2)
    return out
