"""Instruments: what sensors show of a run, and back."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.instruments import (
    behind_play,
    corrected,
    felt_rudder,
    narrow_band,
    observed,
    quietened,
    rudder_noise,
)
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.record import Record, RecordMeta
from helmbench.models.errors import BadInput
from helmbench.models.instruments import INSTRUMENTS, SENSORS, bent, checked, combined, straightened
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, simulate

DEGREE = np.pi / 180.0
STATES = ("surge_m_s", "sway_m_s", "yaw_rate_rad_s", "north_m", "east_m", "heading_rad")


@pytest.fixture(scope="module")
def record():
    return record_run(resolve("mariner"), parse_manoeuvre("zigzag:20/20"), duration_s=300, dt_s=0.5)


def drawn(rng, late=True):
    """Random instruments of every sensor, with delays of whole samples."""
    q = {f"{name}_bias": rng.normal() * 0.1 for name in SENSORS} | {f"{n}_scale": rng.normal() * 0.1 for n in SENSORS}
    q |= {f"{name}_drift": rng.normal() * 1e-3 for name in SENSORS}
    q |= {f"{name}_delay": 0.5 * rng.integers(1, 6) for name in SENSORS} if late else {}
    q |= {"axis_misalignment": rng.normal() * 0.1, "swap_yaw_rate_sway": 1.0, "earth_frame_velocity": 1.0}
    q |= {"surge_curve": rng.uniform(-0.01, 0.02), "point_ahead": rng.normal()}
    return q | {"clock_rate": rng.uniform(-0.1, 0.1), "ship_scale": rng.uniform(-0.5, 2.0)}


def test_corrected_undoes_observed(record, rng):
    q = drawn(rng)
    shown = observed(record, q)
    stretch = (1.0 + q["clock_rate"]) * np.sqrt(1.0 + q["ship_scale"])
    assert np.ptp(shown.time_s) == pytest.approx(stretch * np.ptp(record.time_s))
    back = corrected(shown, q)
    np.testing.assert_allclose(back.time_s, record.time_s, atol=1e-9)
    for name in STATES:
        known = np.isfinite(back.column(name))
        assert known.sum() > 0.95 * record.n, name
        np.testing.assert_allclose(back.column(name)[known], record.column(name)[known], atol=1e-9, rtol=1e-9)


@pytest.mark.parametrize("sd", [0.0, 1e-3])
def test_play_of_the_rudders_sensor_is_undone(sd, rng):
    """A simulated record has it, and behind the model's instruments the rudder is again where it was."""
    play, ideal = 1.5 * DEGREE, resolve("mariner")
    model = replace(ideal, instruments={"rudder_hysteresis": play})
    plain, shown = (
        record_run(m, parse_manoeuvre("zigzag:20/20"), duration_s=300, dt_s=0.5).column("rudder_rad")
        for m in (ideal, model)
    )
    np.testing.assert_array_equal(shown, behind_play(plain, play))
    time_s = 0.5 * np.arange(plain.size)
    back = felt_rudder(time_s, shown + sd * rng.standard_normal(plain.size), model.instruments)
    errors = [float(np.sqrt(np.mean((x - plain) ** 2))) for x in (shown, back)]
    assert errors[0] > 0.9 * play and errors[1] < 0.2 * play


def test_a_late_rudder_column_is_undone():
    """A simulated record has it, and behind the model's instruments the rudder is again where it was."""
    ideal, late_s = resolve("mariner"), 2.5
    model = replace(ideal, instruments={"rudder_sensor_delay": late_s})
    plain, shown = (
        record_run(m, parse_manoeuvre("zigzag:20/20"), duration_s=300, dt_s=0.5).column("rudder_rad")
        for m in (ideal, model)
    )
    np.testing.assert_allclose(shown[5:], plain[:-5], atol=1e-12)
    back = felt_rudder(0.5 * np.arange(plain.size), shown, model.instruments)
    np.testing.assert_allclose(back[:-5], plain[:-5], atol=1e-12)


def test_a_log_of_an_instrument_with_a_curve_reads_more_at_speed():
    speeds = np.array([-4.0, 0.0, 2.0, 8.0])
    shown = bent(speeds, 0.9, 0.02)
    np.testing.assert_allclose(shown, [-3.92, 0.0, 1.88, 8.48])
    np.testing.assert_allclose(straightened(shown, 0.9, 0.02), speeds, atol=1e-12)


@pytest.mark.parametrize("sd", [2e-4, 1e-3, 1e-2])
def test_a_channel_that_was_late_keeps_white_noise(sd, rng):
    """Delays of any part of a step: the error is that of one sample, and independent of the next ones'."""

    def motion(time_s):
        return np.sin(time_s / 12.0) + 0.3 * np.sin(time_s / 5.0 + 1.0)

    time_s, late_s = 0.5 * np.arange(4000), float(rng.uniform(0.0, 2.0))
    print(late_s)
    shown = motion(time_s - late_s) + sd * rng.standard_normal(time_s.size)
    record = Record(time_s, {"yaw_rate_rad_s": shown}, "late", RecordMeta())
    error = corrected(record, {"yaw_rate_delay": late_s}).column("yaw_rate_rad_s") - motion(time_s)
    error = error[np.isfinite(error)] / sd
    assert error.size >= time_s.size - 5
    assert 0.9 < np.sqrt(np.mean(error**2)) < 1.1
    for lag in (1, 2, 3):
        assert abs(np.mean(error[lag:] * error[:-lag])) < 0.1


def test_one_of_the_equations_each(record):
    r = record.column("yaw_rate_rad_s")
    shown = observed(record, {"yaw_rate_bias": 0.01, "yaw_rate_scale": -0.2}).column("yaw_rate_rad_s")
    np.testing.assert_allclose(shown, 0.8 * r + 0.01)
    late = observed(record, {"heading_delay": 1.0}).column("heading_rad")
    np.testing.assert_allclose(late[2:], record.column("heading_rad")[:-2], atol=1e-12)
    earth = observed(record, {"earth_frame_velocity": 1.0})
    moved = np.gradient(record.column("north_m"), record.time_s)
    np.testing.assert_allclose(earth.column("surge_m_s")[5:-5], moved[5:-5], atol=0.02)
    u, v = record.column("surge_m_s"), record.column("sway_m_s")
    turned = observed(record, {"axis_misalignment": 0.1})
    np.testing.assert_allclose(turned.column("surge_m_s"), u * np.cos(0.1) + v * np.sin(0.1))
    np.testing.assert_allclose(turned.column("sway_m_s"), -u * np.sin(0.1) + v * np.cos(0.1))
    swapped = observed(record, {"swap_yaw_rate_roll_rate": 1.0})
    assert not swapped.has("yaw_rate_rad_s") and np.array_equal(swapped.column("roll_rate_rad_s"), r)


def test_without_instruments_a_record_stays_itself(record):
    assert corrected(record, {}) is record and observed(record, {}) is record


def test_the_felt_rudder():
    time = np.arange(0.0, 20.0, 0.5)
    ramp = np.clip(0.1 * (time - 2.0), 0.0, 0.6)
    np.testing.assert_allclose(
        felt_rudder(time, ramp, {"rudder_delay": 1.25})[5:], np.interp(time - 1.25, time, ramp)[5:]
    )
    scaled = felt_rudder(time, ramp, {"rudder_effectiveness": -0.2, "rudder_offset": 0.01, "rudder_reversed": 1.0})
    np.testing.assert_allclose(scaled, -0.8 * ramp + 0.01)
    np.testing.assert_allclose(felt_rudder(time, ramp, {"rudder_saturation": 0.4}), np.minimum(ramp, 0.4))
    slow = felt_rudder(time, ramp, {"rudder_rate_limit": 0.05})
    assert np.diff(slow).max() == pytest.approx(0.025) and slow[-1] == pytest.approx(0.6)
    play = felt_rudder(time, np.concatenate([ramp, ramp[::-1]])[: time.size], {"rudder_backlash": 0.05})
    np.testing.assert_allclose(play, np.maximum(ramp - 0.05, 0.0), atol=1e-12)
    lost = felt_rudder(time, ramp, {"rudder_fault": -0.5, "rudder_fault_time": 10.0})
    np.testing.assert_allclose(lost[time > 10.5], 0.5 * ramp[time > 10.5])
    np.testing.assert_allclose(lost[time < 9.5], ramp[time < 9.5])


def test_play_ignores_the_sensors_noise(rng):
    time = np.arange(0.0, 300.0, 0.5)
    still = np.full(time.size, 0.2) + 0.1 * np.sign(np.sin(0.05 * time))
    noise = 0.05 * DEGREE
    noisy = still + noise * rng.normal(size=time.size)
    assert np.std(quietened(noisy, rudder_noise(noisy)) - still) < 0.5 * noise
    felt, true = (felt_rudder(time, series, {"rudder_backlash": 0.02}) for series in (noisy, still))
    error = np.abs(felt - true)
    assert error[0] < 5.0 * noise and np.max(error[1:]) < noise  # the first sample stands until the first order
    off = noisy.copy()
    off[[200, 400]] += np.array([6.0, -6.0]) * noise  # lone samples would be held until the next order
    assert np.max(np.abs(felt_rudder(time, off, {"rudder_backlash": 0.02}) - felt)) < noise


def test_a_quiet_rudder_keeps_its_steps(rng):
    clean = np.where(np.arange(400) < 200, 0.0, 1.0)
    assert np.std(quietened(clean + 0.01 * rng.normal(size=400), 0.01) - clean) < 0.5 * 0.01


def test_a_gap_in_the_rudder_stays_one():
    time, rudder = np.arange(20.0), np.linspace(0.0, 0.3, 20)
    rudder[7] = np.nan
    felt = felt_rudder(time, rudder, {"rudder_offset": 0.1})
    assert np.flatnonzero(np.isnan(felt)).tolist() == [7]


@pytest.mark.parametrize("vessel", ["mariner", "kvlcc2-l7", "response-1"])
def test_a_corrected_record_is_what_the_hull_did(vessel):
    """The hull behind the linkage: the simulation with the felt rudder repeats the recorded run.

    The linkage may turn or stop the rudder between two samples; the felt rudder is linear between them.
    """
    model = resolve(vessel)
    linkage = {"rudder_delay": 1.3, "rudder_backlash": 0.02, "rudder_offset": 0.01, "rudder_saturation": 0.25}
    sensors = {"yaw_rate_bias": 0.001, "heading_scale": 0.02}
    behind = replace(model, instruments=linkage | sensors)
    shown = record_run(behind, parse_manoeuvre("zigzag:20/20"), duration_s=200, dt_s=0.5)
    assert np.max(np.abs(shown.column("rudder_rad"))) == pytest.approx(20 * DEGREE)
    true = corrected(shown, behind.instruments)
    inputs = np.column_stack([true.rudder()] + [np.full(true.n, model.n0_rps)] * (len(model.inputs) - 1))
    run = simulate(model, inputs, 0.5, initial_state(model))
    for name, state in (("yaw_rate_rad_s", "r"), ("heading_rad", "psi")):
        error = true.column(name) - run[:, model.states.index(state)]
        assert np.sqrt(np.mean(error**2)) < 5e-3 * np.std(true.column(name))


def test_waves_rock_heading_and_yaw_rate(record, rng):
    q = {"wave_rms": 0.02, "wave_frequency": 0.7, "wave_damping": 0.1}
    rocked = observed(record, q, rng)
    assert np.std(rocked.column("heading_rad") - record.column("heading_rad")) > 0.005
    assert observed(record, q).equals(record)
    motion = narrow_band(0.5 * np.arange(40_000), 0.7, 0.1, 0.02, rng)
    assert np.std(motion[:, 0]) == pytest.approx(0.02, rel=0.15)
    np.testing.assert_allclose(np.std(motion[:, 1]), 0.7 * 0.02, rtol=0.15)


def test_instruments_in_turn_are_combined(record, rng):
    first = {f"{name}_{kind}": rng.normal() * 0.1 for name in SENSORS for kind in ("bias", "scale")}
    second = {f"{name}_{kind}": rng.normal() * 0.1 for name in SENSORS for kind in ("bias", "scale")}
    twice, once = observed(observed(record, second), first), observed(record, combined(first, second))
    for name in STATES:
        np.testing.assert_allclose(once.column(name), twice.column(name), rtol=1e-12, atol=1e-15)
    assert combined({"rudder_delay": 1.0, "rudder_saturation": 0.3}, {"rudder_delay": 0.5}) == {
        "rudder_delay": 1.5,
        "rudder_saturation": 0.3,
    }
    assert combined({"earth_frame_velocity": 1.0}, {"earth_frame_velocity": 1.0}) == {}


def test_wrong_instruments_are_refused(record):
    with pytest.raises(BadInput, match="unknown instrument 'gyro'"):
        observed(record, {"gyro": 1.0})
    with pytest.raises(BadInput, match="need the heading"):
        corrected(record.with_channels(heading_rad=None), {"earth_frame_velocity": 1.0})
    with pytest.raises(BadInput, match="finite"):
        checked({"rudder_delay": float("nan")})
    assert all(INSTRUMENTS.values())


def test_a_similar_ship_sails_its_length_in_a_froude_time(record):
    """Four times as long: twice as fast, half the rates, four times the way; headings stay."""
    large = observed(record, {"ship_scale": 3.0})
    for name, factor in (("surge_m_s", 2.0), ("yaw_rate_rad_s", 0.5), ("east_m", 4.0), ("heading_rad", 1.0)):
        np.testing.assert_allclose(large.column(name), factor * record.column(name), rtol=1e-12)
    np.testing.assert_allclose(large.time_s, 2.0 * record.time_s)
    turning = large.with_channels(propeller_rps=np.full(record.n, 1.5))
    assert corrected(turning, {"ship_scale": 3.0}).column("propeller_rps") == pytest.approx(3.0)
