"""Errors of a craft's sensors are found before a model is built, in records of a simulator of the tests."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.diagnosis.craft.build import build
from helmbench.diagnosis.craft.sensors import behind_sensors
from helmbench.estimation.run.run import run_along, squares_of
from helmbench.reporting import media
from helmbench.reporting.craft import page

from ...simulators.craft import draw, sailed


@pytest.fixture
def records(rng):
    """Three records of a craft with two thrusters."""
    craft = draw(rng, "thruster")
    return [sailed(rng, craft, f"run {i}", noise=0.2, length=45.0, weather=0.0) for i in range(3)]


def with_gyro(record, gain=1.0, bias=0.0):
    return record.with_channels(yaw_rate_rad_s=gain * record.column("yaw_rate_rad_s") + bias)


def test_nothing_is_found_in_records_that_are_right(records):
    seen = behind_sensors(records[:2], records[2:])
    assert not seen.findings and not seen.instruments and not seen.notes
    assert seen.train == records[:2] and seen.held_out == records[2:]


def test_a_gain_of_the_gyro_is_none_of_the_craft(records):
    read = [with_gyro(r, 1.1) for r in records]
    seen = behind_sensors(read[:2], read[2:])
    (finding,) = seen.findings
    assert finding.cause == "yaw_rate_scale" and finding.sizes[0].value == pytest.approx(0.1, abs=0.01)
    for back, true in zip([*seen.train, *seen.held_out], records, strict=True):
        assert np.allclose(back.column("yaw_rate_rad_s"), true.column("yaw_rate_rad_s"), rtol=0.01, atol=1e-4)


def test_the_model_of_a_craft_shows_what_its_gyro_reads(records):
    read = [with_gyro(r, 1.1) for r in records]
    built, right = (build(own[:2], own[2:]) for own in (read, records))
    assert built.model.instruments["yaw_rate_scale"] == pytest.approx(0.1, abs=0.01)
    errors = [
        squares_of([run_along(model, record) for record in own])["yaw_rate_rad_s"].scores()[1]
        for model, own in ((built.model, read), (right.model, records))
    ]
    assert errors[0] == pytest.approx(errors[1], abs=0.02)
    assert "Found in the records themselves, and corrected: yaw rate scale" in media.terminal(page(built))


def test_a_column_of_one_record_with_the_other_sign_is_corrected_and_told_with_it(records):
    """A heading that counts to the other side; the track says so."""
    wrong = records[1].with_channels(heading_rad=-records[1].heading_unwrapped())
    seen = behind_sensors([records[0], wrong], records[2:])
    (finding,) = seen.findings
    assert finding.cause == "channel_sign" and finding.details["records"] == [wrong.name]
    turned = [np.sign(np.nanmean(r.column("yaw_rate_rad_s") * np.gradient(r.heading_unwrapped()))) for r in seen.train]
    assert turned == [1.0, 1.0]


@pytest.mark.parametrize("which", [0, 2])
def test_a_record_whose_command_has_the_other_sign_is_turned(records, which):
    name = "rudder_command_rad" if records[0].has("rudder_command_rad") else "rudder_rad"
    other = records[which].with_channels(**{name: -records[which].column(name)})
    read = [other if i == which else r for i, r in enumerate(records)]
    seen = behind_sensors(read[:2], read[2:])
    assert [note.partition(":")[0] for note in seen.notes] == [records[which].name]
    back = [*seen.train, *seen.held_out][which]
    assert np.array_equal(back.column(name), records[which].column(name))


def test_a_craft_that_turns_late_has_its_command_the_right_way_round(rng):
    craft = replace(draw(rng, "thruster"), delay=0.0)
    records = [sailed(rng, craft, f"run {i}", noise=0.2, length=45.0, weather=0.0) for i in range(3)]
    late = max(1, round(0.4 * craft.time * craft.clock / records[0].dt))
    name = "rudder_command_rad" if records[0].has("rudder_command_rad") else "rudder_rad"
    read = [r.with_channels(**{name: np.roll(r.column(name), -late)}).slice(0, r.n - late) for r in records]
    assert not behind_sensors(read[:2], read[2:]).notes
