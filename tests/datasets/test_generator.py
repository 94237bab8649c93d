"""The generator: exact repetition by `simulate`, one record per case whatever else happens, clear refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate, record_run, suggested
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import ChannelSensor, SensorSet
from helmbench.models.errors import BadInput
from helmbench.models.model import CHANNELS, list_vessels, resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate


@pytest.mark.parametrize("suffix", ["", "@euler"])
@pytest.mark.parametrize("vessel", list_vessels())
def test_calm_noise_free_records_are_repeated_by_simulate_from_their_rudder(vessel, suffix, seed):
    model = resolve(vessel)
    for text in [*model.suite["train"], *model.suite["held_out"]]:
        text = text.removesuffix("@euler") + suffix
        record = generate(Case(vessel, text, seed=seed))
        inputs = inputs_of(model, record.column("rudder_rad"))
        integrator = "euler" if suffix else "rk4"
        states = simulate(model, inputs, model.suite["dt_s"], initial_state(model), integrator=integrator)
        for i, state in enumerate(model.states):
            if state in CHANNELS:
                np.testing.assert_allclose(record.column(CHANNELS[state]), states[:, i], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("vessel", list_vessels())
def test_records_hold_the_channels_metadata_and_sampling_of_the_vessel(vessel):
    model = resolve(vessel)
    record = generate(Case(vessel, model.suite["train"][0]))
    assert record.has("rudder_command_rad", "rudder_rad", "heading_rad", "yaw_rate_rad_s")
    assert record.has("surge_m_s", "sway_m_s", "north_m", "east_m") == model.is_3dof
    assert record.has("propeller_rps") == ("n" in model.inputs)
    assert record.dt == pytest.approx(model.suite["dt_s"])
    assert record.time_s[-1] == pytest.approx(model.suite["duration_s"], abs=model.suite["dt_s"])
    assert (record.meta.vessel, record.meta.positive_rudder) == (vessel, model.positive_rudder)
    assert record.meta.manoeuvre == parse_manoeuvre(model.suite["train"][0]).text
    assert np.max(np.abs(record.column("rudder_rad"))) <= model.rudder.max_rad + 1e-12
    rate = np.abs(np.diff(record.column("rudder_rad"))) / record.dt
    assert np.max(rate) <= model.rudder.rate_rad_s * (1 + 1e-9)


CASES = [
    Case("s175", "prbs:30deg/25s", "medium,outliers=5%,gaps=3%", "wind:10@30+waves:2/8@60", duration_s=120.0),
    Case("s175", "prbs:30deg/25s", "medium", "wind:10@30", duration_s=120.0),
    Case("mariner", "steps:30deg/20s", "high", duration_s=100.0, dt_s=1.0),
    Case("remus-kt", "zigzag:20/20", "low", "waves:0.1/2@10"),
]


def test_a_case_gives_the_same_record_whatever_was_generated_before(seed):
    cases = [replace(c, seed=seed + i) for i in range(2) for c in CASES]
    forward = [generate(c) for c in cases]
    backward = [generate(c) for c in reversed(cases)][::-1]
    assert all(a.equals(b) for a, b in zip(forward, backward, strict=True))
    np.random.default_rng(seed).random(10)
    assert generate(cases[3]).equals(forward[3])


def test_seeds_vessels_and_texts_make_different_noise(seed):
    base = Case("mariner", "zigzag:20/20", "medium", seed=seed, duration_s=50.0)
    calm = generate(replace(base, noise="none")).column("heading_rad")
    noise = [generate(c).column("heading_rad") - calm for c in (
        base, replace(base, seed=seed + 1), replace(base, noise="medium,dropout=1%"),
    )]  # fmt: skip
    for a, b in ((0, 1), (0, 2), (1, 2)):
        assert np.nanmax(np.abs(noise[a] - noise[b])) > 1e-4


def test_noise_and_disturbance_leave_the_run_that_they_disturb_alone(seed):
    clean = Case("s175", "prbs:30deg/25s", seed=seed, duration_s=200.0)
    noisy = generate(replace(clean, noise="high"))
    windy = generate(replace(clean, disturbance="wind:12@40"))
    np.testing.assert_array_equal(noisy.column("rudder_command_rad"), generate(clean).column("rudder_command_rad"))
    np.testing.assert_array_equal(windy.column("rudder_command_rad"), generate(clean).column("rudder_command_rad"))
    low, high = (generate(replace(clean, disturbance="wind:12@40", noise=n)) for n in ("low", "none"))
    np.testing.assert_allclose(low.column("heading_rad"), high.column("heading_rad"), atol=6 * np.deg2rad(0.02))
    assert not np.array_equal(generate(replace(clean, seed=seed + 1)).column("rudder_rad"), noisy.column("rudder_rad"))


def test_a_channels_noise_does_not_depend_on_the_other_sensors(seed):
    model = resolve("s175")
    heading = ChannelSensor(sd=1e-3)
    one, two = (
        record_run(model, parse_manoeuvre("zigzag:20/20"), SensorSet(channels, "mine"), seed=seed, duration_s=60.0)
        for channels in ({"heading_rad": heading}, {"yaw_rate_rad_s": ChannelSensor(sd=0.1), "heading_rad": heading})
    )
    np.testing.assert_array_equal(one.column("heading_rad"), two.column("heading_rad"))


def test_euler_records_obey_the_difference_equation():
    record = generate(Case("response-1", "zigzag:20/20@euler"))
    model = resolve("response-1")
    r, delta, dt = record.column("yaw_rate_rad_s"), record.column("rudder_rad"), record.dt
    p = model.parameters
    rate = (p["K"] * delta - r - p["alpha"] * r**3) / p["T"]
    np.testing.assert_allclose(r[1:], r[:-1] + dt * rate[:-1], atol=1e-14)
    np.testing.assert_allclose(np.diff(record.column("heading_rad")), dt * r[:-1], atol=1e-14)


def test_twins_differ_in_the_integrator_only(seed):
    exact, euler = (generate(Case("s175", "prbs:20deg/20s" + x, seed=seed, duration_s=100.0)) for x in ("", "@euler"))
    np.testing.assert_array_equal(exact.column("rudder_rad"), euler.column("rudder_rad"))
    gap = np.abs(exact.column("heading_rad") - euler.column("heading_rad"))
    assert 1e-6 < gap.max() < 0.1


@pytest.mark.parametrize(
    ("case", "said"),
    [
        (Case("titanic", "zigzag:20/20"), "titanic"),
        (Case("nomoto-1", "zigzag:20/20"), "no coefficients"),
        (Case("s175", "zigzag:20"), "zigzag"),
        (Case("s175", "zigzag:20/20", noise="loud"), "loud"),
        (Case("s175", "zigzag:20/20", disturbance="storm"), "storm"),
        (Case("s175", "zigzag:20/20", seed=-1), "seed"),
        (Case("s175", "zigzag:20/20", duration_s=-5.0), "positive"),
        (Case("s175", "zigzag:20/20", dt_s=0.0), "positive"),
        (Case("s175", "zigzag:20/20", duration_s=1.0, dt_s=5.0), "shorter"),
        (Case("remus", "turn:20", duration_s=60.0), "diverges"),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_refusals_are_one_clear_line(case, said):
    with pytest.raises(BadInput) as caught:
        generate(case)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_a_model_without_a_suite_needs_duration_and_step():
    bare = replace(resolve("mariner"), suite={}, particulars={})
    with pytest.raises(BadInput, match="no suite values"):
        record_run(bare, parse_manoeuvre("straight"), duration_s=100.0)
    assert record_run(bare, parse_manoeuvre("straight"), duration_s=10.0, dt_s=0.5).n == 21


def test_a_ship_without_a_suite_is_sailed_by_the_time_that_its_length_takes():
    """Mariner: L/U = 160.93 m / 7.7175 m/s = 20.85 s, of which a sample takes at most a twentieth."""
    known = suggested(replace(resolve("mariner"), suite={}))
    assert known["dt_s"] == 1.0 and known["duration_s"] == 1050.0
    small = suggested(replace(resolve("kvlcc2-l7"), suite={}))
    assert small["dt_s"] == 0.2 and small["train"] and suggested(resolve("mariner")) == resolve("mariner").suite
