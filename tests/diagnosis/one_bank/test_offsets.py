"""The zero of the rudder that belongs to a record: named with its record, and expected of others only where all have
it."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.one_bank.answer import common_part
from helmbench.models.coefficient_groups import values_of, with_values
from helmbench.models.model import resolve

ZERO = float(np.deg2rad(2.0))


@pytest.mark.parametrize(
    ("own", "records", "expected"),
    [
        ((ZERO,), 1, ZERO),
        ((ZERO,), 3, 0.0),
        ((0.03, -0.03), 3, 0.0),
        ((0.02, 0.021, 0.019), 3, 0.02),
        ((0.02, 0.021), 2, 0.0205),
    ],
)
def test_a_further_record_has_the_mean_where_it_differs_from_zero(own, records, expected):
    assert common_part(own, records) == pytest.approx(expected)


@pytest.mark.nightly
def test_a_zero_that_is_off_in_one_record_is_named_beside_a_base_that_is_off(rng):
    """Records that are left out have none of it: neither is their error larger, nor is the name withdrawn."""
    ship = resolve("kvlcc2-l7")
    clean = inject(FaultCase("kvlcc2-l7"), rng)
    off = inject(FaultCase("kvlcc2-l7", effects=(Effect("rudder_offset", {"delta0": ZERO}),)), rng)
    base = with_values(ship, {n: x * f for (n, x), f in zip(values_of(ship).items(), (1.05, 0.96) * 99, strict=False)})
    found = diagnose(base, [*clean.train, replace(off.train[0], name="off")], clean.held_out)
    print(found.verdict, found.causes, found.gain["heading_rad"])
    (offset,) = [f for f in found.causes if f.cause == "rudder_offset"]
    sizes = {s.record: s for s in offset.sizes}
    assert sizes["off"].value == pytest.approx(ZERO, rel=0.2)
    assert all(abs(s.value) < 0.3 * ZERO for name, s in sizes.items() if name != "off")
    assert found.gain["heading_rad"].rmse_after < 1.05 * found.gain["heading_rad"].rmse_before


@pytest.mark.parametrize(
    ("vessel", "name", "factor", "group"),
    [
        ("mariner", "Nr", 0.7, "linear yaw moment of the hull"),
        pytest.param("kvlcc2-l7", "w_P0", 1.3, "wake fraction and thrust deduction", marks=pytest.mark.nightly),
        pytest.param("kvlcc2-l7", "I_zz", 1.6, "mass, its centre of gravity", marks=pytest.mark.nightly),
    ],
)
def test_a_neutral_angle_does_not_hide_the_one_wrong_number(vessel, name, factor, group, rng):
    """Together they look like many wrong numbers."""
    ship, angle = resolve(vessel), float(np.deg2rad(1.0))
    made = inject(FaultCase(vessel, effects=(Effect("rudder_offset", {"delta0": angle}),)), rng)
    right = values_of(ship)[name]
    found = diagnose(with_values(ship, {name: factor * right}), made.train, made.held_out)
    print(found.verdict, found.causes)
    causes = {f.cause: f for f in found.causes}
    assert set(causes) == {"rudder_offset", "base_coefficients"}
    assert causes["rudder_offset"].sizes[0].value == pytest.approx(angle, rel=0.1)
    assert causes["base_coefficients"].details["groups"][0].startswith(group)
    (size,) = causes["base_coefficients"].sizes
    assert size.parameter == name and size.value == pytest.approx(right, rel=0.1)


def test_a_zero_in_one_record_is_judged_with_the_own_trim_of_others(rng):
    """A held-out record has none of it, and the exact model needs nothing else: no force is told beside it."""
    clean = inject(FaultCase("mariner"), rng)
    off = inject(FaultCase("mariner", effects=(Effect("rudder_offset", {"delta0": ZERO}),)), rng)
    found = diagnose(resolve("mariner"), [*clean.train, replace(off.train[0], name="off")], clean.held_out)
    print(found.verdict, found.causes, found.remaining)
    (offset,) = found.causes
    assert offset.cause == "rudder_offset" and found.remaining == ()
    assert {s.record: s.value for s in offset.sizes}["off"] == pytest.approx(ZERO, rel=0.1)


@pytest.mark.parametrize("vessel", ["mariner", "kvlcc2-l7"])
def test_a_steady_force_beside_a_base_that_may_be_inexact_is_named(vessel, rng):
    case = inject(FaultCase(vessel, ("constant_force",), "large"), rng)
    found = diagnose(resolve(vessel), case.train, case.held_out)
    print(found.verdict, [(f.cause, f.tied_with) for f in found.causes])
    assert any("constant_force" in (f.cause, *f.tied_with) for f in found.causes)
