"""Records made by explicit Euler are recovered by the forward scheme, to rounding or to what a prior costs."""

import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve

BOTH = ("response-1", "kvlcc2-l7")
WITHIN = [
    *(("response-1", f"{name},p0=1e12", 1e-3) for name in ("fci-ls", "mi-rls", "nmi-rls")),  # only the prior counts
    *(("response-1", name, 1e-8) for name in ("huber", "tukey", "lts")),
    *((vessel, text, 1e-4) for vessel in BOTH for text in ("ridge,penalty=0", "tls", "tls,scaling=unit")),
]


@pytest.mark.parametrize(("vessel", "text", "within"), WITHIN)
def test_exact_on_difference_data(vessel, text, within):
    model, record = resolve(vessel), generate(Case(vessel, "zigzag:20/20@euler"))
    found = make(f"{text},scheme=forward").fit([record], model)
    assert found.coefficients == pytest.approx(model.coefficients, rel=within)
    assert found.parameters == pytest.approx(model.parameters, rel=10.0 * within)
