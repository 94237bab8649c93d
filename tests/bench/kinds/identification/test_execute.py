"""One run: what becomes a row."""

import dataclasses
import json
import time

import numpy as np
import pytest

from helmbench.bench.journal import sealed, unsealed
from helmbench.bench.kinds.identification import execute as executing
from helmbench.bench.kinds.identification.columns import PARAMETER_COLUMNS, result_columns
from helmbench.bench.kinds.identification.execute import execute
from helmbench.models.errors import CannotFit, FitFailed

from ....made_up.suites import own_method_file, spec_of


@pytest.fixture
def own_method(tmp_path):
    return own_method_file(tmp_path)


def test_a_run_fills_the_columns_of_the_tables():
    run = execute(spec_of())
    row = run["row"]
    assert (row["status"], row["error"], row["diverged"], row["n_samples"]) == ("ok", None, False, 1001)
    assert set(row) <= set(result_columns())
    assert row["r2_free_heading_rad"] > 0.99 and row["rmse_one_yaw_rate_rad_s"] < row["rmse_free_yaw_rate_rad_s"]
    assert row["rel_error_median"] <= row["rel_error_max"] and row["crb_z_rms"] > 1.0
    assert row["wall_s"] > 0 and row["cpu_s"] > 0 and 20 < row["peak_memory_mib"] < 4000
    assert [entry["parameter"] for entry in run["parameters"]] == ["T", "K", "alpha"]
    assert all(row.keys() | entry.keys() >= set(PARAMETER_COLUMNS) for entry in run["parameters"])
    assert json.loads(unsealed(sealed(run).rstrip()))["key"] == spec_of().key


@pytest.mark.parametrize(
    ("outcome", "status", "error"),
    [
        ("good", "ok", None),
        ("not-applicable", "not_applicable", "no sway in the record"),
        ("failed", "failed", "singular"),
        ("bug", "failed", "KeyError: 'missing'"),
    ],
)
def test_whatever_a_method_does_becomes_a_row(own_method, outcome, status, error):
    run = execute(spec_of(f"{own_method},outcome={outcome}"))
    assert (run["row"]["status"], run["row"]["error"]) == (status, error)
    assert bool(run["parameters"]) == (status == "ok")


def test_a_record_that_cannot_be_made_becomes_a_row():
    run = execute(spec_of(disturbance="wind:10@0deg"))
    assert run["row"]["status"] == "failed" and "wind" in run["row"]["error"]


def test_methods_are_never_given_the_truth(monkeypatch):
    seen = []

    class CoefficientNotes:
        def fit(self, records, model):
            seen.append(model.coefficients.copy())
            raise CannotFit("only looking")

    monkeypatch.setattr(executing, "make", lambda *_: CoefficientNotes())
    monkeypatch.setattr(executing, "_WARMED", set())
    execute(spec_of())
    assert len(seen) == 2 and all(np.isnan(coefficients).all() for coefficients in seen)


def test_a_fit_that_did_not_converge_says_so(monkeypatch):
    from helmbench.methods.registry import make

    class Tired:
        def fit(self, records, model):
            return dataclasses.replace(make("ls").fit(records, model), converged=False, message="ran out of steps")

    monkeypatch.setattr(executing, "make", lambda *_: Tired())
    row = execute(spec_of())["row"]
    assert (row["status"], row["error"]) == ("ok", "not converged: ran out of steps")


def test_time_is_that_of_the_fit_alone(monkeypatch):
    class Slow:
        def fit(self, records, model):
            time.sleep(0.2)
            raise FitFailed("slept")

    monkeypatch.setattr(executing, "make", lambda *_: Slow())
    row = execute(spec_of())["row"]
    assert 0.2 <= row["wall_s"] < 2.0 and row["cpu_s"] < 0.15


def test_noise_free_euler_records_are_recovered_to_rounding():
    row = execute(spec_of("ls-forward", noise="none", train=("zigzag:20/20@euler",)))["row"]
    assert row["rel_error_max"] < 1e-10 and row["train"] == "zigzag:20/20@euler"
