"""Windows of records: starts, gaps, robust fits and errors of blocks that were left out, against closed forms."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from helmbench.datasets.instruments import felt_rudder
from helmbench.datasets.record import Record
from helmbench.diagnosis.craft.problem import DELAY, OWN, SLOWNESS, WindowErrors
from helmbench.diagnosis.craft.windows import MOST, pieces_of, scales_of, windows_of
from helmbench.estimation.selection.minimiser import minimise
from helmbench.estimation.selection.number import Number, distinct
from helmbench.estimation.selection.score import fall
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

GAIN, TIME = 0.2, 5.0


def nomoto(rng, n=900, dt=0.5, noise=0.0, linkage=None):
    """r' = (GAIN d - r)/TIME under a smooth rudder, solved exactly for a rudder that is linear between samples;
    linkage : between what is recorded and what acts."""
    t = dt * np.arange(n)
    rudder = 0.2 * sum(np.sin(w * t + p) for w, p in zip(rng.uniform(0.03, 0.25, 4), rng.uniform(0, 6, 4), strict=True))
    decay = np.exp(-dt / TIME)
    first = 1.0 - TIME / dt * (1.0 - decay)
    r, psi = [0.0], [3.0]
    acting = felt_rudder(t, rudder, linkage or {})
    for a, b in pairwise(acting.tolist()):
        new = decay * r[-1] + GAIN * ((1.0 - decay) * a + first * (b - a))
        psi.append(psi[-1] + 0.5 * dt * GAIN * (a + b) - TIME * (new - r[-1]))
        r.append(new)
    wrapped = np.mod(np.array(psi) + noise * rng.standard_normal(n) + np.pi, 2.0 * np.pi) - np.pi
    channels = {"rudder_rad": rudder, "yaw_rate_rad_s": np.array(r) + 0.2 * noise * rng.standard_normal(n)}
    return Record(t, channels | {"heading_rad": wrapped}, "exact")


def windowed(records, family="nomoto-1"):
    """Windows of a response model whose numbers are all zero, and the craft's units."""
    scales, model = scales_of(records), resolve(family)
    blank = replace(model, coefficients=np.zeros(len(model.coordinates)))
    return windows_of(pieces_of(records, scales), blank, scales), scales


def fitted(records, *more):
    """A fit of a first-order model, and its problem."""
    windows, scales = windowed(records, "nomoto-1+rudder_offset")
    problem, unit = WindowErrors(windows, scales.time_s, 0.1 * windows.motion), 1.0 / scales.time_s
    numbers = [Number("a", 5.0 * unit, high=0.0), Number("b", 5.0 * unit), *more]
    start = {"a": -unit, "b": 0.5 * unit} | {n.name: n.trial for n in more if n.trial}
    return minimise(problem, distinct(numbers), start, problem.no_own), problem


def test_exact_windows_give_the_exact_model_across_north(rng):
    found, problem = fitted([nomoto(rng, noise=1e-4), nomoto(rng, noise=1e-4)])
    assert [found.value(n) for n in "ab"] == pytest.approx([-1.0 / TIME, GAIN / TIME], rel=0.03)
    assert np.nanmax(np.abs(problem.left_out(found))) < 0.05 * problem.windows.motion.max()


def test_a_stretch_that_no_model_explains_counts_little(rng):
    record = nomoto(rng, noise=1e-4)
    rudder = record.column("rudder_rad").copy()
    rudder[300:340] = 1.5
    found, _ = fitted([record.with_channels(rudder_rad=rudder), *(nomoto(rng, noise=1e-4) for _ in range(3))])
    assert [found.value(n) for n in "ab"] == pytest.approx([-1.0 / TIME, GAIN / TIME], rel=0.03)


@pytest.mark.parametrize(
    ("name", "start", "instrument", "value"),
    [(DELAY, 1.0, "rudder_delay", 2.0), (SLOWNESS, 20.0, "rudder_rate_limit", 0.025)],
)
def test_what_stands_between_order_and_hull_is_a_number_like_others(name, start, instrument, value, rng):
    records = [nomoto(rng, noise=1e-4, linkage={instrument: value}) for _ in range(2)]
    found, _ = fitted(records, Number(name, 30.0, low=0.0, trial=start))
    size = found.value(name) if name == DELAY else 1.0 / found.value(name)
    assert size == pytest.approx(value, rel=0.1)


def test_every_record_may_have_a_neutral_angle_of_its_own(rng):
    first, second = (nomoto(rng, noise=1e-4) for _ in range(2))
    shifted = second.with_channels(rudder_rad=second.column("rudder_rad") - 0.02)
    found, _ = fitted([first, shifted], Number(f"{OWN}0", 1.0), Number(f"{OWN}1", 1.0))
    assert [found.value(f"{OWN}{i}") for i in (0, 1)] == pytest.approx([0.0, 0.02], abs=0.002)


def test_records_as_units_leave_a_record_out(rng):
    """A record in which the rudder works half as much as in the others."""
    records = [nomoto(rng, noise=1e-4) for _ in range(3)]
    records.append(records[0].with_channels(rudder_rad=2.0 * records[0].column("rudder_rad")))
    found, problem = fitted(records)
    whole = problem.by_record()
    by_record = minimise(whole, found.numbers, found.point.values, whole.no_own)
    assert len(by_record.without) == 4 and whole.counts.sum() == problem.counts.sum()
    gains = [-each["b"] / each["a"] for each in by_record.without]
    assert gains[3] == pytest.approx(GAIN, rel=0.03) and max(gains[:3]) < 0.97 * GAIN


def test_no_window_reaches_across_a_gap_and_stillness_is_refused(rng):
    record = nomoto(rng)
    kept = np.r_[0:400, 600 : record.n]
    cut = Record(record.time_s[kept], {n: v[kept] for n, v in record.channels.items()}, "cut", record.meta)
    windows, _ = windowed([cut])
    assert np.abs(np.diff(windows.measured[:, :, 1], axis=1)).max() < 0.5
    assert windows.measured.shape[1] == windows.inputs.shape[1] <= MOST + 1
    with pytest.raises(CannotFit, match="never moves"):
        scales_of([record.with_channels(rudder_rad=np.zeros(record.n))])


def test_a_time_at_rest_does_not_count_for_the_speed(rng):
    """Four samples of five at rest, one at 2 m/s: the model's speed is that under way."""
    record = nomoto(rng)
    speed = np.where(np.arange(record.n) % 5 == 0, 2.0, 0.0)
    assert scales_of([record.with_channels(surge_m_s=speed)]).speed == pytest.approx(2.0)


def test_what_no_model_explains_decides_nothing_and_a_turn_that_one_misses_does(rng):
    _, problem = fitted([nomoto(rng, noise=1e-4)])
    windows = problem.windows
    usual = problem.of_size(0.02 * windows.motion)
    error = usual.size * rng.standard_normal(windows.known.shape)
    floor, lost = usual.counts * usual.floor**2, (windows.block == 2)[:, None, None]
    alone = fall(usual.sums(error), usual.sums(0.5 * error), floor)
    assert alone.gain == pytest.approx(2.0 * np.log(2.0), rel=0.1)
    both = [usual.sums(np.where(lost, 5.0 * windows.motion, e)) for e in (error, 0.5 * error)]
    assert 0.0 < fall(*both, floor).gain < alone.gain
    missed = usual.sums(np.where(lost, windows.motion, 0.5 * error))
    assert fall(usual.sums(error), missed, floor).gain < -0.5


def test_waves_that_are_sampled_once_or_twice_a_period_are_no_noise_of_the_sensor(rng):
    record = nomoto(rng)
    waves = 0.05 * np.sin(2.1 * record.time_s + rng.uniform(0.0, 6.0, record.n))
    windows, _ = windowed([record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + waves)])
    assert windows.noise[0] < 0.5 * windows.motion[0] and windows.noise[1] < 1e-3
