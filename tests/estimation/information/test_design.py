"""D-optimality: the gain, and the order of the candidates."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate, record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.estimation.information.bounds import information
from helmbench.estimation.information.design import information_gain
from helmbench.estimation.information.identifiability import identifiability
from helmbench.models.model import resolve


def test_the_gain_is_that_of_the_entropy_of_a_gaussian(rng):
    a, b = (matrix @ matrix.T for matrix in rng.standard_normal((2, 4, 6)))
    volumes = [np.prod(np.sqrt(np.linalg.eigvalsh(np.linalg.inv(m)))) for m in (a, a + b)]
    assert information_gain(a, b) == pytest.approx(np.log(volumes[0] / volumes[1]), rel=1e-8)


def test_candidates_are_ordered_by_what_they_tell():
    model, texts = resolve("response-1"), ["turn:5", "zigzag:20/20", "straight"]
    record = generate(Case("response-1", "zigzag:10/10", "low", seed=1))
    found = identifiability(model, [record], manoeuvres=texts)
    gains = [one.information for one in found.candidates]
    assert gains == sorted(gains, reverse=True) and found.candidates[-1].manoeuvre == "straight"
    best = found.candidates[0].manoeuvre
    bare = replace(model, suite={})  # the rudder is moved at once
    more = record_run(bare, parse_manoeuvre(best), duration_s=float(record.time_s[-1]), dt_s=record.dt)
    scale = np.abs(model.to_parameters(model.coefficients)) * np.linalg.inv(
        model.parameters_jacobian(model.coefficients)
    )
    blocks = [information(model, one, found.noise_sd) @ scale for one in (record, more)]
    now, added = (block.T @ block for block in blocks)
    assert gains[0] == pytest.approx(information_gain(now + np.eye(3), added), rel=1e-3)
