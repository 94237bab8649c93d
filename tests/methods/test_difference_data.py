"""Records made by explicit Euler are recovered by the forward scheme, to rounding or to what a prior costs."""

import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve

BOTH = ("response-1", "kvlcc2-l7")
WITHIN = [
    *(("response-1", f"{name},p0=1e12", "parameters", 1e-3) for name in ("fci-ls", "mi-rls", "nmi-rls")),
    *(("response-1", name, "parameters", 1e-8) for name in ("huber", "tukey", "lts")),
    *(
        (vessel, text, "coefficients", 1e-4)
        for vessel in BOTH
        for text in ("ridge,penalty=0", "tls", "tls,scaling=unit")
    ),
]
"""Ship, method, what is compared, relative difference; of the first ones the prior has an effect."""


@pytest.mark.parametrize(("vessel", "text", "compared", "within"), WITHIN)
def test_exact_on_difference_data(vessel, text, compared, within):
    model, record = resolve(vessel), generate(Case(vessel, "zigzag:20/20@euler"))
    found = make(f"{text},scheme=forward").fit([record], model)
    assert getattr(found, compared) == pytest.approx(getattr(model, compared), rel=within)
