"""Base models that are wrong themselves."""

import numpy as np
import pytest

from helmbench.bench.kinds.diagnosis.bases import BASES, base_model, carried
from helmbench.models.model import resolve


@pytest.mark.parametrize("share", [5, 10, 20])
def test_coefficients_are_off_by_what_the_name_says(share, rng):
    true, base = resolve("mariner").coefficients, base_model(f"off-{share}", "mariner", rng).coefficients
    error = base[true != 0.0] / true[true != 0.0] - 1.0
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.01 * share, rel=0.4)
    assert np.max(np.abs(error)) <= 0.02 * share + 1e-12
    assert np.all(base[true == 0.0] == 0.0)


@pytest.mark.parametrize("vessel", ["mariner", "s175", "kvlcc2-l7", "response-1"])
def test_one_nonlinear_term_is_dropped(vessel, rng):
    true, base = resolve(vessel), base_model("dropped", vessel, rng)
    changed = np.flatnonzero(true.coefficients != base.coefficients)
    assert changed.size == 1 and base.coefficients[changed[0]] == 0.0


def test_a_propeller_of_another_diameter(rng):
    true, base = resolve("s175"), base_model("particulars", "s175", rng)
    (i,) = np.flatnonzero(true.constants != base.constants)
    assert true.constant_names[i] == "D_P"


def test_ships_that_cannot_have_a_base_are_left_out():
    assert not carried("dropped", "cargo") and not carried("particulars", "mariner")
    assert not carried("other-family", "response-1") and all(carried(text, "s175") for text in BASES)


def test_another_family_is_identified_from_the_same_ship(rng):
    base = base_model("other-family", "kvlcc2-l7", rng)
    assert base.family == "nomoto-1-cubic" and np.isfinite(base.coefficients).all()
