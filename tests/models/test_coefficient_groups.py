"""Prior standard deviations of numbers that are zero, or whose size says nothing of how well they are known."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.models.coefficient_groups import GROSS, groups_of, parts_of, values_of, with_values
from helmbench.models.model import resolve
from helmbench.models.parameter_checks import unusual_numbers


def group_of(model, name):
    return next(group for group in groups_of(model) if group.id == name)


@pytest.mark.parametrize(
    ("vessel", "group", "name", "like"),
    [("mariner", "hull_nonlinear", "Nvvr", "Nvvv"), ("kvlcc2-l7", "hull_nonlinear", "Y_vvr", "Y_vrr")],
)
def test_a_term_that_was_forgotten_may_be_as_large_as_one_like_it(vessel, group, name, like):
    model = resolve(vessel)
    known = model.parameters
    assert group_of(model, group).sd[name] == pytest.approx(0.4 * abs(known[name]))
    assert group_of(with_values(model, {name: 0.0}), group).sd[name] == pytest.approx(0.4 * abs(known[like]))


def test_a_slip_of_the_centre_of_gravity_is_a_share_of_the_length():
    model = resolve("kvlcc2-l7")
    for place_m in (0.2436, 0.0348, -0.2436, 0.0):
        inertia = group_of(with_values(model, {"x_G": place_m}), "inertia")
        assert inertia.slips["x_G"] == pytest.approx(0.07) and "x_G" not in inertia.sd
        (slip,) = [part for part in parts_of(inertia) if "x_G" in part.sd]
        half_range = 0.06 * 7.0  # m, of x_G = -.06 to .06 L of ships
        assert slip.sd == {"x_G": pytest.approx(max(GROSS * 0.07, half_range))} and slip.of == "inertia"
    assert np.isfinite(list(group_of(model, "inertia").every.values())).all()


@pytest.mark.parametrize(
    ("name", "group"), [("m_y", "inertia"), ("N_r", "hull_yaw_linear"), ("Y_v", "hull_sway_linear")]
)
def test_a_number_alone_may_be_wrong_by_half_of_the_range_that_ships_have_whatever_its_value(name, group):
    model = resolve("kvlcc2-l7")
    value = values_of(model)[name]
    sds = []
    for factor in (1.0, 0.1, 0.01):
        whole = group_of(with_values(model, {name: factor * value}), group)
        (part,) = [part for part in parts_of(whole) if name in part.sd]
        sds.append(part.sd[name])
        assert whole.sd[name] == pytest.approx(0.2 * abs(factor * value))  # beside others it is a share of its value
        assert part.low[name] <= factor * value <= part.high[name] and np.isfinite(part.low[name] + part.high[name])
    assert sds == pytest.approx([sds[0]] * 3) and sds[0] > 0.5 * abs(value)


def test_numbers_that_hardly_any_ship_has_are_told_with_what_is_usual():
    model = resolve("s175")
    assert unusual_numbers(model) == [] and unusual_numbers(resolve("nomoto-1")) == []
    slip = with_values(model, {"m_y": values_of(model)["m_x"]})
    assert unusual_numbers(slip) == ["m_y of the model is 0.000238: 0.000792 to 0.0127 is usual, 0.1 to 1.6 of m'"]


def test_a_base_of_two_speeds_or_of_the_other_side_of_the_rudder_is_told():
    model = resolve("mariner")
    (speed,) = unusual_numbers(with_values(model, {"U0": 15.0}))
    assert speed == "U0 of the model is 15 m/s, and the speed that it states 7.718: they are one speed"
    (side,) = unusual_numbers(replace(model, positive_rudder="starboard"))
    assert side.startswith("a positive rudder angle turns the model to port, and the model says starboard")
