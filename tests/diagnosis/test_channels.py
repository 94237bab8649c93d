"""The sensors' stage of a diagnosis: no hull model takes part."""

import numpy as np
import pytest

from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.diagnosis.causes.registry import cause
from helmbench.diagnosis.options import Options
from helmbench.diagnosis.prepared import Prepared, corrected_records
from helmbench.models.model import resolve

from ..expectations.injections import injected


def test_a_bias_is_found_and_removed_from_all_records(rng):
    case = injected("mariner", ("yaw_rate_bias",), rng)
    found = Prepared(case.train, case.held_out).compared()
    truth = case.truth[0]["parameters"]["b"]
    print(truth, found.findings)
    assert [f.cause for f in found.findings] == ["yaw_rate_bias"]
    assert found.removed["yaw_rate_bias"] == pytest.approx(truth, rel=0.2)
    for before, after in zip((*case.train, *case.held_out), (*found.train, *found.held_out), strict=True):
        moved = before.column("yaw_rate_rad_s") - after.column("yaw_rate_rad_s")
        assert np.nanmean(moved) == pytest.approx(truth, rel=0.4)


def test_sound_sensors_leave_the_records_as_they_are(rng):
    case = injected("mariner", (), rng)
    found = Prepared(case.train, case.held_out).compared()
    assert found.findings == () and found.removed == {}
    assert all(a.column("heading_rad") is b.column("heading_rad") for a, b in zip(case.train, found.train, strict=True))


def test_only_chosen_causes_are_looked_for(rng):
    case = injected("mariner", ("yaw_rate_bias",), rng)
    assert Prepared(case.train, []).compared({cause("rudder_offset")}).findings == ()


def test_a_scale_that_no_sensor_has_is_not_told(rng):
    """A yaw rate ten times too large: its column is in another unit, or another channel's."""
    records = [
        r.with_channels(yaw_rate_rad_s=10.0 * r.column("yaw_rate_rad_s")) for r in injected("mariner", (), rng).train
    ]
    found = Prepared(records, []).compared()
    print(found.findings)
    assert found.findings == () and found.removed == {}
    assert all(
        a.column("yaw_rate_rad_s") is b.column("yaw_rate_rad_s") for a, b in zip(records, found.train, strict=True)
    )


def test_sizes_of_other_signs_are_none_of_the_instrument(rng):
    """An offset of the sway to starboard in one record and to port in another; a gyro's zero may do that."""
    records = injected("mariner", (), rng).train
    sway = 0.03 * float(np.nanmean(records[0].column("surge_m_s")))
    leaning = [
        r.with_channels(sway_m_s=r.column("sway_m_s") + b) for r, b in zip(records, (sway, -sway, 0.0), strict=True)
    ]
    found = Prepared(leaning, []).compared()
    print(found.findings)
    assert found.findings == () and found.removed == {}
    zero = 0.1 * float(np.nanstd(records[0].column("yaw_rate_rad_s")))
    drifting = [
        r.with_channels(yaw_rate_rad_s=r.column("yaw_rate_rad_s") + b)
        for r, b in zip(records, (zero, -zero, 0.0), strict=True)
    ]
    assert [f.cause for f in Prepared(drifting, []).compared().findings] == ["yaw_rate_bias"]


def test_one_size_that_differs_leaves_the_others_as_they_are(rng):
    """A sway offset of another sign in each record and one scale of the speed in all: the scale is found."""
    records = injected("mariner", (), rng).train
    sway = 0.03 * float(np.nanmean(records[0].column("surge_m_s")))
    both = [
        r.with_channels(surge_m_s=1.03 * r.column("surge_m_s"), sway_m_s=1.03 * r.column("sway_m_s") + b)
        for r, b in zip(records, (sway, -sway, 0.0), strict=True)
    ]
    found = Prepared(both, []).compared()
    print(found.findings)
    (scale,) = [f for f in found.findings if f.cause == "speed_scale"]
    assert scale.sizes[0].value == pytest.approx(0.03, abs=0.006)


def turns(rng):
    """Circles and zigzags of the Mariner with the noise of usual sensors."""
    out = []
    for text in ("turn:20:starboard", "turn:15:port", "zigzag:20/20", "turn:25:port"):
        run = record_run(resolve("mariner"), parse_manoeuvre(text), duration_s=900, dt_s=1.0)
        sd = {"heading_rad": 2e-3, "yaw_rate_rad_s": 2e-4, "surge_m_s": 0.02, "sway_m_s": 0.02}
        noisy = {name: run.column(name) + size * rng.normal(size=run.n) for name, size in sd.items()}
        places = {name: run.column(name) + 2.0 * rng.normal(size=run.n) for name in ("north_m", "east_m")}
        out.append(run.with_channels(**noisy, **places))
    return out


def deviating(record):
    """A compass with a deviation of up to three degrees."""
    psi = record.heading_unwrapped()
    return record.with_channels(heading_rad=psi + np.deg2rad(2.5) * np.cos(psi) - np.deg2rad(1.5) * np.sin(psi))


def of_a_mast(record):
    """Positions of an antenna .4 of a ship length ahead."""
    psi, ahead = record.heading_unwrapped(), 64.0
    north, east = record.column("north_m") + ahead * np.cos(psi), record.column("east_m") + ahead * np.sin(psi)
    return record.with_channels(north_m=north, east_m=east)


def late(record):
    """Positions that are late by eight samples."""
    shifted = {c: np.concatenate([record.column(c)[:1]] * 8 + [record.column(c)[:-8]]) for c in ("north_m", "east_m")}
    return record.with_channels(**shifted)


@pytest.mark.parametrize(
    ("wrong", "told", "column"),
    [
        (deviating, "compass_deviation", "heading_rad"),
        (of_a_mast, "reference_point", "north_m"),
        (late, "position_delay", "north_m"),
    ],
)
def test_errors_that_no_instrument_of_a_model_holds_are_told_and_corrected(wrong, told, column, rng):
    """As `check` tells them: in training records, and with the mean sizes in a held-out one."""
    true = turns(rng)
    bare = true[0].with_channels(**dict.fromkeys(("heading_rad", "north_m", "east_m")))
    found = Prepared([wrong(r) for r in true[:-1]], [wrong(true[-1]), bare]).compared()
    print(found.findings)
    assert told in {f.cause for f in found.findings}
    last, same = found.held_out
    assert set(same.channels) == set(bare.channels)
    for record, back in zip(true, [*found.train, last], strict=True):
        left, was = (np.nanstd(r.column(column) - record.column(column)) for r in (back, wrong(record)))
        assert left < 0.4 * was


def test_a_yaw_rate_made_from_the_heading_is_not_compared_with_it(rng):
    """Backward differences are late by half a step, and say nothing of a gyro."""

    def differenced(record):
        psi = record.heading_unwrapped()
        return record.with_channels(yaw_rate_rad_s=np.diff(psi, prepend=psi[0]) / record.dt)

    records, model = [differenced(r) for r in turns(rng)], resolve("mariner")
    given = corrected_records(model, records, (), Options().checked(model))
    print(given.derived)
    assert all("yaw_rate_rad_s" in given.derived[r.name] for r in given.train)
    errors = given.behind_sensors(None).decided
    assert "yaw_rate_delay" not in errors and "reference_point" in errors
