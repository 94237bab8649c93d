"""Terms that a response model lacks, planted by the tests' own integrator: free runs of left-out records name them."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.record import Record, RecordMeta
from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.diagnose import diagnose, identified
from helmbench.diagnosis.innovations.diagnose import PREDICTS_WORSE, concluded, selected
from helmbench.diagnosis.options import Options
from helmbench.diagnosis.prepared import Prepared
from helmbench.diagnosis.report.bank import DECIDED
from helmbench.models.coefficient_groups import every_own_number, groups_of, grown
from helmbench.models.model import model_to_json, resolve

from ..expectations.injections import passes

IDENTIFIED = Options(base_parameters="identify")
DT = 0.5
GAIN, TIME = 0.05, 20.0
"""K, 1/s, and T, s, of the ship."""


def zigzag(rng, angle, heading, cubic=0.0, second=0.0, loss=0.0, late=0.0, late_rate=0.0, seconds=400.0):
    """Free-running zigzag of T2 T r'' + (T + T2) r' + r + cubic r^3 = K delta at a speed that turning takes off,
    heading and yaw rate late by so many seconds."""
    fine, n = 0.05, int(seconds / DT)
    r = q = psi = slow = rudder = 0.0
    order = np.deg2rad(angle)
    rows = []
    for i in range(n * int(DT / fine)):
        rows.append((i * fine, rudder, psi, r))
        if order * psi > 0.0 and abs(psi) > np.deg2rad(heading) and order * rudder > 0.0:
            order = -order
        rudder += min(max(order - rudder, -0.05 * fine), 0.05 * fine)
        speed = 1.0 - slow
        wanted = (GAIN * speed**2 * rudder - speed * r - cubic * r**3) / TIME
        q = wanted if second == 0.0 else q + fine * (wanted - (1.0 + second / TIME) * q) / second
        r, psi = r + fine * q, psi + fine * (r + 0.5 * fine * q)
        slow += fine * (loss * r**2 - slow) / 60.0
    time, rudder, psi, r = np.array(rows).T
    at = np.arange(0, time.size, int(DT / fine))
    of_heading, of_rate = (np.maximum(at - round(tau / fine), 0) for tau in (late, late_rate))
    channels = {
        "rudder_rad": rudder[at],
        "heading_rad": psi[of_heading] + np.deg2rad(0.1) * rng.normal(size=n),
        "yaw_rate_rad_s": r[of_rate] + np.deg2rad(0.02) * rng.normal(size=n),
    }
    return Record(time[at], channels, f"zigzag {angle:g}/{heading:g}", RecordMeta(positive_rudder="starboard"))


def runs(rng, **terms):
    pairs = [(10.0, 10.0), (20.0, 20.0), (25.0, 5.0), (-10.0, 10.0), (-20.0, 10.0), (35.0, 20.0)]
    return [zigzag(rng, *pair, **terms) for pair in pairs]


@pytest.mark.parametrize(
    ("family", "terms", "names"),
    [
        ("nomoto-1", {"cubic": 400.0}, {"yaw_damping_cubic", "yaw_damping_quadratic"}),
        pytest.param(
            *("nomoto-1", {"cubic": 400.0, "late": 0.15}, {"yaw_damping_cubic", "yaw_damping_quadratic"}),
            marks=pytest.mark.nightly,
        ),
        pytest.param("nomoto-1", {"second": 6.0}, {"second_order_lead"}, marks=pytest.mark.nightly),
    ],
)
def test_a_term_that_is_lacking_is_named_and_held_out_records_gain(family, terms, names, rng, tmp_path):
    """Also beside a heading that is late by less than matters, and by no multiple of the sampling step."""

    def named():
        records = runs(rng, **terms)
        found = diagnose(resolve(family), records[:-1], records[-1:], Options(base_parameters="identify"))
        print(found.verdict, found.reason, found.causes, found.gain)
        model_to_json(found.extended, tmp_path / "extended.json")
        assert resolve(tmp_path / "extended.json").family == found.extended.family
        told = {f.cause for f in found.causes if f.stage != "kinematics"}
        gain = found.gain["yaw_rate_rad_s"]
        gained = gain.rmse_after < 0.7 * gain.rmse_before
        return found.verdict in ("named", "tied", "partly_named") and bool(told) and told <= names and gained

    assert passes(named, 0.95)


@pytest.mark.parametrize(
    ("late", "cause"),
    [("late", "heading_delay"), pytest.param("late_rate", "yaw_rate_delay", marks=pytest.mark.nightly)],
)
def test_a_late_channel_is_named_and_hides_no_term(late, cause, rng):
    """Behind the sensors' errors the noise is as white as it was: it is not taken for an effect."""

    def named():
        records = runs(rng, **{"cubic": 400.0, late: float(rng.uniform(0.5, 1.2))})
        found = diagnose(resolve("nomoto-1"), records[:-1], records[-1:], Options(base_parameters="identify"))
        print(found.verdict, found.reason, found.causes)
        told = {f.cause for f in found.causes}
        damping = told & {"yaw_damping_cubic", "yaw_damping_quadratic"}
        return found.verdict in ("named", "tied", "partly_named") and cause in told and bool(damping)

    assert passes(named, 0.75)


@pytest.mark.nightly
def test_free_runs_name_what_is_lacking(rng):
    """Damping and a second time constant at once, each by its own cause."""

    def named():
        found = diagnose(resolve("nomoto-1"), runs(rng, cubic=400.0, second=6.0), (), IDENTIFIED)
        print(found.verdict, found.causes)
        names = {f.cause for f in found.causes}
        damping = names & {"yaw_damping_cubic", "yaw_damping_quadratic"}
        return "second_order_lead" in names and bool(damping) and found.verdict in ("named", "tied")

    assert passes(named, 0.95)


def test_nothing_is_lacking_where_the_family_is_right(rng):
    found = diagnose(resolve("nomoto-1"), runs(rng), (), IDENTIFIED)
    print(found.verdict, found.causes)
    assert found.causes == () and found.verdict == "adequate"


@pytest.mark.nightly
def test_speed_that_turning_takes_off_is_found(rng):
    """The loss stands in no channel: it shows in the yaw rate alone."""
    found = diagnose(resolve("nomoto-1"), runs(rng, loss=1500.0), (), IDENTIFIED)
    print(found.verdict, found.causes)
    assert "speed_loss" in {name for f in found.causes for name in (f.cause, *f.tied_with)}


def test_priors_scale_with_the_ship():
    """A ship 25 times as long is five times as slow (Froude): priors follow by their powers of time."""
    small = resolve("nomoto-1-cubic").with_coefficients(np.array([-0.1, 0.02, -5.0]))
    large = small.with_coefficients(np.array([-0.02, 0.02 / 25.0, -25.0]))
    for one, other in zip(groups_of(small), groups_of(large), strict=True):
        assert one.id == other.id
        ratio = {name: other.sd[name] / sd for name, sd in one.sd.items()}
        wanted = {"a": 0.2, "b": 0.04, "c": 5.0, "added_Nrrr": 5.0, "lead_T2": 5.0, "loss_gain": 25.0, "loss_time": 5.0}
        assert ratio == pytest.approx({name: wanted.get(name, 1.0) for name in ratio})


def test_terms_that_come_along_start_at_their_prior_means():
    model = resolve("nomoto-1").with_coefficients(np.array([-0.05, 0.0025]))
    groups = {g.id: g for g in groups_of(model)}
    whole = grown(model, [groups["second_order"], groups["speed_loss"]])
    values = dict(zip(whole.coordinates, whole.coefficients.tolist(), strict=True))
    assert values == pytest.approx({"a": -0.05, "b": 0.0025, "lead": 0.0, "lead_T2": 5.0} | LOSS)
    assert every_own_number(groups.values()).sd == pytest.approx({"a": 0.05, "b": 0.0025})


LOSS = {"loss_gain": 0.0, "loss_time": 80.0, "loss_power": 1.5}


@pytest.mark.nightly
def test_causes_that_the_sensors_decided_on_are_not_named_by_a_model(rng):
    records = runs(rng, cubic=400.0)
    decided = {*Prepared(records, []).compared().tested}
    assert {"yaw_rate_scale", "yaw_rate_bias", "heading_delay"} <= decided <= set(ids())
    found = diagnose(resolve("nomoto-1"), records, options=Options(base_parameters="identify"))
    entries = {entry.cause: entry for entry in found.bank}
    assert all(entries[name].why == DECIDED for name in decided if entries[name].status == "not_testable")
    assert not [f.cause for f in found.causes if f.cause in decided and f.stage == "dynamics"]
    assert entries["yaw_rate_scale"].why == DECIDED


@pytest.mark.nightly
def test_a_cause_that_whole_records_refuse_is_told_and_not_in_the_extended_model(rng):
    records = runs(rng, cubic=400.0)[:3]
    options = Options(base_parameters="identify").checked(resolve("nomoto-1"))
    model, given = identified(resolve("nomoto-1"), records), Prepared(records, [])
    shown = replace(selected(model, given, options), left=None)
    found = concluded(model, given, options, shown, shown.state.causes)
    names = {cause.id for cause in shown.state.causes}
    print(names, found.verdict, found.reason, found.extended.family)
    assert names and names == {f.cause for f in found.causes}
    assert found.verdict == "unexplained" and PREDICTS_WORSE in found.reason
    assert found.extended.family == "nomoto-1"


def ids():
    return [c.id for c in causes().values()]
