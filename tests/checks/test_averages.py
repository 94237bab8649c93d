"""Long records are compared as averages: what they show stays; short or slowly sampled ones are taken as they are."""

import numpy as np
import pytest

from helmbench.checks.check import check, examine
from helmbench.checks.integrity.averages import MOST, averages_of
from helmbench.datasets.record import Record


def voyage(rng, n, step_s=0.2, heading_late_s=0.0, yaw_rate_scale=1.0, turns_in_s=25.0):
    """A record (n samples) that turns to both sides again and again, with noise of usual sensors."""
    time = np.arange(n) * step_s
    phase = 2.0 * np.pi * time / 240.0
    rate = 0.01 * np.tanh(np.sin(phase) * 240.0 / (2.0 * np.pi * turns_in_s))
    heading = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1])) * step_s])
    seen = np.interp(time - heading_late_s, time, heading) + rng.normal(0.0, 0.002, n)
    channels = {
        "rudder_rad": 10.0 * rate,
        "heading_rad": np.mod(seen, 2.0 * np.pi),
        "yaw_rate_rad_s": yaw_rate_scale * rate + rng.normal(0.0, 3e-4, n),
    }
    return Record(time, channels, name="voyage")


def test_a_short_record_is_taken_as_it_is(rng):
    record = voyage(rng, MOST)
    assert averages_of(record) is record


def test_averages_are_means_of_all_samples(rng):
    record = voyage(rng, 4 * MOST + 3)
    mean = averages_of(record)
    count = record.n // mean.n
    assert 2 <= count <= 4 and mean.n == record.n // count
    for name in ("heading_rad", "yaw_rate_rad_s"):
        blocks = record.continuous(name)[: mean.n * count].reshape(-1, count)
        np.testing.assert_allclose(mean.column(name), blocks.mean(axis=1), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(mean.time_s, record.time_s[: mean.n * count].reshape(-1, count).mean(axis=1))


def test_averages_do_not_outlast_the_turning(rng):
    quick = voyage(rng, 3 * MOST, step_s=1.0, turns_in_s=5.0)
    assert averages_of(quick) is quick


def test_a_slowly_sampled_channel_is_not_averages_of(rng):
    record = voyage(rng, 2 * MOST)
    heading = np.where(np.arange(record.n) % 10 == 0, record.column("heading_rad"), np.nan)
    sparse = record.with_channels(heading_rad=heading)
    assert averages_of(sparse) is sparse


def test_no_average_reaches_over_a_gap_in_time(rng):
    record = voyage(rng, 4 * MOST)
    late = np.where(np.arange(record.n) > 1001, record.time_s + 500.0, record.time_s)
    mean = averages_of(Record(late, record.channels, name="gap"))
    lost = np.flatnonzero(np.isnan(mean.column("yaw_rate_rad_s")))
    assert lost.size == 1
    assert late[1001] < mean.time_s[lost[0] + 1] and mean.time_s[lost[0] - 1] < late[1002]


def tracked(rng, n):
    """A voyage with speed and positions."""
    record = voyage(rng, n)
    way = 5.0 * np.exp(1j * record.heading_unwrapped()) * record.dt
    place = np.concatenate([[0.0], np.cumsum(0.5 * (way[1:] + way[:-1]))]) + rng.normal(0.0, 0.3, (2, n)).T @ [1, 1j]
    speed, sway = 5.0 + rng.normal(0.0, 0.05, n), rng.normal(0.0, 0.05, n)
    return record.with_channels(surge_m_s=speed, sway_m_s=sway, north_m=place.real, east_m=place.imag)


DEGREE = np.pi / 180.0
FILES = {
    "degrees": (lambda r: {"heading_rad": r.column("heading_rad") / DEGREE}, "wrong_unit"),
    "radians taken for degrees": (
        lambda r: {name: DEGREE * r.column(name) for name in ("heading_rad", "yaw_rate_rad_s")}, "wrong_unit",
    ),
    "knots": (lambda r: {"surge_m_s": r.column("surge_m_s") * 1.9438}, "wrong_unit"),
    "a rate of the other sign": (lambda r: {"yaw_rate_rad_s": -r.column("yaw_rate_rad_s")}, "channel_sign"),
    "east of the other sign": (lambda r: {"east_m": -r.column("east_m")}, "channel_sign"),
    "positions exchanged": (
        lambda r: {"north_m": r.column("east_m"), "east_m": r.column("north_m")},
        "channel_swap",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fault", FILES)
def test_faults_of_a_long_file_are_those_of_its_samples(rng, monkeypatch, fault):
    change, cause = FILES[fault]
    monkeypatch.setattr("helmbench.checks.integrity.averages.MOST", 3000)
    record = tracked(rng, 15_010)
    record = record.with_channels(**change(record))
    assert averages_of(record) is not record
    means = examine([record]).findings
    monkeypatch.setattr("helmbench.checks.integrity.readings.averages_of", lambda record: record)
    samples = examine([record.with_channels()]).findings
    assert cause in [f.cause for f in samples]
    assert [(f.cause, f.channels) for f in means] == [(f.cause, f.channels) for f in samples]


@pytest.mark.parametrize(
    ("fault", "cause", "size"),
    [
        ({"heading_late_s": 1.0}, "heading_delay", 1.0),
        pytest.param({"yaw_rate_scale": 1.05}, "yaw_rate_scale", 0.05, marks=pytest.mark.nightly),
    ],
)
def test_averages_show_what_all_samples_show(rng, monkeypatch, fault, cause, size):
    record = voyage(rng, 2 * MOST + 10, **fault)
    assert averages_of(record) is not record
    means = check([record]).findings
    monkeypatch.setattr("helmbench.checks.check.averages_of", lambda record: record)
    samples = check([record]).findings
    assert [(f.cause, f.material) for f in means] == [(f.cause, f.material) for f in samples]
    for found in (means, samples):
        assert next(f for f in found if f.cause == cause).sizes[0].value == pytest.approx(size, abs=0.02)
