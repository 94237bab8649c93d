"""What the causes of the bank change in the model."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.causes.registry import cause as cause_of
from helmbench.diagnosis.causes.registry import testable as bank_of
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.models.model import resolve


@pytest.mark.parametrize("vessel", ["response-1", "response-2", "cargo"])
def test_the_shift_of_a_published_parameter_moves_it_alone(vessel):
    model = resolve(vessel)
    est = estimator(model, [generate(Case(vessel, "zigzag:20/20", "low", seed=1))])
    shift_of = cause_of("coefficient_shift")
    shifts = {shift_of.details(est, v)["coefficient"]: v[0] for v in bank_of(est)[0][shift_of]}
    before = dict(zip(model.parameter_names, model.to_parameters(model.coefficients), strict=True))
    assert set(shifts) == {name for name, value in before.items() if value != 0.0} - {"K"}
    for name, shift in shifts.items():
        moved = est.at(est.start(), shift, 0.1).vectors[0]
        after = model.to_parameters(np.array([moved[est.index[c]] for c in model.coordinates]))
        ratio = {n: value / before[n] for n, value in zip(model.parameter_names, after, strict=True) if before[n]}
        assert ratio == pytest.approx({n: 1.1 if n == name else 1.0 for n in ratio}, rel=1e-9)
