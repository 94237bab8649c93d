"""The vessel files as data: complete, consistent, integrated finely enough, with suites that can be sailed."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate
from helmbench.models.vessel import read_vessel, vessel_files

FAMILIES = {
    "cargo": "nomoto-2",
    "esso-osaka-l3": "mmg-low-speed",
    "kvlcc2-l7": "mmg",
    "mariner": "abkowitz",
    "mariner-model": "abkowitz",
    "patrol": "nomoto-2",
    "remus": "sway-yaw",
    "remus-kt": "kt",
    "response-1": "nomoto-1-cubic",
    "response-2": "nomoto-2-cubic",
    "s175": "mmg-son-nomoto",
    "s175-polynomial": "mmg-fixed-speed",
}
TOP = {
    "id", "title", "family", "source", "positive_rudder", "speed_m_s", "n0_rps", "max_step_s", "particulars",
    "parameters", "constants", "rudder", "controller", "windage", "suite",
}  # fmt: skip
KEYS = {
    "rudder": {"max_deg", "rate_deg_s", "lag_s", "source"},
    "controller": {"kp", "kd", "source"},
    "suite": {"dt_s", "duration_s", "execute_s", "train", "held_out", "note"},
}
WINDAGE = {
    "sinusoidal": {"form", "A_F_m2", "A_L_m2", "cx", "cy", "cn", "rho_air", "source"},
    "blendermann": {"form", "A_F_m2", "A_L_m2", "CDt", "CDl_AF", "delta", "rho_air", "source"},
}
UNITS = {
    "1", "m", "m2", "m3", "L", "s", "s2", "1/s", "1/s2", "1/s3", "s2/rad2", "m/s",
    "kg", "kg m", "kg m2", "kg/m", "kg/m3", "kg/rad", "kg m/rad", "kg m2/rad", "kg/(m rad)",
}  # fmt: skip
TRAINING_SAMPLES = 4100


def facts(name):
    return read_vessel(vessel_files()[name])


def test_the_vessels_and_their_families():
    assert {name: facts(name)["family"] for name in vessel_files()} == FAMILIES


@pytest.mark.parametrize("name", FAMILIES)
def test_every_number_has_unit_and_source_and_no_key_is_unknown(name):
    vessel = facts(name)
    assert set(vessel) == TOP
    for block in ("particulars", "parameters", "constants"):
        for key, entry in vessel[block].items():
            assert set(entry) == {"value", "unit", "source"}, key
            assert isinstance(entry["value"], float) and entry["unit"] in UNITS and len(entry["source"]) > 5, key
    for block, keys in KEYS.items():
        assert vessel[block] is None or set(vessel[block]) == keys
    windage = vessel["windage"]
    assert windage is None or set(windage) == WINDAGE[windage["form"]]


@pytest.mark.parametrize("name", FAMILIES)
def test_parameters_stand_in_the_order_and_units_of_the_family(name):
    vessel, model = facts(name), resolve(name)
    assert tuple(vessel["parameters"]) == model.parameter_names
    assert tuple(entry["unit"] for entry in vessel["parameters"].values()) == model.parameter_units
    assert tuple(vessel["constants"]) == model.constant_names
    assert len(model.coordinates) == {
        "abkowitz": 60,
        "mmg": 20,
        "mmg-low-speed": 12,
        "mmg-son-nomoto": 36,
        "mmg-fixed-speed": 36,
    }.get(vessel["family"], len(model.coordinates))


@pytest.mark.parametrize("name", FAMILIES)
def test_a_number_given_twice_is_the_same(name):
    vessel = facts(name)
    constants = {key: entry["value"] for key, entry in vessel["constants"].items()}
    for key, entry in vessel["particulars"].items():
        assert constants.get(key, entry["value"]) == entry["value"], key
    assert constants.get("U0", vessel["speed_m_s"]) == vessel["speed_m_s"]


@pytest.mark.parametrize(("name", "nabla"), [("mariner", 16630.0), ("mariner-model", 1.0642)])
def test_mariner_displacement_and_inertia(name, nabla):
    particulars, constants = resolve(name).particulars, facts(name)["constants"]
    mass, x_g = 0.00798, -0.023
    assert particulars["nabla"] == pytest.approx(nabla)
    assert 0.5 * mass * particulars["L"] ** 3 == pytest.approx(nabla, rel=1e-4)
    derived = [mass + 0.00042, mass + 0.00748, mass * x_g + 9.354e-5, mass * x_g - 4.646e-5, 0.000392 + 0.000438]
    np.testing.assert_allclose([constants[key]["value"] for key in ("m11", "m22", "m23", "m32", "m33")], derived)


def test_s175_derived_numbers():
    vessel = facts("s175")
    parameters = {key: entry["value"] for key, entry in vessel["parameters"].items()}
    assert vessel["constants"]["f_alpha"]["value"] == pytest.approx(6.13 * 1.8219 / (1.8219 + 2.25), rel=1e-9)
    assert parameters["CP"] == pytest.approx(1 - 0.175) and parameters["CRv"] == pytest.approx(1 + 0.237)
    assert parameters["CRr"] == pytest.approx(-0.5 - 0.237 * 0.48)
    assert parameters == {key: entry["value"] for key, entry in facts("s175-polynomial")["parameters"].items()}


@pytest.mark.parametrize("name", FAMILIES)
def test_the_suite_can_be_sailed_and_holds_other_manoeuvres_out(name):
    suite = resolve(name).suite
    train, held_out = list(suite["train"]), list(suite["held_out"])
    assert train and held_out and not set(train) & set(held_out)
    assert all(parse_manoeuvre(text).text == text for text in train + held_out)
    samples = 0
    for text in train + held_out:
        record = generate(Case(name, text))
        heading, rudder = record.heading_unwrapped(), np.rad2deg(record.rudder())
        assert np.ptp(heading) > np.deg2rad(3.0) and np.max(np.abs(heading)) < 2.0 * np.pi
        assert 2.0 < np.max(np.abs(rudder)) <= facts(name)["rudder"]["max_deg"] + 1e-9
        assert not record.has("surge_m_s") or np.min(record.column("surge_m_s")) > 0.0
        samples += record.n * (text in train)
    assert samples <= TRAINING_SAMPLES


@pytest.mark.parametrize("name", FAMILIES)
def test_the_positive_rudder_turns_to_the_side_it_says(name):
    model = resolve(name)
    rudder = inputs_of(model, np.full(21, 0.05 * model.starboard))
    states = simulate(model, rudder, model.suite["dt_s"], initial_state(model))
    assert states[-1, model.states.index("psi")] > 0.0


def integration_error(name, text, step_s):
    """Largest error of a state in a manoeuvre of the suite, as a share of its range, by a step against a 16th of it.

    North and east count as one channel, of the larger range: their axes are arbitrary.  A step above the suite's
    sampling time is taken with as slow a sampling, which it may be used with.
    """
    model = resolve(name)
    record = generate(Case(name, text, dt_s=max(step_s, float(model.suite["dt_s"]))))
    rudder, start = inputs_of(model, record.rudder()), initial_state(model)
    found, exact = (
        simulate(replace(model, max_step_s=step), rudder, record.dt, start) for step in (step_s, step_s / 16)
    )
    error, span = np.abs(found - exact).max(axis=0), np.ptp(exact, axis=0)
    place = [i for i, state in enumerate(model.states) if state in ("x", "y")]
    span[place] = span[place].max(initial=0.0)
    return np.max(error / np.where(span > 0.0, span, 1.0))


@pytest.mark.parametrize("name", FAMILIES)
def test_the_largest_step_errs_by_1e_5_of_the_range_at_most_and_is_not_needlessly_fine(name):
    suite, step = resolve(name).suite, resolve(name).max_step_s
    texts = [*suite["train"], *suite["held_out"]]
    assert max(integration_error(name, text, step) for text in texts) < 1e-5
    assert not max(integration_error(name, text, 4.0 * step) for text in texts) < 1e-5
