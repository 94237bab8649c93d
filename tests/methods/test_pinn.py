"""The coefficients of the physics-informed network are those that made the records, with their errors."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods import contract
from helmbench.methods.registry import make
from helmbench.models.model import resolve


@pytest.mark.parametrize(("vessel", "within"), [("response-1", 1e-3), ("remus-kt", 0.03)])
def test_clean_records_give_the_coefficients_that_made_them(vessel, within):
    """Rudder steps of a third of a second leave the REMUS's network a few per cent."""
    model = resolve(vessel)
    records = [generate(Case(vessel, text, "none", seed=1)) for text in model.suite["train"]]
    found = make("pinn").fit(records, model)
    assert found.converged
    assert found.coefficients == pytest.approx(model.coefficients, rel=within)


def test_the_equations_help_where_differences_of_noisy_records_do_not():
    model = resolve("remus-kt")
    record = generate(Case("remus-kt", "zigzag:20/20", "low", seed=1))
    errors = {
        name: np.abs(make(name).fit(record, model).coefficients / model.coefficients - 1.0).max()
        for name in ("ls-forward", "rts-ls", "pinn")
    }
    assert errors["pinn"] < 0.05 < 0.1 < min(errors["ls-forward"], errors["rts-ls"])


@pytest.mark.nightly
def test_standard_errors_are_the_spread_over_records(seed):
    """40 records: the root mean square of (estimate - truth)/error has a relative deviation of 1/sqrt(80) = 11 %."""
    model = resolve("response-1")
    scores = []
    for k in range(40):
        record = generate(Case("response-1", "zigzag:20/20", "medium", seed=seed % 100_000 + k, dt_s=0.5))
        found = make("pinn").fit(record, model)
        scores.append((found.coefficients - model.coefficients) / np.sqrt(np.diag(found.covariance)))
    assert 0.4 < np.sqrt(np.mean(np.square(scores))) < 1.6


def test_unmeasured_states_are_found_too():
    model = resolve("response-1")
    records = [generate(Case("response-1", text, "none", seed=1)) for text in model.suite["train"]]
    found = make("pinn").fit([record.with_channels(yaw_rate_rad_s=None) for record in records], model)
    assert found.coefficients == pytest.approx(model.coefficients, rel=0.01)


def test_what_the_records_leave_open_has_no_finite_error():
    model, (record, _) = contract.sample("response-1")
    straight = record.with_channels(**{name: np.zeros(record.n) for name in record.channels})
    found = contract.fit_or_none(make("pinn,iterations=5"), straight, model)
    assert found is None or not np.isfinite(found.covariance).all()
