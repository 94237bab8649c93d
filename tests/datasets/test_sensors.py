"""Sensors: every effect has the size that was asked for, streams are independent, texts are strict.

Random tests draw a seed and print it. Bounds are 5 standard deviations of the statistic, so that a correct sampler
fails one check in about two million.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from helmbench.datasets.columns import CANONICAL, TWIN
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.randomness import gauss_markov, stream
from helmbench.datasets.record import Record
from helmbench.datasets.sensors import CHANNELS, NOISE, ChannelSensor, SensorSet, apply, parse_noise, runs
from helmbench.models.errors import BadInput

DEG = math.pi / 180.0
N = 40_000
Z = 5.0


def zeros(n: int = N, dt: float = 0.1, names: tuple[str, ...] = ("heading_rad", "yaw_rate_rad_s")) -> Record:
    return Record(dt * np.arange(n), {name: np.zeros(n) for name in names})


def measured(rng: np.random.Generator, n: int = N, true: np.ndarray | None = None, **sensor) -> np.ndarray:
    record = zeros(n) if true is None else zeros(n).with_channels(heading_rad=true)
    return apply(record, SensorSet({"heading_rad": ChannelSensor(**sensor)}), rng).column("heading_rad")


def assert_share(hits: np.ndarray, share: float) -> None:
    assert abs(hits.mean() - share) < Z * math.sqrt(share * (1 - share) / hits.size)


def test_white_noise_has_its_sd_no_mean_and_no_memory(rng):
    x = measured(rng, sd=0.3)
    assert abs(x.mean()) < Z * 0.3 / math.sqrt(N)
    assert abs(x.std() / 0.3 - 1) < Z / math.sqrt(2 * N)
    assert abs(np.mean(x[1:] * x[:-1]) / 0.09) < Z / math.sqrt(N)
    assert abs(np.mean(x**4) / 0.3**4 - 3) < Z * math.sqrt(96 / N)


def test_coloured_noise_has_its_sd_and_correlation_time(rng):
    dt, tau, sd = 0.1, 2.0, 0.5
    x = measured(rng, sd=sd, correlation_s=tau)
    a = math.exp(-dt / tau)
    spread = math.sqrt((1 + a * a) / (1 - a * a))
    assert abs(x.var() / sd**2 - 1) < Z * math.sqrt(2 / N) * spread
    shocks = x[1:] - a * x[:-1]
    assert abs(shocks.std() / (sd * math.sqrt(1 - a * a)) - 1) < Z / math.sqrt(2 * N)
    assert abs(np.mean(shocks * x[:-1])) < Z * shocks.std() * sd / math.sqrt(N)


def test_coloured_process_is_stationary_and_exact_for_unequal_steps(rng):
    time = np.array([0.0, 0.1, 5.0, 5.5])
    draws = np.array([gauss_markov(time, 2.0, 1.0, rng) for _ in range(20_000)])
    expected = 4.0 * np.exp(-np.abs(time[:, None] - time[None, :]))
    bound = Z * np.sqrt((16.0 + expected**2) / len(draws))
    assert np.all(np.abs(draws.T @ draws / len(draws) - expected) < bound)


def test_bias_scale_and_quantum(rng):
    true = np.linspace(-1.0, 1.0, N)
    np.testing.assert_allclose(measured(rng, true=true, bias=0.2, scale=-0.1), 0.9 * true + 0.2, atol=1e-15)
    coarse = measured(rng, true=true, quantum=0.25)
    assert set(coarse) == {k * 0.25 for k in range(-4, 5)}
    assert np.max(np.abs(coarse - true)) <= 0.125


def test_delay_shifts_by_fractions_of_a_sample(rng):
    time = zeros().time_s
    late = measured(rng, true=np.sin(time), delay_s=0.25)
    assert np.max(np.abs(late[3:] - np.sin(time[3:] - 0.25))) < 0.1**2 / 8 * 1.01
    assert np.all(late[:3] == 0.0)


def test_single_outliers_have_share_size_and_both_signs(rng):
    x = measured(rng, outliers=0.05, outlier_size=3.0)
    hit = x != 0.0
    assert_share(hit, 0.05)
    assert np.all((np.abs(x[hit]) >= 3.0) & (np.abs(x[hit]) <= 6.0))
    assert_share(x[hit] > 0, 0.5)
    assert abs(np.abs(x[hit]).mean() - 4.5) < Z * 3 / math.sqrt(12 * hit.sum())


def test_bursts_cover_their_share_in_runs_of_one_sign(rng):
    x = measured(rng, bursts=0.1, burst_samples=25, burst_size=2.0)
    hit = x != 0.0
    assert hit.sum() == 0.1 * N
    edges = np.flatnonzero(np.diff(np.concatenate([[0], hit.astype(int), [0]])))
    lengths = edges[1::2] - edges[::2]
    assert np.all(lengths % 25 == 0)
    alone = [x[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a == 25]
    assert len(alone) > 100 and all(len(set(np.sign(run))) == 1 for run in alone)
    assert_share(np.array([run[0] > 0 for run in alone]), 0.5)


@pytest.mark.parametrize(
    ("n", "share", "length"), [(103, 0.1, 20), (50, 1.0, 7), (5, 0.5, 20), (7, 0.0, 3), (1, 1.0, 1)]
)
def test_runs_keep_within_the_record(rng, n, share, length):
    for _ in range(200):
        number = runs(n, share, length, rng)
        assert number.shape == (n,)
        sizes = np.bincount(number[number >= 0]) if np.any(number >= 0) else np.array([], dtype=int)
        assert np.all(sizes == min(length, n))


def test_the_expected_share_of_runs_is_exact_and_they_fall_anywhere(rng):
    draws = np.array([runs(100, 0.1, 20, rng) >= 0 for _ in range(20_000)])
    assert abs(draws.mean() - 0.1) < Z * math.sqrt(0.25 * 0.04 / len(draws))
    first = np.array([np.argmax(d) for d in draws if d.any()])
    assert abs(first.mean() - 40.0) < Z * math.sqrt((81**2 - 1) / 12 / first.size)


def test_dropout_and_gaps_lose_their_share(rng):
    single = np.isnan(measured(rng, dropout=0.02))
    assert_share(single, 0.02)
    gaps = np.isnan(measured(rng, gaps=0.05, gap_samples=50))
    assert gaps.sum() == 0.05 * N
    edges = np.flatnonzero(np.diff(np.concatenate([[0], gaps.astype(int), [0]])))
    assert np.all((edges[1::2] - edges[::2]) % 50 == 0)


def test_a_slower_channel_has_values_at_its_own_rate_only(rng):
    seen = np.isfinite(measured(rng, period_s=1.0))
    assert np.array_equal(np.flatnonzero(seen), np.arange(0, N, 10))
    uneven = np.isfinite(measured(rng, n=200, period_s=0.25))
    assert np.array_equal(np.flatnonzero(uneven)[:5], [0, 3, 5, 8, 10])


def test_channels_and_effects_draw_from_streams_of_their_own(rng):
    seed = int(rng.integers(2**32))
    sensors = parse_noise("medium,outliers=5%,dropout=2%")
    both = apply(zeros(500), sensors, stream(seed, "x"))
    alone = apply(zeros(500, names=("yaw_rate_rad_s",)), sensors, stream(seed, "x"))
    np.testing.assert_array_equal(both.column("yaw_rate_rad_s"), alone.column("yaw_rate_rad_s"))
    plain = apply(zeros(500), parse_noise("medium"), stream(seed, "x")).column("heading_rad")
    heading = both.column("heading_rad")
    kept = np.isfinite(heading) & (np.abs(heading - plain) < 5 * 0.1 * DEG)
    np.testing.assert_array_equal(heading[kept], plain[kept])
    assert kept.mean() > 0.8
    x, y = (zeros_noise / zeros_noise.std() for zeros_noise in (plain, apply(
        zeros(500), parse_noise("medium"), stream(seed, "x")).column("yaw_rate_rad_s")))  # fmt: skip
    assert abs(np.mean(x * y)) < Z / math.sqrt(500)


def test_applying_twice_with_the_same_generator_state_gives_the_same(rng):
    seed = int(rng.integers(2**32))
    sensors = parse_noise("high,bursts=10%,gaps=5%,colour=3s")
    a, b = (apply(zeros(300), sensors, np.random.default_rng(seed)) for _ in range(2))
    assert a.equals(b)
    assert not a.equals(apply(zeros(300), sensors, np.random.default_rng(seed + 1)))


# ---- texts


def test_levels_order_channels_and_cover_them():
    measured_channels = set(CHANNELS) - {"rudder_command"}
    for level in ("low", "medium", "high"):
        assert set(NOISE[level]) == measured_channels
    for name in measured_channels:
        assert 0.0 < NOISE["low"][name] < NOISE["medium"][name] < NOISE["high"][name]
    without_sensor = {"time_s", "propeller_thrust_N", *TWIN, "current_speed_m_s", "current_direction_rad"}
    assert {column for column, _ in CHANNELS.values()} == set(CANONICAL) - without_sensor


def test_none_changes_nothing_and_a_level_leaves_the_order_alone(rng):
    record = zeros(50, names=("heading_rad", "rudder_command_rad", "rudder_rad"))
    assert apply(record, parse_noise("none"), rng).equals(record)
    noisy = apply(record, parse_noise("high,dropout=50%"), rng)
    assert np.all(noisy.column("rudder_command_rad") == 0.0)
    assert np.isnan(noisy.column("rudder_rad")).any()


@pytest.mark.parametrize(
    ("text", "column", "expected"),
    [
        ("low", "heading_rad", {"sd": 0.02 * DEG}),
        ("yaw_rate=0.05deg_s,heading=0.1deg", "yaw_rate_rad_s", {"sd": 0.05 * DEG}),
        ("surge=0.1kn", "surge_m_s", {"sd": 0.1 * 1852 / 3600}),
        ("propeller=6rpm", "propeller_rps", {"sd": 0.1}),
        ("medium,heading=0.3deg", "heading_rad", {"sd": 0.3 * DEG}),
        ("medium,outliers=5%", "sway_m_s", {"sd": 0.02, "outliers": 0.05, "outlier_size": 0.2}),
        ("medium,sway.outliers=5%/1m_s", "sway_m_s", {"sd": 0.02, "outliers": 0.05, "outlier_size": 1.0}),
        ("outliers=5%/20sd,sway=0.1m_s", "sway_m_s", {"sd": 0.1, "outliers": 0.05, "outlier_size": 2.0}),
        ("low,bursts=10%/30/5sd", "north_m", {"sd": 0.1, "bursts": 0.1, "burst_samples": 30, "burst_size": 0.5}),
        ("none,dropout=2%,gaps=5%/40", "heading_rad", {"dropout": 0.02, "gaps": 0.05, "gap_samples": 40}),
        ("heading.delay=0.5s, heading.bias=-1deg", "heading_rad", {"delay_s": 0.5, "bias": -DEG}),
        ("low,heading.bias=2sd", "heading_rad", {"sd": 0.02 * DEG, "bias": 0.04 * DEG}),
        ("none,scale=-2%,period=1s", "east_m", {"scale": -0.02, "period_s": 1.0}),
        ("low,colour=30s", "roll_rad", {"sd": 0.02 * DEG, "correlation_s": 30.0}),
        ("none,heading.quantum=0.1deg", "heading_rad", {"quantum": 0.1 * DEG}),
        ("rudder_command.delay=1s", "rudder_command_rad", {"delay_s": 1.0}),
    ],
)
def test_texts_are_read(text, column, expected):
    sensor = parse_noise(text).channels[column]
    for key, value in vars(ChannelSensor(**expected)).items():
        assert getattr(sensor, key) == pytest.approx(value, rel=1e-12), key


def test_single_channels_leave_the_others_exact():
    assert set(parse_noise("yaw_rate=0.05deg_s").channels) == {"yaw_rate_rad_s"}
    assert parse_noise("none").channels == {}
    assert parse_noise("none").sd("heading_rad") == 0.0 and parse_noise("low").sd("north_m") == 0.1


@pytest.mark.parametrize(
    "text",
    [
        "", "loud", "low,medium", "heading", "heading=0.1", "heading=0.1m", "heading=-0.1deg", "heading=abcdeg",
        "yaw=0.1deg_s", "heading_rad=0.1rad", "low,outliers=5", "low,outliers=105%", "low,outliers=-1%",
        "none,outliers=5%", "none,colour=3s", "heading.outliers=5%", "low,heading.outliers=5%/3m_s",
        "low,bursts=5%/0", "low,bursts=5%/2.5", "low,bursts=5%/2/3sd/4", "low,delay=-1s", "low,delay=1",
        "low,speed.delay=1s", "low,heading.speed=1", "low,", ",low", "none,quantum=0deg", "heading.period=0s",
        "heading=infdeg", "medium,dropout=nan%", "low=1deg",
    ],
)  # fmt: skip
def test_bad_texts_end_in_one_line_that_shows_the_form(text):
    with pytest.raises(BadInput) as caught:
        parse_noise(text)
    line = str(caught.value)
    assert "\n" not in line and "expected" in line and repr(text) in line


def test_channels_that_nothing_measures_are_taken_out():
    record = generate(Case("mariner", "zigzag:20/20", "low,only=heading+surge", duration_s=20.0))
    assert set(record.channels) == {"rudder_command_rad", "rudder_rad", "heading_rad", "surge_m_s"}
    whole = generate(Case("mariner", "zigzag:20/20", "low", duration_s=20.0))
    other = generate(Case("mariner", "zigzag:20/20", "low,without=surge+sway", duration_s=20.0))
    assert set(whole.channels) - set(other.channels) == {"surge_m_s", "sway_m_s"}
    with pytest.raises(BadInput, match="unknown channel 'speed'"):
        parse_noise("low,only=speed")
