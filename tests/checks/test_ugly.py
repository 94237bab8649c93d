"""Records that no computation likes: a check says what it can, and never raises."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.check import check, examine
from helmbench.datasets import generator
from helmbench.datasets.record import Record

from ..seeds import seed_of

SENSED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")


def frozen(record, rng):
    values = record.column(name := str(rng.choice(SENSED))).copy()
    start = int(rng.integers(100, record.n - 100))
    values[start : start + 60] = values[start]
    return record.with_channels(**{name: values}), "frozen_samples", name


def spliced(record, rng):
    """Two pieces of a record joined: the place is another."""
    k = record.n // 2
    moved = {name: record.column(name).copy() for name in ("north_m", "east_m")}
    for values in moved.values():
        values[k:] += 200.0
    return record.with_channels(**moved), "splice", "north_m"


def turned_suddenly(record, rng):
    values = record.heading_unwrapped().copy()
    values[record.n // 3 :] += 0.6
    return record.with_channels(heading_rad=values), "splice", "heading_rad"


def heading_in_degrees(record, rng):
    return record.with_channels(heading_rad=np.rad2deg(record.heading_unwrapped())), "wrong_unit", "heading_rad"


def rate_in_degrees(record, rng):
    degrees = np.rad2deg(record.column("yaw_rate_rad_s"))
    return record.with_channels(yaw_rate_rad_s=degrees), "wrong_unit", "yaw_rate_rad_s"


def in_knots(record, rng):
    knots = {name: record.column(name) * 3600.0 / 1852.0 for name in ("surge_m_s", "sway_m_s")}
    return record.with_channels(**knots), "wrong_unit", "surge_m_s"


def rudder_in_degrees(record, rng):
    return record.with_channels(rudder_rad=np.rad2deg(record.rudder())), "wrong_unit", "rudder_rad"


def rate_of_other_sign(record, rng):
    return record.with_channels(yaw_rate_rad_s=-record.column("yaw_rate_rad_s")), "channel_sign", "yaw_rate_rad_s"


def positions_exchanged(record, rng):
    swap = {"north_m": record.column("east_m"), "east_m": record.column("north_m")}
    return record.with_channels(**swap), "channel_swap", "north_m"


def rate_from_heading(record, rng):
    rate = np.gradient(record.heading_unwrapped(), record.time_s)
    return record.with_channels(yaw_rate_rad_s=rate), "derived_channel", "yaw_rate_rad_s"


def rudder_from_gyro(record, rng):
    rudder = record.rudder() + 3.0 * (record.column("yaw_rate_rad_s") - np.mean(record.column("yaw_rate_rad_s")))
    return record.with_channels(rudder_rad=rudder), "rudder_from_sensor", "rudder_rad"


def coarse(record, rng):
    step = 0.3 * np.nanstd(record.column("yaw_rate_rad_s"))
    return (
        record.with_channels(yaw_rate_rad_s=step * np.round(record.column("yaw_rate_rad_s") / step)),
        "coarse_channel",
        "yaw_rate_rad_s",
    )


def rows_missing(record, rng):
    keep = np.ones(record.n, bool)
    keep[200:260] = keep[400:420] = False
    return Record(record.time_s[keep], {k: v[keep] for k, v in record.channels.items()}, "gap"), "time_stamps", "time_s"


def late_stamps(record, rng):
    time = record.time_s.copy()
    time[50::97] += 0.4 * record.dt
    return Record(time, record.channels, "late"), "time_stamps", "time_s"


def dead(record, rng):
    name = str(rng.choice(SENSED))
    return record.with_channels(**{name: np.full(record.n, 0.25)}), "constant_channel", name


def with_outliers(record, rng):
    values = record.column("surge_m_s").copy()
    values[rng.choice(record.n, 8, replace=False)] += 5.0
    return record.with_channels(surge_m_s=values), "outliers", "surge_m_s"


FAULTS = (
    frozen, spliced, turned_suddenly, heading_in_degrees, rate_in_degrees, in_knots, rudder_in_degrees,
    rate_of_other_sign, positions_exchanged, rate_from_heading, rudder_from_gyro, coarse, rows_missing, late_stamps,
    dead, with_outliers,
)  # fmt: skip


@pytest.fixture(scope="module")
def records():
    """Three records of a large ship with noise."""
    return inject(FaultCase("mariner", (), wrap=False), np.random.default_rng(seed_of("a large ship"))).train


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.__name__)
def test_a_fault_of_the_file_is_named_with_its_column(fault, records, rng):
    spoilt, cause, column = fault(records[1], rng)
    found = check([spoilt]).findings
    print([(f.cause, f.channels, f.evidence) for f in found])
    assert any(f.cause == cause and column in f.channels for f in found)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.__name__)
def test_a_spoilt_record_among_good_ones_raises_nothing(fault, records, rng):
    spoilt, cause, _ = fault(records[1], rng)
    found = check([records[0], spoilt, records[2]])
    assert any(f.cause == cause for f in found.findings)
    assert all(np.isfinite([s.value, s.low, s.high]).all() for f in found.findings for s in f.sizes)


@pytest.mark.parametrize("n", [1, 2, 3, 5, 11, 30, 61])
def test_short_records(n, records):
    found = check([r.slice(0, n) for r in records])
    assert [f.cause for f in found.findings if f.stage == "sensors" and f.material] == []


@pytest.mark.parametrize("name", ["rudder_rad", *SENSED])
def test_a_single_channel(name, records):
    found = check([Record(r.time_s, {name: r.column(name)}, r.name) for r in records])
    assert not [f for f in found.findings if f.material] and found.not_checked
    assert all(len(why.split()) > 4 for why in found.not_checked)


@pytest.mark.parametrize("missing", SENSED)
def test_one_channel_less(missing, records):
    found = check([r.with_channels(**{missing: None}) for r in records])
    assert not [f for f in found.findings if f.material] and any(missing in why for why in found.not_checked)


@pytest.mark.parametrize("value", [0.0, 1e300, -1e300, 1e-300])
@pytest.mark.parametrize("name", ["heading_rad", "surge_m_s", "north_m"])
def test_absurd_constants(name, value, records):
    found = check([r.with_channels(**{name: np.full(r.n, value)}) for r in records])
    assert any(f.cause == "constant_channel" and name in f.channels for f in found.findings)


@pytest.mark.parametrize("share", [0.3, 0.9, 0.999, 1.0])
def test_hardly_any_samples(share, records, rng):
    def holed(values):
        return np.where(rng.random(values.size) < share, np.nan, values)

    found = check([r.with_channels(**{name: holed(r.column(name)) for name in SENSED}) for r in records])
    assert not [f for f in found.findings if f.stage == "sensors" and f.material]


@pytest.mark.parametrize("k", range(20))
def test_nonsense(k, rng):
    """Random numbers of any size, repeated, sorted, mixed."""
    n = int(rng.integers(5, 400))
    time = np.cumsum(rng.exponential(1.0, n) + 1e-9)
    kinds = (
        lambda: rng.standard_cauchy(n) * 10.0 ** rng.uniform(-12, 12),
        lambda: np.repeat(rng.normal(size=n // 5 + 1), 5)[:n],
        lambda: np.sort(rng.normal(size=n)),
        lambda: rng.choice([0.0, 1.0, np.nan], n),
    )
    names = [*SENSED, "rudder_rad"]
    channels = {name: kinds[int(rng.integers(4))]() for name in names if rng.random() < 0.8}
    found = check([Record(time, channels, f"nonsense {k}"), Record(time, channels, f"nonsense {k}")])
    found.to_json()


def test_records_of_the_same_name_stay_apart(records):
    found = check([records[0], records[0]])
    assert len(set(found.records)) == 2


def test_no_record_is_no_finding():
    assert check([]).findings == ()


def test_a_noisy_channel_that_stands_still_without_a_jump_is_frozen_and_a_motion_at_rest_is_not(rng):
    time = np.arange(600) * 0.5
    noisy = 0.01 * rng.standard_normal(time.size)
    noisy[300] = noisy[299] + 1e-6
    noisy[300:340] = noisy[300]
    noisy[340] = noisy[339] + 1e-6
    smooth = 1e-6 * (np.minimum(time - 150.0, 0.0) ** 3 + np.maximum(time - 170.0, 0.0) ** 3)
    for values, causes in ((noisy, {"frozen_samples"}), (smooth, set())):
        found = check([Record(time, {"surge_m_s": 7.0 + values}, "run")]).findings
        assert {f.cause for f in found} & {"frozen_samples"} == causes


def test_angles_taken_for_degrees_are_told_where_the_heading_wraps(rng):
    """A heading of 0 to 2 pi that was converted once more jumps by 2 pi of a degree, once each turn."""
    record = generator.generate(
        generator.Case("mariner", "turn:25", "low", seed=int(rng.integers(2**31)), duration_s=900.0)
    )
    wrapped = record.with_channels(heading_rad=np.mod(record.heading_unwrapped(), 2.0 * np.pi))
    angles = ("rudder_rad", "rudder_command_rad", "heading_rad", "yaw_rate_rad_s")
    small = wrapped.with_channels(**{n: np.deg2rad(wrapped.column(n)) for n in angles if wrapped.has(n)})
    assert np.abs(np.diff(small.column("heading_rad"))).max() > 0.1
    (found,) = (f for f in check([small]).findings if f.cause == "wrong_unit" and "heading_rad" in f.channels)
    assert found.standing and "heading_rad in another unit" in found.evidence


def test_a_record_that_is_torn_says_nothing_of_its_channels(rng):
    record = generator.generate(
        generator.Case("kvlcc2-l7", "turn:35", "low", seed=int(rng.integers(2**31)), duration_s=300.0)
    )
    share = (record.time_s - record.time_s[0]) / np.ptp(record.time_s)
    rows = np.flatnonzero((share < 0.3) | (share > 0.7))
    torn = replace(record, time_s=record.time_s[rows], channels={n: v[rows] for n, v in record.channels.items()})
    torn = torn.with_channels(surge_m_s=3.6 * torn.column("surge_m_s"))
    (found,) = check([torn]).findings
    assert found.cause == "time_stamps" and found.standing


@pytest.mark.parametrize("positions", [True, False])
def test_a_compass_that_was_reset_is_followed_on_across_its_jump(positions, rng):
    """The heading after the jump is what the rate gives; the jump is told and is none in the record that is used."""
    record = generator.generate(
        generator.Case("mariner", "zigzag:20/20", "low", seed=int(rng.integers(2**31)), duration_s=400.0)
    )
    kept = {n: v for n, v in record.channels.items() if positions or n not in ("north_m", "east_m")}
    heading, k = record.heading_unwrapped(), int(rng.integers(100, record.n - 100))
    away = np.where(np.arange(record.n) < k, 0.0, 0.1)
    whole = replace(record, channels=kept)
    turned = heading + away
    if positions:  # the place follows the heading that the ship has
        way = (record.column("surge_m_s") + 1j * record.column("sway_m_s")) * np.exp(1j * heading)
        place = np.concatenate([[0.0], np.cumsum(0.5 * (way[1:] + way[:-1]) * np.diff(record.time_s))])
        whole = whole.with_channels(north_m=place.real, east_m=place.imag)
    done = examine([whole.with_channels(heading_rad=turned)])
    (found,) = (f for f in done.findings if f.cause == "splice")
    assert found.channels == ("heading_rad",) and found.corrected and not found.standing
    left = done.records[0].heading_unwrapped() - heading
    assert np.nanmax(np.abs(left - left[0])) < 0.01


@pytest.mark.parametrize("carried", [True, False])
def test_velocities_made_with_a_compass_that_was_reset_are_turned_back_with_it(carried, rng):
    """A log of its own is left as it is; so is a position that jumps by a second of way in the same row."""
    record = generator.generate(
        generator.Case("mariner", "zigzag:20/20", "low", seed=int(rng.integers(2**31)), duration_s=400.0)
    )
    k, angle = int(rng.integers(100, record.n - 100)), float(rng.choice([-0.12, 0.12]))
    later = np.arange(record.n) >= k
    velocity = record.column("surge_m_s") + 1j * record.column("sway_m_s")
    place = np.concatenate([[0.0], np.cumsum(velocity * np.exp(1j * record.heading_unwrapped()))[:-1]])
    place *= record.time_s[1] - record.time_s[0]
    shown = velocity * np.exp(-1j * angle * later) if carried else velocity
    changed = record.with_channels(
        heading_rad=record.heading_unwrapped() + angle * later, surge_m_s=shown.real, sway_m_s=shown.imag,
        north_m=place.real + 8.0 * later, east_m=place.imag,
    )  # fmt: skip
    done = examine([changed])
    (found,) = (f for f in done.findings if f.cause == "splice" and f.channels == ("heading_rad",))
    assert found.corrected and not found.standing
    left = done.records[0].column("surge_m_s") + 1j * done.records[0].column("sway_m_s") - velocity
    assert np.nanmax(np.abs(left)) < 0.02 * abs(angle) * np.abs(velocity).mean()


def test_a_heading_that_lags_and_catches_up_is_left_where_it_is(rng):
    record = generator.generate(
        generator.Case("mariner", "turn:20", "low", seed=int(rng.integers(2**31)), duration_s=400.0)
    )
    heading, k = record.heading_unwrapped().copy(), int(rng.integers(150, record.n - 150))
    heading[k - 30 : k] = np.linspace(heading[k - 30], heading[k] - 0.1, 30)
    done = examine([record.with_channels(heading_rad=heading)])
    assert [f for f in done.findings if f.cause == "splice" and not f.standing]
    assert np.abs(done.records[0].heading_unwrapped()[-1] - heading[-1]) < 1e-9
