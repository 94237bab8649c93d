"""Wind, current and waves: texts, statistics, physics and the consistency of wave motion between channels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from helmbench.datasets import disturbances as d
from helmbench.datasets.disturbances import parse_disturbance
from helmbench.datasets.generator import Case, generate, record_run, sail
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.record import Record
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.simulate import closed_loop

DEG = math.pi / 180.0
Z = 5.0


@pytest.mark.parametrize(
    ("text", "canonical"),
    [
        ("none", "none"),
        ("wind:12@40deg", "wind:12@40"),
        ("wind:12m_s@40", "wind:12@40"),
        ("steady-wind:8.5@-30", "steady-wind:8.5@-30"),
        ("current:0.5@90", "current:0.5@90"),
        ("waves:3.25m/9s@30deg", "waves:3.25/9@30"),
        ("wind:12@40+current:.5@90+waves:2/7@0", "wind:12@40+current:0.5@90+waves:2/7@0"),
    ],
)
def test_texts_are_read(text, canonical):
    found = parse_disturbance(text)
    assert found.text == canonical and parse_disturbance(canonical) == found


def test_values_are_in_si():
    found = parse_disturbance("wind:12@40+current:0.5@90+waves:2/7@-10")
    assert found.wind == d.MeanWind(12.0, pytest.approx(40 * DEG), True)
    assert found.current == d.SteadyCurrent(0.5, pytest.approx(90 * DEG))
    assert found.waves == d.Waves(2.0, 7.0, pytest.approx(-10 * DEG))
    assert parse_disturbance("steady-wind:1@0").wind == d.MeanWind(1.0, 0.0, False)


@pytest.mark.parametrize(
    "text",
    ["", "calm", "wind", "wind:", "wind:12", "wind:12@", "wind:@40", "wind:-12@40", "wind:0@40", "wind:12@40m",
     "wind:12kn@40", "wind:nan@40", "waves:2@30", "waves:2/0@30", "waves:2/7/1@30", "waves:2/7", "none+wind:1@2",
     "wind:12@40+", "wind:12@40+wind:3@10", "wind:12@40+steady-wind:3@10", "current:1@2@3"],
)  # fmt: skip
def test_bad_texts_end_in_one_line(text):
    with pytest.raises(BadInput) as caught:
        parse_disturbance(text)
    assert "\n" not in str(caught.value) and len(str(caught.value)) > 20


# ---- wind and current


def test_gusts_have_mean_sd_and_memory_in_both_components(seed):
    n, dt = 40_000, 1.0
    v = d.wind_velocity(d.MeanWind(10.0, 30 * DEG), dt * np.arange(n), np.random.default_rng(seed))
    a = math.exp(-dt / 20.0)
    spread = math.sqrt((1 + a) / (1 - a) / n)
    mean = -10.0 * np.array([math.cos(30 * DEG), math.sin(30 * DEG)])
    assert np.all(np.abs(v.mean(axis=0) - mean) < Z * 1.2 * spread)
    gust = v - mean
    assert np.all(np.abs(gust.var(axis=0) / 1.44 - 1) < Z * math.sqrt(2 / n) * math.sqrt((1 + a * a) / (1 - a * a)))
    shock = gust[1:] - a * gust[:-1]
    assert np.all(np.abs(shock.std(axis=0) / (1.2 * math.sqrt(1 - a * a)) - 1) < Z / math.sqrt(2 * n))
    assert abs(np.corrcoef(shock.T)[0, 1]) < Z / math.sqrt(n)


def test_steady_wind_and_current_fill_their_columns(seed):
    model, time = resolve("s175"), np.arange(5.0)
    found = parse_disturbance("steady-wind:10@90+current:2@90")
    out = found.environment(model, time, np.random.default_rng(seed))
    np.testing.assert_allclose(out, np.tile([0, 2, 0, -10, 0, 0, 0], (5, 1)), atol=1e-12)
    assert not parse_disturbance("none").environment(model, time, np.random.default_rng(seed)).any()


@pytest.mark.parametrize("vessel", ["mariner", "s175"])
def test_wind_from_the_starboard_bow_pushes_the_bow_to_port(vessel):
    calm = generate(Case(vessel, "straight", duration_s=60.0))
    windy = generate(Case(vessel, "straight", disturbance="steady-wind:15@45", duration_s=60.0))
    assert windy.column("yaw_rate_rad_s")[20] < calm.column("yaw_rate_rad_s")[20]
    assert windy.column("sway_m_s")[20] < calm.column("sway_m_s")[20]
    assert windy.column("surge_m_s")[20] < calm.column("surge_m_s")[20]


@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7"])
def test_a_uniform_current_only_carries_the_run_along(vessel):
    calm = generate(Case(vessel, "zigzag:20/20", duration_s=200.0))
    carried = generate(Case(vessel, "zigzag:20/20", disturbance="current:0.4@60", duration_s=200.0))
    north, east = 0.4 * math.cos(60 * DEG), 0.4 * math.sin(60 * DEG)
    np.testing.assert_allclose(carried.column("heading_rad"), calm.column("heading_rad"), atol=1e-5)
    np.testing.assert_allclose(carried.column("north_m") - north * calm.time_s, calm.column("north_m"), atol=1e-2)
    np.testing.assert_allclose(carried.column("east_m") - east * calm.time_s, calm.column("east_m"), atol=1e-2)


@pytest.mark.parametrize("text", ["wind:5@0", "current:0.5@0"])
def test_response_models_refuse_wind_and_current(text):
    with pytest.raises(BadInput, match="3-DOF"):
        generate(Case("remus-kt", "zigzag:20/20", disturbance=text))


# ---- waves: spectrum and mean drift


def test_the_spectrum_has_its_height_and_peak():
    omega = np.linspace(0.05, 12.0, 200_000)
    density = d.jonswap(omega, 3.0, 9.0)
    assert 4.0 * math.sqrt(np.trapezoid(density, omega)) == pytest.approx(3.0, rel=0.01)
    assert omega[np.argmax(density)] == pytest.approx(2 * math.pi / 9.0, rel=1e-3)
    at = 2 * math.pi / 9.0 * np.array([0.999999, 1.000001])
    assert np.diff(d.jonswap(at, 3.0, 9.0)) / density.max() == pytest.approx(0.0, abs=1e-5)


def test_components_hold_exactly_the_energy_at_distinct_frequencies(seed):
    c = d.wave_components(d.Waves(3.0, 9.0, 0.0), np.random.default_rng(seed))
    assert np.sum(c.amplitude**2) / 2 == pytest.approx(9.0 / 16.0, rel=1e-12)
    assert np.all(np.diff(c.omega) > 0) and np.ptp(np.diff(c.omega)) > 0
    assert np.all((c.phase >= 0) & (c.phase < 2 * math.pi))


def test_drift_coefficients_at_the_cardinal_angles():
    c = d.drift_coefficients(np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5]) * math.pi)
    half = math.sqrt(0.5)
    expected = [
        [-0.010, 0, 0], [-0.010 * half, -0.010, -0.002], [0, -0.020, 0], [0.003 * half, -0.010, 0.002],
        [0.003, 0, 0], [0, 0.020, 0],
    ]  # fmt: skip
    np.testing.assert_allclose(c, expected, atol=1e-12)


def test_drift_grows_with_height_squared_and_follows_the_heading():
    model = resolve("s175")
    heading = np.array([0.0, 0.3])
    small, large = (parse_disturbance(f"waves:{h}/9@20").drift(model, heading) for h in (1.0, 3.0))
    np.testing.assert_allclose(large, 9.0 * small, rtol=1e-12)
    chi = 20 * DEG - heading
    force = 1025.0 * 9.81 * 175.0
    np.testing.assert_allclose(small[:, 0], -0.010 * np.cos(chi) * force, rtol=1e-12)
    np.testing.assert_allclose(small[:, 2], -0.002 * np.sin(2 * chi) * force * 175.0, rtol=1e-12)


@pytest.mark.parametrize("manoeuvre", ["zigzag:10/10", "turn:35:port", "straight"])
def test_the_drift_acts_at_the_headings_of_the_run_itself(seed, manoeuvre):
    model, sea = resolve("s175"), parse_disturbance("wind:8@20+waves:3.25/8.5@50")
    rng = np.random.default_rng(seed)
    control = parse_manoeuvre(manoeuvre).control(model, 0.5, 600.0, rng)
    environment = sea.environment(model, 0.5 * np.arange(1201), rng)
    run = sail(model, 0.5, control, sea, environment, "rk4")
    heading = run.states[:, model.states.index("psi")]
    environment[:, 4:7] = sea.drift(model, heading)
    again = closed_loop(model, 0.5, control, environment)
    np.testing.assert_allclose(again.states, run.states, atol=1e-6)
    environment[:, 4:7] = 0.0
    without = closed_loop(model, 0.5, control, environment)
    assert np.max(np.abs(without.states[:, -1] - heading)) > 1 * DEG


def test_sea_state_5_changes_a_zigzag_as_much_as_the_reference_study():
    """Wind 10 m/s and Hs 3.25 m from 12 directions, S175 10/10: mean rms change of v .30 m/s, r .18, psi 4.4 deg."""
    model, zigzag = resolve("s175"), parse_manoeuvre("zigzag:10/10")
    calm = record_run(model, zigzag, duration_s=600.0)
    rms = []
    for direction in range(0, 360, 30):
        sea = parse_disturbance(f"wind:10@{direction}+waves:3.25/8.5@{direction}")
        rough = record_run(model, zigzag, None, sea, seed=1, duration_s=600.0)
        change = [rough.column(c) - calm.column(c) for c in ("sway_m_s", "yaw_rate_rad_s", "heading_rad")]
        rms.append([np.sqrt(np.mean(x**2)) for x in change])
    sway, rate, heading = np.mean(rms, axis=0)
    assert 0.2 < sway < 0.45 and 0.12 < rate / DEG < 0.35 and 3.0 < heading / DEG < 7.0


# ---- waves: first-order motion


def track(model, manoeuvre: str, dt: float, duration: float) -> Record:
    return record_run(model, parse_manoeuvre(manoeuvre), duration_s=duration, dt_s=dt)


def slope(x: np.ndarray, dt: float) -> np.ndarray:
    """Fourth-order central difference, (N - 4,)."""
    return (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * dt)


@pytest.mark.parametrize("vessel", ["s175", "mariner"])
@pytest.mark.parametrize("direction", [0, 35, 90, 160, 250])
def test_rates_are_the_derivatives_of_the_motion_even_in_a_hard_turn(seed, vessel, direction):
    model, dt = resolve(vessel), 0.02
    calm = track(model, "turn:35", dt, 150.0)
    waves = d.Waves(3.0, 8.0, direction * DEG)
    m = d.wave_motion(model, calm, waves, d.wave_components(waves, np.random.default_rng(seed)))
    for value, rate in ((m.along, m.along_rate), (m.heading, m.heading_rate), (m.roll, m.roll_rate)):
        assert np.std(rate) > 0
        assert np.max(np.abs(slope(value, dt) - rate[2:-2])) < 1e-4 * np.std(rate)


def test_all_channels_stay_kinematically_consistent(seed):
    model, dt = resolve("s175"), 0.02
    r = record_run(
        model, parse_manoeuvre("zigzag:20/20"), None, parse_disturbance("waves:3/8@40+current:1@10"),
        seed=seed, duration_s=150.0, dt_s=dt,
    )  # fmt: skip
    psi, u, v = (r.column(c)[2:-2] for c in ("heading_rad", "surge_m_s", "sway_m_s"))
    np.testing.assert_allclose(slope(r.column("heading_rad"), dt), r.column("yaw_rate_rad_s")[2:-2], atol=1e-6)
    np.testing.assert_allclose(slope(r.column("north_m"), dt), u * np.cos(psi) - v * np.sin(psi), atol=1e-4)
    np.testing.assert_allclose(slope(r.column("east_m"), dt), u * np.sin(psi) + v * np.cos(psi), atol=1e-4)
    np.testing.assert_allclose(slope(r.column("roll_rad"), dt), r.column("roll_rate_rad_s")[2:-2], atol=1e-6)


@pytest.mark.parametrize("direction", [0.0, 60.0, 180.0])
def test_one_regular_wave_on_a_straight_course_has_the_encounter_frequency(direction):
    model, n, dt, speed = resolve("s175"), 2000, 0.1, 7.0
    time = dt * np.arange(n)
    still = np.zeros(n)
    calm = Record(time, {
        "heading_rad": still, "yaw_rate_rad_s": still, "sway_m_s": still, "east_m": still,
        "surge_m_s": still + speed, "north_m": speed * time,
    })  # fmt: skip
    omega, amplitude, phase = 0.7, 1.5, 0.4
    waves = d.Waves(3.0, 9.0, direction * DEG)
    one = d.Components(*(np.array([x]) for x in (omega, amplitude, phase)))
    m = d.wave_motion(model, calm, waves, one)
    k, gamma = omega**2 / 9.81, direction * DEG + math.pi
    theta = (omega - k * speed * math.cos(gamma)) * time + phase
    s = 0.5 * k * 175.0 * math.cos(gamma)
    deep = amplitude * math.exp(-k * 8.5 / 2)
    np.testing.assert_allclose(m.along, deep * np.sin(s) / s * np.sin(theta), atol=1e-12)
    j1 = math.sin(s) / s**2 - math.cos(s) / s
    np.testing.assert_allclose(m.heading, -deep * 6 / 175 * j1 * math.sin(gamma) * np.cos(theta), atol=1e-12)


def test_hull_averages_are_the_strip_integrals():
    """sin(s)/s and (6/L) j1(s) against quadrature of the water's lateral displacement along the hull."""
    model, still = resolve("s175"), np.zeros(1)
    x, w = np.polynomial.legendre.leggauss(60)
    x, w = 0.5 * 175.0 * x, 0.5 * 175.0 * w
    for q in (1e-6, 0.003, 0.05):
        gamma = math.acos(0.5)
        k = q / math.cos(gamma)
        wave = d.Components(np.array([math.sqrt(9.81 * k)]), np.ones(1), np.array([0.3]))
        record = Record(still, {"heading_rad": still, "yaw_rate_rad_s": still, "surge_m_s": still, "sway_m_s": still,
                                "north_m": still, "east_m": still})  # fmt: skip
        m = d.wave_motion(model, record, d.Waves(2.0, 9.0, gamma - math.pi), wave)
        deep = math.exp(-0.5 * k * 8.5)
        mean, moment = np.sum(w * np.cos(q * x)) / 175.0, 12.0 / 175.0**3 * np.sum(w * x * np.sin(q * x))
        assert m.along[0] == pytest.approx(deep * mean * math.sin(0.3), rel=1e-9)
        assert abs(m.heading[0]) == pytest.approx(deep * abs(moment) * math.sin(gamma) * math.cos(0.3), rel=1e-9)


@pytest.mark.parametrize("direction", [0.0, 30.0, 89.9999, 90.0, 150.0])
def test_rates_are_the_derivatives_of_the_motion(direction):
    """Also where the waves come from abeam and the hull averages are those of zero."""
    n, dt = 4001, 0.01
    time = dt * np.arange(n)
    still, turn = np.zeros(n), 1e-3
    record = Record(time, {
        "heading_rad": turn * (time - 20.0), "yaw_rate_rad_s": still + turn, "surge_m_s": still, "sway_m_s": still,
        "north_m": still, "east_m": still,
    })  # fmt: skip
    wave = d.Components(np.array([0.7]), np.ones(1), np.array([0.4]))
    m = d.wave_motion(resolve("s175"), record, d.Waves(2.0, 9.0, direction * DEG), wave)
    for value, rate in ((m[0], m[1]), (m[2], m[3]), (m[4], m[5])):
        np.testing.assert_allclose(np.gradient(value, dt)[1:-1], rate[1:-1], atol=2e-5 * max(np.abs(rate).max(), 1e-6))


def test_long_waves_move_a_small_hull_as_they_move_the_water():
    model = resolve("remus")
    calm = Record(0.1 * np.arange(9000), {"heading_rad": np.zeros(9000), "yaw_rate_rad_s": np.zeros(9000)})
    waves = d.Waves(2.0, 12.0, 0.0)
    m = d.wave_motion(model, calm, waves, d.wave_components(waves, np.random.default_rng(0)))
    assert 4 * np.std(m.along) == pytest.approx(2.0, rel=0.15)


def test_head_and_following_seas_do_not_turn_the_ship(seed):
    model = resolve("s175")
    still = track(model, "straight", 0.5, 100.0)
    assert not still.column("heading_rad").any()
    for direction in (0.0, math.pi):
        waves = d.Waves(3.0, 9.0, direction)
        m = d.wave_motion(model, still, waves, d.wave_components(waves, np.random.default_rng(seed)))
        assert np.max(np.abs(m.heading)) < 1e-12 and np.max(np.abs(m.roll)) < 1e-12
        assert np.std(m.along) > 1e-3


def test_response_models_move_in_heading_and_yaw_rate_only(seed):
    calm = generate(Case("remus-kt", "zigzag:20/20"))
    rough = generate(Case("remus-kt", "zigzag:20/20", disturbance="waves:0.2/2@60", seed=seed))
    assert rough.channels.keys() == calm.channels.keys()
    assert np.std(rough.column("heading_rad") - calm.column("heading_rad")) > 0.1 * DEG
    for name in ("rudder_rad", "rudder_command_rad"):
        np.testing.assert_array_equal(rough.column(name), calm.column(name))


def test_waves_need_a_length():
    with pytest.raises(BadInput, match="length"):
        generate(Case("response-1", "zigzag:5/10", disturbance="waves:1/6@0"))
