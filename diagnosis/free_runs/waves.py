"""Motion in waves, told from the errors of free runs.

A hull hardly answers a rudder within less than the time of one ship length.  Where the errors of the yaw rate have a
sharp peak at such a period, which the heading shows as its integral and the rudder does not have, the ship moves in
waves.  Averaged spectra of pieces under a Hann window, Welch 1967, eq. 16 of docs/mathematics/pieces.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.tails import half_of_mean

if TYPE_CHECKING:
    from .problem import FreeRuns

LONGEST = 0.65
"""Longest period, as a share of the time of one ship length: a slower moment turns the hull, too, and is described as a
force in time."""
FEWEST_SAMPLES = 4.0
"""Samples of the shortest period."""
NEAR, LOWER, PEAK = 1.4, 2.5, 5.0
"""Ratio of frequencies within which a peak lies, ratio to a lower frequency, and power at the peak over that there: of
models that err in calm water it was .04 to 1.3, in waves 16 to 257."""
OF_RUDDER, OF_MOTION = 0.45, 0.7
"""Coherence with the rudder, at most, and of the yaw rate with the heading, at least: in waves they were .04 to .42 and
.88 to .99, in calm water .5 to .97 with the rudder."""


class Spread(NamedTuple):
    """A mean over pieces, and half of its 90 % interval."""

    value: float
    half: float


@dataclass(frozen=True)
class Waves:
    """Motion in waves along one record, None: all: mean frequency, rad/s, and root mean square of the heading, rad."""

    record: str | None
    frequency_rad_s: Spread
    heading_rad: Spread

    @property
    def period_s(self) -> float:
        """Period at which the ship meets the waves, s."""
        return 2.0 * np.pi / self.frequency_rad_s.value

    @property
    def period_interval_s(self) -> tuple[float, float]:
        """The 90 % interval of the period, s."""
        mean, half = self.frequency_rad_s
        return 2.0 * np.pi / (mean + half), 2.0 * np.pi / (mean - half) if half < mean else np.inf

    @property
    def of_states(self) -> dict[str, float]:
        """State -> root mean square of it, rad or rad/s."""
        return {"psi": self.heading_rad.value, "r": self.heading_rad.value * self.frequency_rad_s.value}


class _Spectra(NamedTuple):
    """Frequencies (F,), Hz, of an even grid, and cross spectra (K, F) of K pieces: of errors (s) and the rudder, by
    their names; the sum of one over the grid is a covariance."""

    frequency: np.ndarray
    cross: dict[tuple[str, str], np.ndarray]

    def coherence(self, one: str, other: str, near: np.ndarray) -> float:
        """Coherence of two channels over a band (F,)."""
        across, *own = (
            np.abs(np.sum(self.cross[pair][:, near])) for pair in ((one, other), (one, one), (other, other))
        )
        return float(across / max(np.sqrt(own[0] * own[1]), 1e-300))


def waves_along(runs: FreeRuns, errors: Sequence[np.ndarray]) -> tuple[Waves, ...]:
    """Motion in waves along all records, and along each; none where the errors show none.

    errors : (C, N) of each unit.
    """
    symbols = [s for s in ("r", "psi") if s in runs.symbols]
    spectra = _spectra(runs, errors, symbols) if symbols else None
    if spectra is None:
        return ()
    channel = symbols[0]
    f, each = spectra.frequency, spectra.cross[channel, channel].real
    power = np.mean(each, axis=0)
    step_s = max(u.stretch.record.dt for u in runs.units)
    band = (f > 1.0 / (LONGEST * runs.length_s)) & (f < 1.0 / (FEWEST_SAMPLES * step_s))
    if not band.any():
        return ()
    at = int(np.flatnonzero(band)[np.argmax(power[band])])
    near = (f > f[at] / NEAR) & (f < f[at] * NEAR)
    steep = power[at] > PEAK * np.interp(f[at] / LOWER, f, power)
    moves = channel == "psi" or "psi" not in runs.symbols or spectra.coherence("r", "psi", near) > OF_MOTION
    if not (steep and moves) or spectra.coherence(channel, "rudder", near) > OF_RUDDER:
        return ()
    numbers, omega = np.array([u.number for u in runs.units]), 2.0 * np.pi * f[near]
    of_heading = each[:, near] / (omega**2 if channel == "r" else 1.0)
    variance = np.sum(of_heading, axis=1)
    frequency, rms = of_heading @ omega / np.maximum(variance, 1e-300), np.sqrt(variance)
    own = {None: numbers >= 0, **{name: numbers == number for number, name in runs.record_names.items()}}
    return tuple(Waves(name, _spread(frequency[units]), _spread(rms[units])) for name, units in own.items())


def _spectra(runs: FreeRuns, errors: Sequence[np.ndarray], symbols: Sequence[str]) -> _Spectra | None:
    """Cross spectra of the errors of channels and the rudder with the first channel, and with themselves; None where
    pieces have too few samples."""
    steps, sizes = [u.stretch.record.dt for u in runs.units], [e.shape[1] for e in errors]
    if min(sizes) < 4 * FEWEST_SAMPLES:
        return None
    grid, names = np.linspace(0.0, 0.5 / max(steps), max(sizes) // 2 + 1), (*symbols, "rudder")
    cross = {pair: np.empty((len(errors), grid.size), complex) for n in names for pair in ((symbols[0], n), (n, n))}
    for k, (unit, error, step) in enumerate(zip(runs.units, errors, steps, strict=True)):
        time_s, window = np.arange(sizes[k]) * step, np.hanning(sizes[k])
        rudder = np.interp(time_s, unit.grid_s - unit.grid_s[0], unit.stretch.series.inputs[: len(unit.grid_s), 0])
        values = [*(error[runs.symbols.index(s)] for s in symbols), rudder]
        spectra = dict(zip(names, np.fft.rfft(_without_trend(np.array(values)) * window), strict=True))
        own, scale = np.fft.rfftfreq(sizes[k], step), 2.0 * grid[1] * step / np.sum(window**2)
        for one, other in cross:
            product = scale * spectra[one] * np.conj(spectra[other])
            cross[one, other][k] = np.interp(grid, own, product.real) + 1j * np.interp(grid, own, product.imag)
    return _Spectra(grid, cross)


def _without_trend(values: np.ndarray) -> np.ndarray:
    """Rows (C, N) without their straight lines of least squares."""
    place = np.arange(values.shape[1]) - 0.5 * (values.shape[1] - 1)
    slopes = values @ place / np.sum(place**2)
    return values - values.mean(axis=1, keepdims=True) - slopes[:, None] * place


def _spread(values: np.ndarray) -> Spread:
    """The mean of values (K,), with half of its 90 % interval."""
    mean = float(np.mean(values))
    return Spread(mean, half_of_mean(values) if values.size > 1 else mean)
