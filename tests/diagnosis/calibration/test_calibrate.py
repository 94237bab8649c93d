"""Which numbers of a base model are wrong: changes are found, an exact base stays as it is."""

import json
from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets import measured
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.calibration.calibrate import calibrate
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.gain.guard import WORSE
from helmbench.estimation.run.run import run_along
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import model_to_json, resolve

from ...expectations.calibrations import CALIBRATED, SHIP, altered
from ...expectations.injections import injected, passes
from ...nightly_marks import nightly_but


@pytest.fixture(scope="module")
def ship():
    return resolve(SHIP)


@pytest.fixture
def found(calibrated):
    """Of a ship with 25 % more resistance and a common neutral rudder angle of 1 deg."""
    return calibrated[2]


def test_changes_are_named_with_their_sizes(found):
    moved = {m.name: m for m in found.moved}
    print(found.moved, found.steps)
    named = {name for step in found.steps for name in (step.group, *step.tied_with)}
    assert {"resistance", "neutral_rudder_angle"} <= named
    assert found.verdict == "named"
    assert moved["rudder_offset"].after == pytest.approx(np.deg2rad(1.0), abs=np.deg2rad(0.3))
    assert moved["rudder_offset"].low < moved["rudder_offset"].after < moved["rudder_offset"].high


WRONG = [("kvlcc2-l7", {"R_0": 1.3}), ("s175", {"Nur": 0.7}), ("mariner", {"Nd": 0.75})]
"""Ships, and factors on numbers of the base model."""


@pytest.mark.parametrize("case", nightly_but(WRONG, WRONG[1]), ids=str)
def test_calibrate_and_diagnose_give_the_same_sizes_where_numbers_are_wrong(case, rng):
    vessel, factors = case
    base, records = resolve(vessel), injected(vessel, (), rng)
    parameters = {name: factors.get(name, 1.0) * value for name, value in base.parameters.items()}
    wrong = base.with_coefficients(base.from_parameters(parameters))
    found, said = (one(wrong, records.train, records.held_out[:1]) for one in (calibrate, diagnose))
    sizes = {s.parameter: (s.value, s.low, s.high) for f in said.causes for s in f.sizes}
    print(found.moved, sizes)
    assert {m.name: (m.after, m.low, m.high) for m in found.moved} == sizes and {*factors} <= {*sizes}
    assert (found.verdict, found.worse) == (said.verdict, ())
    assert np.array_equal(found.extended.theta, said.extended.theta)
    assert {c: g.rmse_after for c, g in said.gain.items() if c in found.after} == {
        c: e for c, (_, e) in found.after.items()
    }


@pytest.mark.parametrize("expected", nightly_but(CALIBRATED), ids=[one.name for one in CALIBRATED])
def test_rate_of_what_is_promised(expected, rng):
    """`make rates` draws each more often."""
    assert passes(lambda: expected.check(rng), expected.rate)


def test_left_out_and_held_out_errors_fall(found):
    for column in ("surge_m_s", "yaw_rate_rad_s", "heading_rad"):
        for before, after in zip(found.before[column], found.after[column], strict=True):
            assert after < 0.5 * before
    assert found.worse == ()


def test_shares_add_up(found):
    for share in found.shares.values():
        assert share.coefficients + share.trim + share.noise + share.remaining == pytest.approx(1.0)
    assert found.shares["surge_m_s"].coefficients > 0.8


def test_the_extended_model_gives_the_told_errors_when_it_is_read_again(calibrated, tmp_path):
    _, held, found = calibrated
    model_to_json(found.extended, tmp_path / "extended.json")
    again = resolve(tmp_path / "extended.json")
    ship = resolve(SHIP)
    for model, told in ((again, found.after), (ship, found.before)):  # the same as `validate` tells of both
        errors = run_along(model, held).squares()
        for column in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s", "heading_rad"):
            assert errors[column].scores()[0] == pytest.approx(told[column][1], rel=1e-6)


def test_errors_with_the_records_own_trim_are_told_beside(found):
    """The common neutral angle of 1 deg is taken off by an angle of the record's own; the resistance is not."""
    heading, surge = found.own["heading_rad"], found.own["surge_m_s"]
    assert heading[0] < 0.8 * found.before["heading_rad"][1]
    assert surge[1] < 0.3 * surge[0] and surge[0] == pytest.approx(found.before["surge_m_s"][1], rel=0.2)


def test_the_outcome_is_plain_data(found):
    document = json.loads(json.dumps(found.to_json()))
    assert document["verdict"] == "named" and document["model"] == "kvlcc2-l7"
    assert [step["group"] for step in document["steps"]] == [step.group for step in found.steps]
    assert len(document["next_runs"]) == 3


def test_records_of_an_independent_simulator_are_adequate(rng):
    case = inject(FaultCase("mariner", duration_s=600.0, dt_s=2.0), rng)
    found = calibrate(resolve("mariner"), case.train)
    print(found.moved, found.steps)
    assert found.moved == () or max(step.gain for step in found.steps) < 0.3


@pytest.mark.nightly
def test_records_without_a_heading_and_with_a_long_gap_are_calibrated(ship, rng):
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:20/20"), duration_s=240.0, dt_s=0.2)
    run = apply(run, parse_noise("low"), rng).with_channels(heading_rad=None)
    gap = (run.time_s > 100.0) & (run.time_s < 130.0)
    broken = replace(run, time_s=run.time_s[~gap], channels={k: v[~gap] for k, v in run.channels.items()})
    found = calibrate(ship, [broken])
    assert [one.record for one in found.runs] == [broken.name] and found.next_runs
    assert found.after["surge_m_s"][0] < found.before["surge_m_s"][0]
    behind = found.traces[0].time >= 130.0
    first = (found.traces[0].after["surge_m_s"] - found.traces[0].measured["surge_m_s"])[behind][0]
    assert abs(first) < 0.02  # the run starts anew behind the gap


def test_a_single_run_of_twelve_ship_lengths_is_calibrated(ship, rng):
    run = record_run(altered(ship, 0.4, 0.0), parse_manoeuvre("zigzag:10/10"), duration_s=72.0, dt_s=0.2)
    found = calibrate(ship, [apply(run, parse_noise("low"), rng)])
    assert len(found.runs) == 1
    assert found.after["surge_m_s"][0] <= WORSE * found.before["surge_m_s"][0]


@pytest.mark.nightly
def test_what_cannot_be_calibrated_is_refused(ship):
    short = record_run(ship, parse_manoeuvre("zigzag:10/10"), duration_s=8.0, dt_s=0.2)
    with pytest.raises(CannotFit, match="fewer than 3 pieces"):
        calibrate(ship, [short])
    with pytest.raises(BadInput, match="no training record"):
        calibrate(ship, [])
    with pytest.raises(BadInput, match="no coefficients"):
        calibrate(ship.blanked(), [short])
    with pytest.raises(BadInput, match="states no groups"):
        calibrate(resolve("remus"), [short])


@pytest.mark.nightly
def test_measured_kvlcc2_runs_need_more_thrust(ship):
    """The published simulation pairs a propeller curve with another diameter: more thrust."""
    folder = measured.data_dir() / measured.dataset("kvlcc2-hsva").folder
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")
    stems = ("Z_05_01", "Z_15_05", "Z_20_10_S", "Z_35_05")
    found = calibrate(ship, [measured.load("kvlcc2-hsva", stem).thinned(32) for stem in stems])
    moved = {m.name: m for m in found.moved}
    print(found.steps)
    assert moved["thrust_scale"].after == pytest.approx(0.33, abs=0.04)
    assert found.after["surge_m_s"][0] < 0.7 * found.before["surge_m_s"][0]
