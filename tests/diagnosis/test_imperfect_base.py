"""A base model whose own numbers are wrong: residuals leave effects unexplained, free runs name the numbers."""

import numpy as np
import pytest

from helmbench.bench.kinds.diagnosis.execute import base_of, injected_of
from helmbench.bench.kinds.diagnosis.plan import CaseSpec
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.causes.base_coefficients import BaseCoefficients
from helmbench.diagnosis.causes.rudder_offset import RudderOffset
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.options import Options
from helmbench.models.coefficient_groups import groups_of
from helmbench.models.model import model_to_json, resolve

from ..expectations.injections import passes
from .documents import faults

MANOEUVRES = ("zigzag:10/10", "zigzag:20/20:port", "turn:20", "zigzag:25/5", "turn:25:port", "zigzag:15/5")


@pytest.fixture
def found(uncertain):
    return uncertain


def test_the_numbers_are_named_with_shares(found):
    print(found.verdict, found.reason, found.causes)
    assert found.verdict in ("named", "partly_named")
    names = {f.cause for f in found.causes}
    assert BaseCoefficients.id in names and names <= {BaseCoefficients.id, RudderOffset.id}
    shares = found.calibration.shares
    assert all(0.0 < s.coefficients <= 1.0 for s in shares.values())
    assert not any(f.stage == "dynamics" for f in found.causes)


def test_held_out_records_gain(found):
    for column in ("surge_m_s", "yaw_rate_rad_s"):
        assert found.gain[column].rmse_after < 0.7 * found.gain[column].rmse_before
        assert found.gain[column].ratio_low < 0.7


def test_the_bank_tells_what_the_residuals_alone_would_have_named(found):
    status = {entry.cause: entry.status for entry in found.bank}
    assert status[BaseCoefficients.id] == "named"
    assert not {name for name, value in status.items() if value == "tied"}


def test_the_document_holds_the_base_models_numbers(found, tmp_path):
    document = found.to_json()
    assert document["schema"] == 2 and faults(document) == []
    assert [m["name"] for m in document["base_coefficients"]["moved"]] == [m.name for m in found.calibration.moved]
    model_to_json(found.extended, tmp_path / "extended.json")
    assert resolve(tmp_path / "extended.json").family == found.extended.family


def test_exact_coefficients_stay_exact_where_that_is_asked(found):
    base = found.model
    records = [record_run(base, parse_manoeuvre(text), duration_s=70.0, dt_s=0.2) for text in MANOEUVRES[:2]]
    rng = np.random.default_rng(2)
    scaled = [
        r.with_channels(yaw_rate_rad_s=r.column("yaw_rate_rad_s") + 2e-3 * np.sin(0.3 * r.time_s)) for r in records
    ]
    noisy = [apply(r, parse_noise("low"), rng) for r in scaled]
    assert diagnose(base, noisy, options=Options(coefficient_sd=0.0)).calibration is None


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "s175", "mariner"])
def test_every_group_of_a_vessel_has_numbers_with_priors(vessel):
    groups = groups_of(resolve(vessel))
    assert len({g.id for g in groups}) == len(groups) >= 8
    assert all(sd > 0.0 for g in groups for sd in g.sd.values())
    names = [name for g in groups for name in g.sd]
    assert len(names) == len(set(names))


@pytest.mark.nightly
def test_coloured_noise_is_not_told_as_a_sensor_error():
    """Residuals named a bias of the yaw rate that the heading does not show; nothing but the base is wrong here."""
    spec = CaseSpec(
        "imperfect", "", "innovations", "null", "cargo", (), "", "none", 5133567584097261, "off-10", "coloured"
    )
    case = injected_of(spec)
    found = diagnose(base_of(spec), case.train, case.held_out)
    print(found.verdict, found.reason, found.causes)
    named = {name for f in found.causes for name in (f.cause, *f.tied_with)}
    assert case.effects == () and named == {BaseCoefficients.id}  # which are off by a tenth


@pytest.mark.nightly
def test_a_number_is_named_that_free_runs_hardly_feel(rng):
    """The lever of the flow at the rudder, 30 % short: free runs are off by less than 5 % of the motion."""

    def named():
        seed = int(rng.integers(2**53))
        wrong = ("kvlcc2-l7", (), "none", "none", seed, "l_R", "five-three")
        spec = CaseSpec("one-bug", "innovations", "innovations", "one-bug", *wrong)
        found = diagnose(base_of(spec), injected_of(spec).train[:3])
        print(seed, found.verdict, found.causes)
        return [m.name for m in found.calibration.moved] == ["l_R"] and found.causes[0].cause == BaseCoefficients.id

    assert passes(named, 0.9)
