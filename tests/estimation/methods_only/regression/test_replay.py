"""Standard errors by simulated sensor noise."""

import numpy as np

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve


def test_standard_errors_of_integrated_equations_are_the_actual_ones():
    """Independent errors would make them 8 to 14 times too small; 16 draws give a standard deviation to a fifth."""
    model = resolve("response-2")
    found = []
    for seed in range(16):
        record = generate(Case("response-2", "zigzag:20/20", "medium", seed=seed))
        found.append(make("ls", scheme="triple-integral").fit([record], model))
    actual = np.std([fit.coefficients for fit in found], axis=0)
    stated = np.median([np.sqrt(np.diag(fit.covariance)) for fit in found], axis=0)
    print(actual / stated)
    assert (actual / stated > 0.4).all() and (actual / stated < 2.0).all()
