"""A ship from its particulars: against the captive tests of KVLCC2, and what no ship has."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.models.errors import BadInput
from helmbench.models.model import model_from_particulars, resolve
from helmbench.models.particulars import Particulars, added_masses, linear_derivatives, particulars_of
from helmbench.models.simulate import initial_state, inputs_of, simulate

KVLCC2 = Particulars(
    L=7.0, B=1.2688, d=0.455, nabla=3.2724, speed_m_s=1.179, n0_rps=10.2295, A_R=0.0539, H_R=0.345, D_P=0.204,
    pitch_ratio=0.808, x_G=0.2436, rho=1000.0,
)  # fmt: skip
TEXT = (
    "L: 7.0\nB: 1.2688\nd: 0.455\nnabla: 3.2724\nspeed_m_s: 1.179\nn0_rps: 10.2\nA_R: 0.0539\nH_R: 0.345\nD_P: 0.204\n"
)


def turned(model, rudder, seconds=300.0):
    """States of a turn with a constant rudder from a straight course."""
    count = int(seconds / 0.5) + 1
    return simulate(model, inputs_of(model, np.full(count, rudder)), 0.5, initial_state(model))


def test_regressions_are_near_the_captive_tests_of_kvlcc2():
    published = resolve("kvlcc2-l7")
    known = published.parameters | dict(zip(published.constant_names, published.constants.tolist(), strict=True))
    own = added_masses(KVLCC2)
    assert own["m_y"] == pytest.approx(known["m_y"], rel=0.03) and own["J_z"] == pytest.approx(known["J_z"], rel=0.05)
    for source in linear_derivatives(KVLCC2).values():
        assert source["N_v"] == pytest.approx(known["N_v"], rel=0.1)
        assert source["N_r"] == pytest.approx(known["N_r"], rel=0.1)
        assert source["Y_r"] == pytest.approx(known["Y_r"], rel=0.3)
        assert source["Y_v"] == pytest.approx(known["Y_v"], rel=0.35)


def test_a_turning_circle_from_particulars_is_near_that_of_the_published_simulation():
    runs = [turned(model, np.deg2rad(35.0)) for model in (model_from_particulars(KVLCC2), resolve("kvlcc2-l7"))]
    breadths = [np.ptp(run[:, 4]) for run in runs]
    assert runs[0][-1, 2] > 0.0 and breadths[0] == pytest.approx(breadths[1], rel=0.25)
    assert 2.0 * KVLCC2.L < breadths[0] < 5.0 * KVLCC2.L


def test_a_straight_course_keeps_the_stated_speed():
    model = model_from_particulars(KVLCC2)
    assert turned(model, 0.0)[-1, 0] == pytest.approx(KVLCC2.speed_m_s, rel=1e-6)


def test_a_file_of_particulars_is_a_model(tmp_path):
    path = tmp_path / "tanker.yaml"
    path.write_text(TEXT)
    found = resolve(path)
    assert (found.id, found.family, found.particulars["L"], found.known) == ("tanker", "mmg", 7.0, True)


def test_the_files_of_vessels_state_particulars_or_too_few_of_them():
    stated = particulars_of(resolve("kvlcc2-l7"))
    assert stated == replace(KVLCC2, pitch_ratio=0.8, title=resolve("kvlcc2-l7").title)
    stated = particulars_of(resolve("s175"))
    assert (stated.B, stated.A_R, stated.H_R, stated.n0_rps) == pytest.approx((25.4, 33.0376, 7.758, 1.27338), rel=1e-5)
    assert particulars_of(resolve("mariner")) is None and particulars_of(resolve("nomoto-1")) is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TEXT + "beam: 3\n", "unknown beam"),
        (TEXT.replace("D_P: 0.204\n", ""), "missing D_P"),
        (TEXT.replace("0.455", "deep"), "not numbers: d"),
        (TEXT.replace("3.2724", "3272.4"), "C_b"),
        (TEXT.replace("10.2", "1.0"), "no thrust"),
        (TEXT.replace("7.0", "-7.0"), "above 0"),
        ("- 1\n", "no particulars"),
    ],
)
def test_what_no_ship_has_is_told_in_one_line_with_the_file(tmp_path, text, said):
    path = tmp_path / "ship.yaml"
    path.write_text(text)
    with pytest.raises(BadInput, match=said) as caught:
        resolve(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_numbers_that_are_not_finite_are_refused():
    with pytest.raises(BadInput, match="nabla"):
        replace(KVLCC2, nabla=float("nan"))
