"""The rudder chain: each part against its definition, and every pair of parts in simulator, filter and model file."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.instruments import corrected
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.instruments import RUDDER, linkage
from helmbench.models.model import model_to_json, resolve
from helmbench.models.rudder_chain import quieten, run_chain

PARTS = {
    "rudder_effectiveness": -0.15,
    "rudder_offset": 0.01,
    "rudder_delay": 0.73,
    "rudder_backlash": 0.03,
    "rudder_fault": -0.3,
    "rudder_rate_limit": 0.03,
    "rudder_saturation": 0.2,
    "rudder_reversed": 1.0,
}
"""One size of every part; a fault sets in at 80 s."""


def felt(time, rudder, parts=2, noise=1e-12, **values):
    """Times and angles at the hull."""
    out, quiet = np.empty((time.size - 1) * parts + 1), np.empty(time.size)
    quieten(rudder, noise, quiet)
    run_chain(time, rudder, quiet, linkage(values), noise, parts, out)
    return np.linspace(0.0, time[-1], out.size), out


@pytest.fixture
def wiggle(rng):
    time = 0.5 * np.arange(200)
    steps = rng.normal(size=time.size)
    return time, 0.05 * np.convolve(steps, np.ones(10), "same")


def test_rudder_delay_offset_and_effectiveness(wiggle):
    time, rudder = wiggle
    fine, found = felt(time, rudder, rudder_delay=1.3, rudder_offset=0.02, rudder_effectiveness=-0.1)
    assert found == pytest.approx(0.9 * np.interp(fine - 1.3, time, rudder) + 0.02, abs=1e-12)


def test_rudder_fault_sets_in_within_a_step(wiggle):
    time, rudder = wiggle
    fine, found = felt(time, rudder, rudder_fault=-0.4, rudder_fault_time=40.1)
    share = np.clip((fine - 40.1) / 0.5 + 0.5, 0.0, 1.0)
    assert found == pytest.approx((1.0 - 0.4 * share) * np.interp(fine, time, rudder), abs=1e-12)


def test_rudder_limits(wiggle):
    """Against many small steps of the definition: the angle turns at its rate, and stays within the stops."""
    time, rudder = wiggle
    parts = 400
    fine, found = felt(time, rudder, parts, rudder_saturation=0.12, rudder_rate_limit=0.04)
    command, most = np.interp(fine, time, rudder), 0.04 * 0.5 / parts
    limited = [np.clip(command[0], -0.12, 0.12)]
    for value in command[1:]:
        limited.append(np.clip(limited[-1] + np.clip(value - limited[-1], -most, most), -0.12, 0.12))
    assert found == pytest.approx(limited, abs=2.0 * most)


def test_a_play_far_below_the_noise_changes_nothing(wiggle, rng):
    time, rudder = wiggle
    noisy = rudder + 0.01 * rng.normal(size=rudder.size)
    fine, found = felt(time, noisy, noise=0.01, rudder_backlash=1e-7)
    assert found == pytest.approx(np.interp(fine, time, noisy), abs=1e-5)


def test_rudder_backlash(wiggle):
    """Between the samples too."""
    time, rudder = wiggle
    fine, found = felt(time, rudder, parts=4, rudder_backlash=0.03)
    command = np.interp(fine, time, rudder)
    z = [command[0]]
    for value in command[1:]:
        z.append(np.clip(z[-1], value - 0.03, value + 0.03))
    assert found == pytest.approx(z, abs=1e-12)


def test_noise_on_a_held_rudder_is_no_play(rng):
    """The highest noise of a plateau would push the linkage further: as if the play were larger."""
    time = 0.5 * np.arange(4000)
    clean = np.where(np.arange(4000) // 40 % 2 == 0, 0.3, -0.3)
    _, found = felt(time, clean + 1e-3 * rng.normal(size=4000), noise=1e-3, rudder_backlash=0.01)
    held = found[::2].reshape(-1, 40)[1:, 5:]
    assert np.abs(held).mean() == pytest.approx(0.29, abs=1.8e-4)


def test_the_result_does_not_depend_on_the_points_between(wiggle):
    """Each part is solved exactly on a linear piece: with every pair of parts, more points change nothing."""
    time, rudder = wiggle
    for pair in combinations(PARTS, 2):
        values = {name: PARTS[name] for name in pair} | {"rudder_fault_time": 30.0}
        coarse, fine = (felt(time, rudder, parts, **values)[1] for parts in (1, 8))
        assert fine[::8] == pytest.approx(coarse, abs=1e-12), pair


def test_a_rate_limit_meets_a_command_that_turns_within_a_sample():
    """Held at 0, the command falls from 1 to -1 in 1 s, 1/s: they meet at 1/3 after 1/3 s, then the angle follows at
    its rate to -1/3."""
    time, rudder = np.arange(4.0), np.array([0.0, 0.0, 0.0, 0.0])
    rudder[1:3] = 1.0, -1.0
    out = felt(time, rudder, 3, rudder_rate_limit=1.0)[1]
    assert out[3:7] == pytest.approx([1.0, 2.0 / 3.0, 1.0 / 3.0, 0.0], abs=1e-12)


def test_a_gear_at_its_stop_turns_back_as_soon_as_the_order_does():
    """30 degree sine of 20 s, stop 15 degrees, 3 degrees/s: as if the order ended at the stop."""
    degree = np.pi / 180.0
    time = np.arange(0.0, 160.0, 0.02)
    command = 30.0 * degree * np.sin(2.0 * np.pi * time / 20.0)
    ours = felt(time, command, 1, rudder_rate_limit=3.0 * degree, rudder_saturation=15.0 * degree)[1]
    other = felt(time, np.clip(command, -15.0 * degree, 15.0 * degree), 1, rudder_rate_limit=3.0 * degree)[1]
    assert ours == pytest.approx(other, abs=3.0 * 0.02 * degree)  # it turns within a sample
    unstopped = felt(time, command, 1, rudder_rate_limit=3.0 * degree)[1]
    assert np.sqrt(np.mean((ours - np.clip(unstopped, -15.0 * degree, 15.0 * degree)) ** 2)) > degree


@pytest.mark.parametrize("pair", list(combinations(PARTS, 2)), ids="+".join)
def test_simulator_filter_and_model_file_agree(pair, tmp_path):
    """A ship with two effects in her rudder: the simulator's motion, the filter's and that of the reloaded model."""
    instruments = {name: PARTS[name] for name in pair} | ({"rudder_fault_time": 80.0} if "rudder_fault" in pair else {})
    model = replace(resolve("response-2"), instruments=instruments)
    model_to_json(model, tmp_path / "ship.json")
    reloaded = resolve(tmp_path / "ship.json")
    assert dict(reloaded.instruments) == instruments
    case = Case(str(tmp_path / "ship.json"), "zigzag:20/20", duration_s=200.0, dt_s=0.5)
    record = generate(case)
    plain = resolve("response-2")
    est = estimator(plain, [record]).with_corners(0.0)
    setting = est.with_entries(est.start(), {name: instruments[name] for name in instruments if name in RUDDER})
    run = est.free_run(setting, 0, 2)
    channels = {"heading_rad": 0, "yaw_rate_rad_s": 1}
    for name, c in channels.items():
        truth = record.heading_unwrapped() if c == 0 else record.column(name)
        assert run[2:, c] == pytest.approx(truth[2:], abs=2e-3 * np.abs(truth).max()), name
    at_hull = corrected(record, instruments).rudder()
    whole = felt(np.array(record.time_s), np.array(record.rudder()), 1, **instruments)[1]
    assert at_hull == pytest.approx(whole, abs=1e-12)
