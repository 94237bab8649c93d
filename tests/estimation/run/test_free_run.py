"""Residuals of free runs."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.records.series import series_of
from helmbench.estimation.simulation import free_run
from helmbench.models.model import resolve
from helmbench.models.simulate import simulate


@pytest.mark.parametrize("vessel", ["response-2", "mariner"])
def test_stretches_make_no_difference(vessel, monkeypatch):
    record, model = generate(Case(vessel, "zigzag:20/20", "medium", seed=3)), resolve(vessel)
    series = series_of(record, model)
    run = simulate(model, series.inputs, series.dt, free_run.start_state(model, series, series.start))
    monkeypatch.setattr(free_run, "STRETCH", 7)
    found = free_run.residuals(model, series, series.start)
    assert np.array_equal(found, series.outputs - run[:, series.columns])
