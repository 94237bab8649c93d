"""euler-ls: A1 and A2 of paper 001 on Mariner, corrected and with the printed normal equations."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

MODEL = resolve("mariner-model")


@pytest.fixture(scope="module")
def euler():
    return [generate(Case("mariner-model", text + "@euler")) for text in MODEL.suite["train"]]


def worst(records, **options):
    found = make("euler-ls", **options).fit(records, MODEL)
    return float(np.abs(found.coefficients - MODEL.coefficients).max()), found


def test_a1_recovers_all_sixty_coefficients(euler):
    assert len(MODEL.coordinates) == 60
    assert worst(euler)[0] < 1e-13


def test_a2_recovers_all_sixty_coefficients(euler):
    error, found = worst(euler, algorithm="A2")
    assert error < 1e-9
    assert worst(euler[:1], algorithm="A2")[0] < 1e-9
    assert found.extra["condition"] > 1e7


def test_a2_fails_only_through_the_normal_equations(euler):
    """15 deg zigzag of the paper: the condition of A2 is squared; A1 allows for the normal equations."""
    assert worst(euler[:1], algorithm="A2", variant="as_printed")[0] > 0.05
    assert worst(euler[:1], variant="as_printed")[0] < 1e-7


def test_differences_of_continuous_records_are_biased():
    """RK4 records: A1 misses by tens of per cent in the median (published 18), A2 by more than 100."""
    record = generate(Case("mariner-model", "zigzag:15/15", dt_s=0.1, duration_s=400))
    true = MODEL.coefficients != 0.0
    median = {}
    for algorithm in ("A1", "A2"):
        found = worst([record], algorithm=algorithm)[1]
        median[algorithm] = np.median(np.abs(found.coefficients / np.where(true, MODEL.coefficients, 1.0) - 1.0)[true])
    assert 0.05 < median["A1"] < 1.0 < median["A2"]


@pytest.mark.parametrize("algorithm", ["A1", "A2"])
def test_other_3dof_models(algorithm):
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "zigzag:20/20@euler"))
    found = make("euler-ls", algorithm=algorithm).fit([record], model)
    assert found.coefficients == pytest.approx(model.coefficients, rel=1e-7)


@pytest.mark.parametrize("algorithm", ["A1", "A2"])
def test_standard_errors_are_those_of_the_noise_on_the_equations(algorithm, rng):
    """Process noise on Euler records made by hand: errors are as large as the stated ones."""
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "zigzag:20/20@euler", duration_s=60))
    z = []
    for _ in range(20):
        noisy = {}
        for name in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s"):
            values = record.column(name)
            noisy[name] = values + 1e-9 * np.std(values) * rng.normal(size=values.size)
        found = make("euler-ls", algorithm=algorithm).fit([record.with_channels(**noisy)], model)
        z.append((found.coefficients - model.coefficients) / np.sqrt(np.diag(found.covariance)))
    assert 0.05 < np.sqrt(np.mean(np.square(z))) < 2.0


def test_it_is_for_3dof_models():
    with pytest.raises(CannotFit, match="3-DOF"):
        make("euler-ls").fit([generate(Case("response-1", "zigzag:20/20"))], resolve("response-1"))
    with pytest.raises(BadInput):
        make("euler-ls,algorithm=A3")
