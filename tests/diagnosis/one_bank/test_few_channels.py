"""Logs of a bridge: few channels, rounded to a tenth of a degree, cut in a turn; made by a simulator of other code."""

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.bench.kinds.diagnosis.bases import base_model
from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.free_runs.units import length_s, units_of
from helmbench.models.model import resolve

TENTH = np.deg2rad(0.1)
ROUNDED = ("heading_rad", "rudder_rad")


def logged(record, *more, cut_s=0.0):
    """Heading and rudder in tenths of a degree, and more channels, once a second from some time on."""
    late = record.between(float(record.time_s[0]) + cut_s, None)
    late = late.thinned(max(1, round((1.0 if late.dt > 0.3 else 0.2) / late.dt)))
    kept = {name: np.round(late.column(name) / TENTH) * TENTH for name in ROUNDED}
    return late.with_channels(**(dict.fromkeys(late.channels) | kept | {name: late.column(name) for name in more}))


def made(vessel, causes, seed):
    return inject(FaultCase(vessel, causes, "large"), np.random.default_rng(seed))


@pytest.mark.parametrize("vessel", ["mariner", "kvlcc2-l7"])
def test_pieces_start_from_the_speed_and_sway_that_nothing_measures(vessel):
    model, case = resolve(vessel), made(vessel, (), 11)
    records = [logged(record) for record in case.train]
    off = {name: [] for name in ("u", "v")}
    for unit in units_of(model, records, length_s(model, records)):
        whole = case.train[unit.number]
        for name, column in (("u", "surge_m_s"), ("v", "sway_m_s")):
            true = np.interp(unit.grid_s[0], whole.time_s, whole.column(column))
            off[name].append(abs(unit.start[model.states.index(name)] - true) / model.speed_m_s)
    assert max(off["u"]) < 0.03 and np.median(off["v"]) < 0.01 and max(off["v"]) < 0.05


@pytest.mark.nightly
def test_a_right_model_is_adequate_by_heading_and_rudder_alone():
    case = made("mariner", (), 11)
    found = diagnose(resolve("mariner"), [logged(r) for r in case.train], [logged(r) for r in case.held_out])
    assert (found.verdict, found.causes, found.remaining) == ("adequate", (), ())


@pytest.mark.nightly
@pytest.mark.parametrize("vessel", ["mariner", "s175"])
@pytest.mark.parametrize("cause", ["rudder_offset", "rudder_delay", "rudder_effectiveness"])
@pytest.mark.parametrize("more", [(), ("surge_m_s", "yaw_rate_rad_s")], ids=["heading", "speed and rate"])
def test_a_cause_is_named_alone_in_logs_that_begin_in_a_turn(vessel, cause, more):
    cut_s = 80.0 if more else 0.0
    case = made(vessel, (cause,), 12)
    train, held_out = ([logged(r, *more, cut_s=cut_s) for r in own] for own in (case.train, case.held_out))
    found = diagnose(resolve(vessel), train, held_out)
    print(found.verdict, found.reason, found.causes)
    assert [f.cause for f in found.causes] == [cause] and found.verdict in ("named", "tied")
    size, (true,) = found.causes[0].sizes[0].value, case.effects[0].parameters.values()
    assert size == pytest.approx(true, rel=0.05, abs=np.deg2rad(0.05))
    assert found.gain["heading_rad"].rmse_after < 0.5 * found.gain["heading_rad"].rmse_before


@pytest.mark.nightly
@pytest.mark.parametrize("vessel", ["mariner", "s175"])
def test_a_late_heading_is_no_slow_rudder_where_the_speed_tells_them_apart(vessel):
    case, more = made(vessel, ("heading_delay",), 13), ("surge_m_s", "north_m", "east_m")
    train, held_out = ([logged(r, *more) for r in own] for own in (case.train, case.held_out))
    found = diagnose(resolve(vessel), train, held_out)
    assert [f.cause for f in found.causes] == ["heading_delay"] and found.verdict in ("named", "tied")
    (true,) = case.effects[0].parameters.values()
    assert found.causes[0].sizes[0].value == pytest.approx(true, rel=0.05)
    assert found.gain["heading_rad"].rmse_after < 0.2 * found.gain["heading_rad"].rmse_before


@pytest.mark.nightly
def test_an_offset_is_named_by_heading_and_rudder_alone_beside_wrong_numbers():
    """Pieces of eight ship lengths hardly show it; whole free runs do."""
    case = made("mariner", ("rudder_offset",), 21)
    base = base_model("off-10", "mariner", np.random.default_rng(121))
    found = diagnose(base, [logged(r) for r in case.train], [logged(r) for r in case.held_out])
    sizes = {f.cause: f.sizes[0].value for f in found.causes if f.sizes}
    (true,) = case.effects[0].parameters.values()
    assert "rudder_offset" in sizes and all(causes()[name].describes_hull for name in sizes.keys() - {"rudder_offset"})
    assert sizes["rudder_offset"] == pytest.approx(true, rel=0.25)


def test_a_rounded_heading_has_a_step_however_many_values_it_takes(rng):
    from helmbench.checks.integrity.runs import common_step, resolution

    turn = np.cumsum(0.002 * np.ones(900))
    assert common_step(np.round(turn / TENTH) * TENTH) == pytest.approx(TENTH)
    assert common_step(turn + 1e-3 * rng.standard_normal(900)) == resolution(turn) == 0.0
