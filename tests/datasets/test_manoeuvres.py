"""Manoeuvre texts, the controls built from them, and the indices read back from records."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets import indices
from helmbench.datasets.generator import Case, generate, record_run
from helmbench.datasets.manoeuvres import KINDS, TAPS, from_series, parse_manoeuvre, shift_register
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

DEG = math.pi / 180.0


def control(text: str, vessel: str = "s175", dt: float = 1.0, duration: float = 100.0, seed: int = 0):
    """The control of a manoeuvre; the seed counts for `prbs` and `steps` only."""
    return parse_manoeuvre(text).control(resolve(vessel), dt, duration, np.random.default_rng(seed))


@pytest.mark.parametrize(
    ("text", "kind", "values", "side"),
    [
        ("zigzag:20/20", "zigzag", (20 * DEG, 20 * DEG), 1),
        ("zigzag:20/1:port", "zigzag", (20 * DEG, 1 * DEG), -1),
        ("zigzag:12.5deg/7deg", "zigzag", (12.5 * DEG, 7 * DEG), 1),
        ("turn:35:port", "turn", (35 * DEG,), -1),
        ("turn:35:starboard", "turn", (35 * DEG,), 1),
        ("pullout:20", "pullout", (20 * DEG,), 1),
        ("pullout:20/300s", "pullout", (20 * DEG, 300.0), 1),
        ("spiral:25", "spiral", (25 * DEG, 5 * DEG), 1),
        ("spiral:15/7.5:port", "spiral", (15 * DEG, 7.5 * DEG), -1),
        ("sine:20deg/120s", "sine", (20 * DEG, 2 * math.pi / 120), 1),
        ("sine:20deg/120s+10deg/0.25rad_s", "sine", (20 * DEG, 2 * math.pi / 120, 10 * DEG, 0.25), 1),
        ("prbs:20deg/15s", "prbs", (20 * DEG, 15.0), 1),
        ("steps:0.5rad/20s", "steps", (0.5, 20.0), 1),
        ("straight", "straight", (), 1),
        ("heading:20deg/600s:port", "heading", (20 * DEG, 2 * math.pi / 600), -1),
    ],
)
def test_texts_are_read(text, kind, values, side):
    m = parse_manoeuvre(text)
    assert (m.kind, m.side, m.euler) == (kind, side, False)
    assert m.values == pytest.approx(values, rel=1e-14)
    euler = parse_manoeuvre(text + "@euler")
    assert euler.euler and euler.values == m.values
    assert euler.text == m.text + "@euler" and euler.integrator == "euler" and m.integrator == "rk4"
    assert parse_manoeuvre(m.text).text == m.text


def test_equal_manoeuvres_have_equal_texts():
    assert parse_manoeuvre("zigzag:20.0deg/20:starboard").text == "zigzag:20/20"
    assert parse_manoeuvre("spiral:25/5").text != parse_manoeuvre("spiral:25/2.5").text


@pytest.mark.parametrize(
    "text",
    [
        "", "zigzag", "zigzag:", "zigzag:20", "zigzag:20/20/20", "zigzag:a/20", "zigzag:-20/20", "zigzag:0/20",
        "zigzag:20/20:left", "zigzag:nan/20", "zigzag:inf/5", "zigzag:1e999/5", "zigzag:200/20", "Zigzag:20/20",
        "turn", "turn:35/2", "turn:35:port:port", "turn:35m", "sine:20/120", "sine:20deg/120", "sine:20deg/0s",
        "sine:20deg/120s+", "sine:20deg", "prbs:20deg/15s:port", "prbs:20deg", "steps:20deg/-5s", "straight:1",
        "spiral:25/4", "pullout:20/300", "zigzag:20/20@rk4", "zigzag:20/20@euler@euler", "series:x", "nonsense:3",
        "zigzag: 20/20",
    ],
)  # fmt: skip
def test_bad_texts_end_in_one_line_that_shows_the_form(text):
    with pytest.raises(BadInput) as caught:
        parse_manoeuvre(text)
    line = str(caught.value)
    known = text.partition(":")[0].strip() in KINDS
    shown = ("expected",) if known else ("known: zigzag, turn", "did you mean zigzag?")
    assert "\n" not in line and any(form in line for form in shown) and repr(text) in line


def test_every_form_shows_an_example_that_works():
    for name, kind in KINDS.items():
        if name == "series":
            continue
        examples = re.findall(rf"\b{name}:\S+", kind.form.split("e.g.")[-1]) or [name]
        for example in examples:
            assert parse_manoeuvre(example).kind == name
        assert kind.description


@pytest.mark.parametrize(("vessel", "sign"), [("s175", 1.0), ("mariner", -1.0)])
def test_rudder_sign_is_the_vessels(vessel, sign):
    zigzag = control("zigzag:20/10:port", vessel)
    assert zigzag.rudder_rad == pytest.approx(sign * 20 * DEG)
    assert (zigzag.heading_rad, zigzag.first) == (pytest.approx(10 * DEG), -1)
    assert control("turn:35", vessel).reference[-1] == pytest.approx(sign * 35 * DEG)
    assert control("turn:35:port", vessel).reference[-1] == pytest.approx(-sign * 35 * DEG)


@pytest.mark.parametrize("vessel", ["s175", "mariner", "kvlcc2-l7", "response-1"])
@pytest.mark.parametrize(("suffix", "side"), [("", 1.0), (":port", -1.0)])
def test_ships_turn_to_the_side_that_is_said(vessel, suffix, side):
    record = generate(Case(vessel, "turn:20" + suffix, duration_s=60.0))
    assert side * record.column("heading_rad")[-1] > 5 * DEG


def test_execute_time_follows_suite_then_duration(rng):
    model = resolve("s175")
    bare = replace(model, suite={})
    early = replace(model, suite={"execute_s": 3.0})
    m = parse_manoeuvre("zigzag:10/10")
    assert m.control(bare, 0.5, 600.0, rng).execute_s == pytest.approx(10.0)
    assert m.control(bare, 0.02, 3.0, rng).execute_s == pytest.approx(0.16)
    assert m.control(early, 0.5, 600.0, rng).execute_s == pytest.approx(3.0)


def test_turn_and_pullout_switch_at_their_times():
    turn = control("turn:30", dt=0.1, duration=100.0)
    assert np.flatnonzero(turn.reference)[0] == 100
    pull = control("pullout:30", dt=0.1, duration=100.0).reference
    assert set(np.flatnonzero(pull)) == set(range(100, 550))
    held = control("pullout:30/20s", dt=0.1, duration=100.0).reference
    assert set(np.flatnonzero(held)) == set(range(100, 300))


def test_spiral_goes_down_and_back_in_equal_holds():
    reference = control("spiral:10/5", dt=0.5, duration=450.0).reference / DEG
    changes = np.flatnonzero(np.diff(reference)) + 1
    levels = reference[np.concatenate([[0], changes])]
    assert levels == pytest.approx([10, 5, 0, -5, -10, -5, 0, 5, 10])
    assert np.ptp(np.diff(changes)) <= 1
    assert control("spiral:10/5:port").reference[0] == pytest.approx(-10 * DEG)
    with pytest.raises(BadInput, match="too few"):
        control("spiral:25", dt=10.0, duration=100.0)


def test_sines_add_up():
    reference = control("sine:20deg/50s+10deg/0.3rad_s", dt=0.5).reference
    t = 0.5 * np.arange(201)
    expected = 20 * DEG * np.sin(2 * math.pi * t / 50) + 10 * DEG * np.sin(0.3 * t)
    np.testing.assert_allclose(reference, expected, atol=1e-14)


@pytest.mark.parametrize("order", sorted(TAPS))
def test_shift_registers_have_maximum_length(order, rng):
    period = 2**order - 1
    if order > 14:
        bits = shift_register(order, 4 * order, rng)
        assert 0 < bits.sum() < bits.size
        return
    bits = shift_register(order, 2 * period, rng)
    assert np.array_equal(bits[:period], bits[period:])
    assert bits[:period].sum() == 2 ** (order - 1)
    windows = np.lib.stride_tricks.sliding_window_view(bits[: period + order - 1], order)
    assert len({tuple(w) for w in windows.tolist()}) == period


def test_prbs_has_two_levels_and_changes_on_the_clock_only(seed):
    reference = control("prbs:20deg/15s", dt=0.5, duration=3000.0, seed=seed).reference
    assert set(np.round(reference / DEG, 9)) == {-20.0, 20.0}
    changes = np.flatnonzero(np.diff(reference)) + 1
    assert np.all(changes % 30 == 0) and 60 < changes.size < 140


def test_random_steps_are_uniform_and_held(seed):
    draw = control("steps:30deg/2s", dt=0.5, duration=8000.0, seed=seed).reference
    levels = draw[:-1].reshape(-1, 4)
    assert np.all(levels == levels[:, :1]) and np.all(np.abs(levels) <= 30 * DEG)
    z = levels[:, 0] / (30 * DEG)
    n = z.size
    assert abs(z.mean()) < 5 * math.sqrt(1 / 3 / n)
    assert abs((z**2).mean() - 1 / 3) < 5 * math.sqrt((1 / 5 - 1 / 9) / n)


def test_heading_manoeuvre_needs_and_uses_the_controller():
    with pytest.raises(BadInput, match="no heading controller"):
        control("heading:20deg/600s", "mariner")
    loop = control("heading:20deg/600s", "cargo")
    assert (loop.kind, loop.kp) == ("heading", pytest.approx(0.12))
    assert loop.reference[50] == pytest.approx(20 * DEG * math.sin(2 * math.pi * 50 / 600))


@pytest.mark.parametrize(("dt", "duration"), [(0.0, 10.0), (-1.0, 10.0), (1.0, 0.0), (1.0, 0.2), (math.nan, 1.0)])
def test_senseless_sampling_is_refused(dt, duration, rng):
    with pytest.raises(BadInput):
        parse_manoeuvre("straight").control(resolve("s175"), dt, duration, rng)


def test_a_series_from_a_records_command_repeats_the_run():
    record = generate(Case("s175", "zigzag:20/20", duration_s=200.0))
    again = record_run(resolve("s175"), from_series(record), duration_s=200.0)
    for name in record.channels:
        np.testing.assert_allclose(again.column(name), record.column(name), atol=1e-9)
    flipped = from_series(record.turned("port"))
    other = record_run(resolve("s175"), flipped, duration_s=200.0)
    np.testing.assert_allclose(other.column("heading_rad"), record.column("heading_rad"), atol=1e-9)


def test_a_series_from_a_rudder_angle_bypasses_the_gear():
    record = generate(Case("s175", "zigzag:20/20", duration_s=200.0)).with_channels(rudder_command_rad=None)
    again = record_run(resolve("s175"), from_series(record), duration_s=200.0)
    for name in ("rudder_rad", "heading_rad", "sway_m_s"):
        np.testing.assert_allclose(again.column(name), record.column(name), atol=1e-9)


def test_a_series_from_an_array_is_held_at_its_end_and_refuses_gaps(rng):
    model = resolve("s175")
    loop = from_series([0.1, 0.2]).control(model, 1.0, 4.0, rng)
    np.testing.assert_array_equal(loop.reference, [0.1, 0.2, 0.2, 0.2, 0.2])
    assert from_series(np.zeros(9)).control(model, 1.0, 4.0, rng).reference.size == 5
    for bad in ([], [0.1, math.nan]):
        with pytest.raises(BadInput, match="empty or holds gaps"):
            from_series(bad)


def test_a_series_is_resampled_in_time(rng):
    record = generate(Case("s175", "sine:20deg/60s", duration_s=120.0, dt_s=1.0))
    late = replace(record, time_s=record.time_s + 50.0)
    loop = from_series(late).control(resolve("s175"), 0.5, 120.0, rng)
    np.testing.assert_allclose(loop.reference[::2], record.column("rudder_command_rad"), atol=1e-14)


# Published model, own simulation elsewhere (mariner.json): overshoots in deg, times in s, distances in m.
ZIGZAGS = {
    "zigzag:10/10:port": ((3.459, 6.193, 4.460), 46.38, 60.86),
    "zigzag:20/20": ((7.787, 6.315, 7.205), 43.50, 61.54),
    "zigzag:30/30:port": ((8.694, 8.244, 7.438), 52.72, 70.22),
}


@pytest.mark.parametrize("text", ZIGZAGS)
def test_overshoots_of_the_mariner(text):
    angles, second_execute, first_extreme = ZIGZAGS[text]
    record = generate(Case("mariner", text, duration_s=400.0, dt_s=0.02))
    assert np.array(indices.overshoots(record)[:3]) / DEG == pytest.approx(angles, abs=0.02)
    assert indices.execute_times(record)[:2] == pytest.approx([10.0, second_execute], abs=0.1)
    assert indices.overshoot_times(record)[0] == pytest.approx(first_extreme, abs=0.1)
    without = record.with_channels(rudder_command_rad=None)
    assert np.array(indices.overshoots(without)[:3]) / DEG == pytest.approx(angles, abs=0.05)


def test_unfinished_overshoots_are_left_out():
    record = generate(Case("mariner", "zigzag:20/20", duration_s=300.0, dt_s=0.1))
    assert len(indices.overshoots(record)) == len(indices.executes(record)) - 1
    stop = int(indices.executes(record)[1]) + 20
    assert indices.overshoots(record.slice(0, stop)) == []


TURNS = {
    ("turn:15:port", 100.0): {
        "advance": 946.274, "transfer": 539.587, "t90": 176.062, "tactical_diameter": 1310.923, "t180": 341.685,
        "max_advance": 955.92, "max_transfer": 1315.156, "steady_radius": 711.247, "steady_speed": 6.629,
        "drift_angle": 5.849 * DEG,
    },
    ("turn:35", 0.0): {
        "advance": 570.179, "transfer": 420.231, "t90": 116.154, "tactical_diameter": 1029.216, "t180": 258.26,
        "max_advance": 580.135, "max_transfer": 1033.508, "steady_radius": 555.721, "steady_speed": 6.009,
        "drift_angle": 6.968 * DEG,
    },
}  # fmt: skip


@pytest.mark.parametrize("case", TURNS, ids=str)
def test_turning_circles_of_the_mariner(case):
    text, execute = case
    model = replace(resolve("mariner"), suite={"execute_s": execute})
    record = record_run(model, parse_manoeuvre(text), duration_s=2500.0, dt_s=0.1)
    found = indices.turning_indices(record)
    for key, value in TURNS[case].items():
        assert found[key] == pytest.approx(value, rel=2e-3), key


def test_turning_indices_do_not_depend_on_course_place_or_wrapping():
    record = generate(Case("s175", "turn:35:port", duration_s=900.0))
    angle = 2.0
    north, east = record.column("north_m"), record.column("east_m")
    moved = record.with_channels(
        north_m=1e3 + north * math.cos(angle) - east * math.sin(angle),
        east_m=-2e3 + north * math.sin(angle) + east * math.cos(angle),
        heading_rad=np.mod(record.column("heading_rad") + angle, 2 * math.pi),
    )
    expected, found = indices.turning_indices(record), indices.turning_indices(moved)
    assert found == pytest.approx(expected, rel=1e-9)
    assert expected["tactical_diameter"] > expected["transfer"] > 0.0 and expected["drift_angle"] > 0.0


def test_short_turns_and_records_without_rudder_say_so():
    short = indices.turning_indices(generate(Case("s175", "turn:10", duration_s=60.0)))
    assert math.isnan(short["advance"]) and math.isnan(short["tactical_diameter"])
    straight = generate(Case("s175", "straight", duration_s=60.0))
    with pytest.raises(BadInput, match="not a zigzag"):
        indices.overshoots(straight)
    with pytest.raises(BadInput, match="not a turn"):
        indices.turning_indices(straight)
