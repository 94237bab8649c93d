"""Records that were made under other conditions than the rest are told apart, and the rest is diagnosed."""

from dataclasses import replace

import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.coefficient_groups import values_of, with_values
from helmbench.models.model import resolve

HEAVIER = Effect("loading_change", {"fraction": 0.25})


def records(rng, *effects):
    """Records of a ship by a simulator of its own."""
    return inject(FaultCase("kvlcc2-l7", effects=effects), rng)


def is_mass(causes, factor):
    """Whether the one cause is the mass of the record that is loaded by a factor, within 10 %."""
    (own,) = causes
    volume = next(size for size in own.sizes if size.parameter == "nabla")
    usual = values_of(resolve("kvlcc2-l7"))["nabla"]
    of_record = own.details["records"] == ["loaded"] and volume.record == "loaded"
    return of_record and own.details["groups"][0].startswith("mass") and abs(volume.value / usual / factor - 1.0) < 0.1


@pytest.mark.nightly
def test_a_record_of_another_loading_is_told_apart(rng):
    own, heavy = records(rng), records(rng, HEAVIER)
    train = [*own.train, replace(heavy.train[0], name="loaded")]
    found = diagnose(resolve("kvlcc2-l7"), train, own.held_out)
    print(found.verdict, found.reason, found.doubts, found.causes)
    assert found.apart == ("loaded",) and found.verdict == "named"
    assert is_mass(found.causes, 1.25) and "loaded" in found.doubts[-1]
    assert found.extended.theta.tolist() == resolve("kvlcc2-l7").theta.tolist()


@pytest.mark.nightly
def test_records_of_one_ship_are_not_told_apart(rng):
    heavy = records(rng, HEAVIER)
    found = diagnose(resolve("kvlcc2-l7"), heavy.train, heavy.held_out)
    assert found.apart == () and found.causes


@pytest.mark.nightly
def test_a_record_is_told_apart_though_others_err_as_well(rng):
    """Beside a base whose rudder is too weak: a fit to all records explains none."""
    own, heavy = records(rng), records(rng, Effect("loading_change", {"fraction": 0.5}))
    weak = with_values(resolve("kvlcc2-l7"), {"f_alpha": 0.75 * values_of(resolve("kvlcc2-l7"))["f_alpha"]})
    found = diagnose(weak, [*own.train, replace(heavy.train[0], name="loaded")], own.held_out)
    print(found.verdict, found.reason, found.doubts, found.causes)
    assert found.apart == ("loaded",)
    rudder, *of_loaded = found.causes
    assert rudder.cause == "base_coefficients" and "rudder" in rudder.details["groups"][0]
    assert is_mass(of_loaded, 1.5)


@pytest.mark.nightly
def test_a_push_in_a_record_that_is_apart_is_described_with_its_time(rng):
    push = Effect("pulse", {"constants": (1.0, 50.0, 2.0, 15.0, 0.0, 0.0), "size": 0.5})
    own, pushed = records(rng), records(rng, push)
    train = [*own.train, replace(pushed.train[0], name="pushed")]
    found = diagnose(resolve("kvlcc2-l7"), train, own.held_out)
    print(found.verdict, found.remaining, found.doubts)
    assert (found.apart, found.verdict, found.causes) == (("pushed",), "adequate", ())
    (force,) = found.remaining
    assert (force.axis, force.depends_on, force.extended) == ("N", ("time",), False)
    assert "pushed" in force.text and "50" in force.text
