"""Prior standard deviations of numbers that are zero, or whose size says nothing of how well they are known."""

import numpy as np
import pytest

from helmbench.models.coefficient_groups import GROSS, groups_of, parts_of, with_values
from helmbench.models.model import resolve


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
        assert slip.sd == {"x_G": pytest.approx(GROSS * 0.07)} and slip.of == "inertia"
    assert np.isfinite(list(group_of(model, "inertia").every.values())).all()
