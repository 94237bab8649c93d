"""Settling times and overshoot, against the values for paper 000's protocol."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.judgement.convergence import convergence, overshoot, parameter_paths, settling_time
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve

TRUTH = {"T2": 2.9686, "T1": 2.2256, "K": 2.2071, "T3": 2.2309}
PROTOCOL = {"p0": 1e10, "theta0": 1e-10, "prior": "physical", "scheme": "heading-difference"}


def difference_record():
    """20/20 zigzag of paper 000 by its own difference equation (eq 8), 200 samples of 0.1 s."""
    h, angle = 0.1, np.deg2rad(20.0)
    t2, t1, gain, t3 = TRUTH.values()
    psi, y, delta = np.zeros((3, 201))
    order = angle
    for k in range(1, 201):
        if order * psi[k - 1] > 0.0 and abs(psi[k - 1]) >= angle:
            order = -np.sign(psi[k - 1]) * angle
        delta[k] = order
        before = y[k - 2] if k > 1 else 0.0
        push = h**3 * gain * delta[k] + h**2 * t3 * (delta[k] - delta[k - 1])
        y[k] = (2.0 * y[k - 1] - before + h * t1 * y[k - 1] + push) / (1.0 + h**2 * t2 + h * t1)
        psi[k] = psi[k - 1] + y[k]
    return Record(h * np.arange(201), {"heading_rad": psi, "rudder_rad": delta}, "paper 000")


@pytest.mark.parametrize(
    ("text", "five", "two"),
    [
        ("rls", (1.6, 1.2, 1.8, 0.2), (1.9, 1.7, 1.9, 0.2)),
        ("fw-rls,mu=0.999,weight=20", (0.8, 0.7, 0.9, 0.2), (0.9, 0.9, 1.0, 0.2)),
    ],
)
def test_settling_times_of_paper_000(text, five, two):
    """References p000_RLS and p000_FW, t5 and t2; the first row is at 0.1 s of the record."""
    found = convergence(make(text, **PROTOCOL).fit([difference_record()], resolve("kt")), TRUTH)
    for band, expected in ((0.05, five), (0.02, two)):
        assert [found[name][0][band] + 0.1 for name in TRUTH] == pytest.approx(expected, abs=1e-9)
    assert all(0.0 <= beyond < 2.0 for _, beyond in found.values())


def test_published_parameters_are_followed():
    """T, K and alpha, not the coefficients; the last of the path is the estimate."""
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20"))
    estimate = make("rls").fit([record], model)
    paths = parameter_paths(estimate)
    assert {name: path[-1] for name, path in paths.items()} == pytest.approx(estimate.parameters, rel=1e-9)
    found = convergence(estimate)
    assert set(found) == {"T", "K", "alpha"}
    assert all(settled[0.05] <= settled[0.02] <= record.time_s[-1] for settled, _ in found.values())


def test_settling_time_and_overshoot_of_a_path():
    time = np.arange(6.0)
    path = np.array([0.0, 1.3, 0.9, 1.04, 0.97, 1.01])
    assert settling_time(path, time, 1.0, 0.05) == 3.0
    assert settling_time(path, time, 1.0, 0.02) == 5.0
    assert settling_time(path, time, 1.0, 0.5) == 1.0
    assert settling_time(path, time, 2.0, 0.05) == np.inf
    assert settling_time(np.ones(6), time, 1.0, 0.05) == 0.0
    assert settling_time(np.array([1.0, np.nan, 1.0]), time[:3], 1.0, 0.05) == 2.0
    assert overshoot(path, 1.0) == pytest.approx(0.3)
    assert overshoot(-path, -1.0) == pytest.approx(0.3)
    assert overshoot(path, 2.0) == 0.0


def test_refusals():
    record, model = generate(Case("response-1", "zigzag:20/20")), resolve("response-1")
    with pytest.raises(BadInput, match="trajectory"):
        convergence(make("ls").fit([record], model))
    estimate = make("rls").fit([record], model)
    with pytest.raises(BadInput, match="no parameter"):
        convergence(estimate, {"Q": 1.0})
    with pytest.raises(BadInput, match="positive"):
        convergence(estimate, bands=(0.0,))
    assert "K" not in convergence(estimate, {"K": 0.0, "T": 13.5})
