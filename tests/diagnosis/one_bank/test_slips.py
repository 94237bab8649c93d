"""A number of the base model that hardly any ship has, by a mistaken unit: what is usual takes its place first."""

from dataclasses import replace

import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.sensors import parse_noise
from helmbench.diagnosis.diagnose import diagnose
from helmbench.models.coefficient_groups import values_of, with_values
from helmbench.models.model import resolve


@pytest.mark.parametrize(
    ("vessel", "number", "factor"),
    [
        ("mariner", "U0", 1.944),
        ("kvlcc2-l7", "x_G", 15.3),
        pytest.param("kvlcc2-l7", "I_zz", 23.7, marks=pytest.mark.nightly),
    ],
)
def test_a_number_in_another_unit_is_named_alone_with_its_size(vessel, number, factor, rng):
    """U0 in knots; an inertia in lb ft2; a centre of gravity from the aft perpendicular: about it the inertia is below
    zero, and a positive rudder turns such a model to port."""
    ship = resolve(vessel)
    right = values_of(ship)[number]
    case = inject(FaultCase(vessel, ()), rng)
    found = diagnose(with_values(ship, {number: factor * right}), case.train, case.held_out)
    (wrong,) = found.causes
    size = {s.parameter: s for s in wrong.sizes}
    assert wrong.cause == "base_coefficients" and [*size] == [number]
    assert size[number].value == pytest.approx(right, rel=0.15)
    assert size[number].low < right < size[number].high
    assert values_of(found.extended)[number] == pytest.approx(right, rel=0.15)
    gain = found.gain["heading_rad"]
    assert gain.own_after < 0.1 * gain.own_before


def test_an_unusual_ship_is_no_mistake():
    """A ship whose inertia is four times the usual one, and a model that has it."""
    ship = resolve("kvlcc2-l7")
    unusual = with_values(ship, {"I_zz": 4.0 * values_of(ship)["I_zz"]})
    texts = ("zigzag:20/20", "turn:25", "zigzag:10/10")
    sensors = parse_noise("low")
    records = [
        replace(record_run(unusual, parse_manoeuvre(t), sensors, seed=i, duration_s=200.0, dt_s=0.5), name=t)
        for i, t in enumerate(texts)
    ]
    found = diagnose(unusual, records[:2], records[2:])
    assert found.verdict == "adequate" and not found.causes
