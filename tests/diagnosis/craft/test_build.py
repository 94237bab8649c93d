"""Models of craft whose truth a simulator of the tests knows; it shares no equations with helmbench.models."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.record import Record, RecordMeta
from helmbench.diagnosis.craft import ladder as ladders
from helmbench.diagnosis.craft.build import build
from helmbench.diagnosis.craft.ladder import Ladder, Steering, climb
from helmbench.diagnosis.craft.records import measured_by_all, outside
from helmbench.diagnosis.craft.result import BUILT, NO_EFFECT, UNEXPLAINED
from helmbench.diagnosis.craft.verdict import verdict_of
from helmbench.diagnosis.craft.windows import pieces_of, scales_of
from helmbench.estimation.records.series import speed_of
from helmbench.estimation.validation.horizons import STRAIGHT
from helmbench.models.errors import CannotFit
from helmbench.reporting import media
from helmbench.reporting.craft import page

from ...expectations.injections import passes
from ...nightly_marks import nightly_but
from ...simulators.craft import ALLOCATED, FULL, LAWS, STRONGER, draw, sailed

OF = {"flow": "rudder-in-flow", "race": "rudder-in-race", "thruster": "thruster-in-flow"}
WITHOUT = {
    "flow": {"constant", "thruster"},
    "race": {"constant", "rudder_in_flow", "thruster"},
    "thruster": {"rudder_in_flow"},
}


def at_three_lengths(found):
    """R2 of the yaw rate three lengths ahead along the held-out records, by the built model."""
    horizon = f"{found.ahead.horizons_s[2]:.3g} s"
    return found.ahead.score("yaw_rate_rad_s", BUILT, horizon=horizon).r2


def calm(rng, craft):
    """Two training records and a held-out one without weather, with a fifth of the usual noise: what is true of the
    craft shows in any draw, and how often it shows in weather is a rate (tests/rates)."""
    records = [sailed(rng, craft, f"run {i}", noise=0.2, length=45.0, weather=0.0) for i in range(3)]
    return records[:2], records[2:]


@pytest.mark.parametrize("law", nightly_but(LAWS, "race"))
def test_a_delay_and_what_steers_the_craft_are_found(law, rng):
    """The law in every draw, the delay in most: a slow rudder was named for a late one in 1 of 110 draws of thrusters;
    how often it is a rate (tests/nightly/rates)."""

    def delay_is_found():
        craft = draw(rng, law, "delay")
        found = build(*calm(rng, craft))
        assert found.verdict == "adequate" and at_three_lengths(found) > 0.97
        laws = {told.id: told for told in found.laws}
        assert all(laws[wrong].gain < -0.02 for wrong in WITHOUT[law])
        assert found.trusted_s > craft.clock
        return found.model.instruments.get("rudder_delay") == pytest.approx(craft.delay, rel=0.25)

    assert passes(delay_is_found, 0.99)


@pytest.mark.parametrize("law", nightly_but(ALLOCATED, "azimuth"))
def test_two_thrusters_and_an_azimuth_thruster_are_named_with_their_own_effects(law, rng):
    craft = draw(rng, law)
    found = build(*calm(rng, craft))
    values = {n.name: n.value for n in found.numbers}
    assert at_three_lengths(found) > 0.97
    if law == "azimuth":
        assert found.model.family.startswith("azimuth-thruster")
        assert values["bn"] == pytest.approx(0.35 * craft.gain / craft.time / craft.clock**2 / 100.0, rel=0.15)
    else:
        assert found.model.family.startswith("twin-thrusters")
        moment = 2.0 * craft.gain / craft.time / craft.clock**2 / FULL / (1.0 + STRONGER)
        port, starboard = values["b"] + values["bs"], values["b"] - values["bs"]
        assert port == pytest.approx(STRONGER * moment, rel=0.15) and starboard == pytest.approx(moment, rel=0.15)


@pytest.mark.parametrize("measured", ["surge", "positions"])
def test_a_rudder_that_acts_with_the_sign_of_the_speed_is_told_with_its_numbers(measured, rng):
    drawn = draw(rng, "flow")
    craft = replace(drawn, still=0.1 / drawn.clock)
    records = [sailed(rng, craft, f"run {i}", 0.2, 45.0, weather=0.0, astern=True) for i in range(3)]
    if measured == "positions":
        records = [record.with_channels(surge_m_s=None) for record in records]
    found = build(records[:2], records[2:])
    numbers = {n.name: n for n in found.numbers}
    assert found.verdict == "adequate" and at_three_lengths(found) > 0.97
    assert next(law.id for law in found.laws if law.chosen) == "rudder_in_flow_through_rest"
    sizes = {"distance_constant": craft.time * craft.length, "curvature_gain": craft.gain / craft.length}
    for name, size, largest in (*((n, x, 0.2) for n, x in sizes.items()), ("still_damping", craft.still, 1.0)):
        half = (numbers[name].high - numbers[name].low) / 2.0  # 90 %: 2.5 halves are 4.1 errors
        assert abs(numbers[name].value - size) < 2.5 * half < 2.5 * largest * size


def test_a_craft_that_goes_ahead_has_the_laws_of_one_that_does(rng):
    craft = draw(rng, "flow")
    records = calm(rng, craft)[0]
    scales = scales_of(records)
    given = measured_by_all(records, scales)
    assert "astern" not in given
    laws = Ladder([], scales, given, commands=True).laws()
    assert {law.id for law in laws} == {"constant", "rudder_in_flow", "thruster", "rudder_in_steady_race"}


def test_an_input_with_which_left_out_windows_are_predicted_is_not_denied(rng):
    """The fall of the errors is within two standard errors; what the yaw rate shows decides."""
    craft = draw(rng, "flow")
    records = [sailed(rng, craft, "run", length=45.0)]
    scales = scales_of(records)
    final = climb(Ladder(pieces_of(records, scales), scales, measured_by_all(records, scales), commands=True)).final
    told = {
        (s, most): verdict_of(final, Steering(0.1, 0.08, 0.4, s, most), None, 0.0, 9.0)
        for s, most in ((0.1, 0.6), (0.3, 0.6), (0.3, 0.2))
    }
    assert told[0.1, 0.6][0] == UNEXPLAINED and "command acts; what form its effect has" in told[0.1, 0.6][1]
    assert told[0.3, 0.6][0] == UNEXPLAINED and "these records do not tell" in told[0.3, 0.6][1]
    assert told[0.3, 0.2][0] == NO_EFFECT and "at most 20 % of the yaw motion follows" in told[0.3, 0.2][1]


def test_a_measured_current_is_taken_off_the_speed_and_the_track(rng):
    craft = draw(rng, "flow")
    record = sailed(rng, craft, "run", noise=0.0, length=20.0)
    psi = record.heading_unwrapped()
    current, towards = 0.3 * craft.speed, rng.uniform(-3.0, 3.0)
    along = current * np.cos(towards - psi)
    known = {"current_speed_m_s": np.full(record.n, current), "current_direction_rad": np.full(record.n, towards)}
    drifting = record.with_channels(surge_m_s=record.column("surge_m_s") + along, **known)
    assert speed_of(drifting) == pytest.approx(speed_of(record), abs=1e-9)
    seconds = record.time_s - record.time_s[0]
    track = {
        "north_m": record.column("north_m") + current * np.cos(towards) * seconds,
        "east_m": record.column("east_m") + current * np.sin(towards) * seconds,
    }
    carried = record.with_channels(surge_m_s=None, **track, **known)
    assert speed_of(carried) == pytest.approx(speed_of(record.with_channels(surge_m_s=None)), abs=1e-6 * craft.speed)


@pytest.mark.nightly
def test_surge_stands_beside_yaw_where_it_was_measured(rng):
    craft = draw(rng, "race")
    found = build(*calm(rng, craft))
    ahead = f"{found.ahead.horizons_s[2]:.3g} s"
    assert found.ahead.score("surge_m_s", "own speed", horizon=ahead).r2 > 0.9
    numbers = found.own_speed.parameters
    drive = numbers["speed_drive"] + numbers["speed_push"] * (0.95 * 10.0) ** 2
    assert np.sqrt(drive / numbers["speed_drag"]) == pytest.approx(0.95 * craft.speed, rel=0.15)
    still = [record.with_channels(surge_m_s=None) for record in calm(rng, craft)[0]]
    assert build(still).own_speed is None


def unrelated(rng, record):
    """A square wave that does not follow the record's command by chance, at no lag up to 4 L/U0."""
    given = record.column("rudder_command_rad") / 0.35
    while True:
        wave = np.sign(np.sin(np.arange(record.n) / rng.uniform(11.0, 41.0)))
        if all(abs(np.mean(wave[lag:] * given[: record.n - lag])) < 0.15 for lag in range(0, 61, 5)):
            return record.with_channels(rudder_command_rad=0.3 * wave)


def test_a_command_that_does_not_act_gives_no_model_that_is_worse_than_going_straight(rng):
    craft = draw(rng, "flow")
    other = [unrelated(rng, sailed(rng, craft, f"run {i}", length=45.0)) for i in range(3)]
    found = build(other[:2], other[2:])
    assert found.verdict in ("input_hardly_acts", "unexplained", "inconclusive")
    assert not any(run.diverged for run in found.ahead.runs)


@pytest.mark.nightly
def test_a_column_that_was_computed_from_the_motion_is_named(rng):
    craft = draw(rng, "flow")
    records = [sailed(rng, craft, f"run {i}", length=45.0) for i in range(2)]
    copied = [record.with_channels(rudder_command_rad=2.0 * record.column("yaw_rate_rad_s")) for record in records]
    found = build(copied)
    said = media.markdown(page(found), "title", "", {})
    assert found.verdict == "input_follows_output"
    assert "craft and its controller together" in said and "What steers it:" not in said and "It lacks" not in said


def test_a_sine_manoeuvre_does_not_follow_the_motion(rng):
    """Of a first-order craft: heading, yaw rate and rudder are three sines of one period."""
    time_s, rudder, yaw_rate = 0.5 * np.arange(1200), np.zeros(1200), np.zeros(1200)
    rudder[10:] = 0.3 * np.sin(2.0 * np.pi * (time_s[10:] - 5.0) / 60.0)
    for k in range(1199):
        yaw_rate[k + 1] = yaw_rate[k] + 0.5 * (0.08 * rudder[k] - yaw_rate[k]) / 12.0
    heading = np.cumsum(0.5 * yaw_rate)
    channels = {
        "rudder_rad": rudder,
        "yaw_rate_rad_s": yaw_rate + 1e-5 * rng.normal(size=1200),
        "heading_rad": heading + 1e-4 * rng.normal(size=1200),
    }
    found = build([Record(time_s, channels, "sine", RecordMeta(positive_rudder="starboard"))])
    assert found.verdict == "adequate"
    assert {n.name: n.value for n in found.numbers}["K"] == pytest.approx(0.08, rel=0.05)


@pytest.mark.nightly
def test_one_hertz_gaps_and_a_heading_alone_give_a_model(rng):
    """A slow craft sampled twice in L/U, rows missing in the middle, no gyro, no speed but positions."""
    craft = draw(rng, "flow")
    records = []
    for i in range(3):
        record = sailed(rng, craft, f"run {i}", noise=0.3).with_channels(yaw_rate_rad_s=None, surge_m_s=None)
        kept = np.r_[np.arange(0, record.n // 2), np.arange(record.n // 2 + 90, record.n)]
        channels = {name: values[kept][::5] for name, values in record.channels.items()}
        records.append(type(record)(record.time_s[kept][::5], channels, record.name, record.meta))
    found = build(records[:2], records[2:])
    horizon = f"{found.ahead.horizons_s[1]:.3g} s"
    straight = next(s for s in found.ahead.simple if (s.model, s.horizon) == (STRAIGHT, horizon))
    assert found.ahead.score("heading_rad", BUILT, horizon=horizon).rmse < 0.5 * straight.rmse


def test_what_leaves_the_training_records_is_told_and_stillness_is_refused(rng):
    craft = draw(rng, "race")
    record = sailed(rng, craft, "run", length=30.0)
    backing = record.with_channels(propeller_rps=-record.column("propeller_rps"))
    assert outside([record], record) == [] and any("revolutions" in told for told in outside([record], backing))
    still = record.with_channels(rudder_command_rad=np.zeros(record.n))
    with pytest.raises(CannotFit, match="never moves"):
        build([still])


def test_which_law_is_tried_first_decides_nothing(rng, monkeypatch):
    """A craft of thrusters, and a rudder in a steady race, which has as many numbers."""
    records = calm(rng, draw(rng, "thruster"))[0]
    scales = scales_of(records)
    chosen = []
    for laws in (ladders.LAWS, ladders.LAWS[::-1]):
        monkeypatch.setattr(ladders, "LAWS", laws)
        ladder = Ladder(pieces_of(records, scales), scales, measured_by_all(records, scales), commands=True)
        chosen.append(climb(ladder).final)
    assert [final.law.id for final in chosen] == ["thruster", "thruster"]
    assert chosen[0].score == pytest.approx(chosen[1].score, abs=1e-6)
