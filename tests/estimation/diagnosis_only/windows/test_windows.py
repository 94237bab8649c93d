"""Windows of records: starts, gaps, robust fits and errors of blocks that were left out, against closed forms."""

from itertools import pairwise

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.estimation.diagnosis_only.windows.fit import Number, fall, fit, left_out_errors
from helmbench.estimation.diagnosis_only.windows.problem import MOST, pieces_of, scales_of, windows_of
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

GAIN, TIME = 0.2, 5.0


def nomoto(rng, n=900, dt=0.5, noise=0.0):
    """r' = (GAIN d - r)/TIME under a smooth rudder, solved exactly for a rudder that is linear between samples."""
    t = dt * np.arange(n)
    rudder = 0.2 * sum(np.sin(w * t + p) for w, p in zip(rng.uniform(0.03, 0.25, 4), rng.uniform(0, 6, 4), strict=True))
    decay = np.exp(-dt / TIME)
    first = 1.0 - TIME / dt * (1.0 - decay)
    r, psi = [0.0], [3.0]
    for a, b in pairwise(rudder.tolist()):
        new = decay * r[-1] + GAIN * ((1.0 - decay) * a + first * (b - a))
        psi.append(psi[-1] + 0.5 * dt * GAIN * (a + b) - TIME * (new - r[-1]))
        r.append(new)
    wrapped = np.mod(np.array(psi) + noise * rng.standard_normal(n) + np.pi, 2.0 * np.pi) - np.pi
    channels = {"rudder_rad": rudder, "yaw_rate_rad_s": np.array(r) + 0.2 * noise * rng.standard_normal(n)}
    return Record(t, channels | {"heading_rad": wrapped}, "exact")


def windowed(records):
    """Windows of a first-order response model, its numbers, and the craft's units."""
    scales = scales_of(records)
    windows = windows_of(pieces_of(records, scales), resolve("nomoto-1"), scales)
    unit = 1.0 / scales.time_s
    return windows, [Number("a", 0, -unit, 5.0 * unit), Number("b", 1, 0.0, 5.0 * unit)], scales


def fitted(records):
    """The fit, the windows and the craft's units."""
    windows, numbers, scales = windowed(records)
    start = np.array([-1.0 / scales.time_s, 0.5 / scales.time_s])
    return fit(windows, numbers, start, scales.time_s, 0.01), windows, scales


def test_exact_windows_give_the_exact_model_across_north(rng):
    found, windows, _ = fitted([nomoto(rng, noise=1e-4), nomoto(rng, noise=1e-4)])
    assert found.coefficients == pytest.approx([-1.0 / TIME, GAIN / TIME], rel=0.03)
    assert np.nanmax(np.abs(left_out_errors(found))) < 0.05 * windows.motion.max()


def test_a_stretch_that_no_model_explains_counts_little(rng):
    record = nomoto(rng, noise=1e-4)
    rudder = record.column("rudder_rad").copy()
    rudder[300:340] = 1.5
    found, _, _ = fitted([record.with_channels(rudder_rad=rudder), *(nomoto(rng, noise=1e-4) for _ in range(3))])
    assert found.coefficients == pytest.approx([-1.0 / TIME, GAIN / TIME], rel=0.03)


def test_no_window_reaches_across_a_gap_and_stillness_is_refused(rng):
    record = nomoto(rng)
    kept = np.r_[0:400, 600 : record.n]
    cut = Record(record.time_s[kept], {n: v[kept] for n, v in record.channels.items()}, "cut", record.meta)
    windows, _, _ = windowed([cut])
    assert np.abs(np.diff(windows.measured[:, :, 1], axis=1)).max() < 0.5
    assert windows.measured.shape[1] == windows.inputs.shape[1] <= MOST + 1
    with pytest.raises(CannotFit, match="never moves"):
        scales_of([record.with_channels(rudder_rad=np.zeros(record.n))])


def test_a_time_at_rest_does_not_count_for_the_speed(rng):
    """Four samples of five at rest, one at 2 m/s: the model's speed is that under way."""
    record = nomoto(rng)
    speed = np.where(np.arange(record.n) % 5 == 0, 2.0, 0.0)
    assert scales_of([record.with_channels(surge_m_s=speed)]).speed == pytest.approx(2.0)


def test_the_fall_of_errors_is_the_logarithm_of_their_ratio(rng):
    _, windows, _ = fitted([nomoto(rng, noise=1e-4)])
    error = rng.standard_normal((2 * len(windows.inputs), windows.inputs.shape[1], 2)) * windows.motion
    gain, spread = fall(error, 0.5 * error, windows, 100.0 * windows.motion)
    assert gain == pytest.approx(np.log(2.0), abs=1e-3) and spread < 1e-3


def test_what_no_model_explains_decides_nothing_and_a_turn_that_one_misses_does(rng):
    _, windows, _ = fitted([nomoto(rng, noise=1e-4)])
    shape = (2 * len(windows.inputs), windows.inputs.shape[1], 2)
    sizes = 0.02 * windows.motion
    error = sizes * rng.standard_normal(shape)
    lost = windows.block == 2
    stretch = np.concatenate([lost, lost])[:, None, None]
    both = [np.where(stretch, 5.0 * windows.motion, e) for e in (error, 0.5 * error)]
    alone = fall(error, 0.5 * error, windows, sizes)
    assert 0.0 < fall(*both, windows, sizes).gain < alone.gain
    missed = np.where(stretch, windows.motion, 0.5 * error)
    assert fall(error, missed, windows, sizes).gain < -0.5


def test_waves_that_are_sampled_once_or_twice_a_period_are_no_noise_of_the_sensor(rng):
    record = nomoto(rng)
    waves = 0.05 * np.sin(2.1 * record.time_s + rng.uniform(0.0, 6.0, record.n))
    windows, _, _ = windowed([record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + waves)])
    assert windows.noise[0] < 0.5 * windows.motion[0] and windows.noise[1] < 1e-3
