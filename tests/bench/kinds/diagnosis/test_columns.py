"""Columns of the tables of a diagnosis suite: what plan and judge fill in, and no more."""

import numpy as np

from helmbench.bench.faults import Effect, FaultCase, inject
from helmbench.bench.kinds.base import TIMES
from helmbench.bench.kinds.diagnosis.columns import CASE_COLUMNS, KEYS, SIZE_COLUMNS
from helmbench.bench.kinds.diagnosis.judge import compare, description, gain, judge, regime_scores
from helmbench.bench.kinds.diagnosis.plan import CaseSpec

SPEC = CaseSpec("mine", "innovations", "innovations", "pair", "mariner", ("wind", "current"), "large", "fast", 7)


def test_keys_are_those_of_a_planned_case():
    assert list(SPEC.row_key()) == list(KEYS)
    assert SPEC.row_key()["injected"] == "wind+current"


def test_a_case_fills_every_column_but_none_beside(diagnosis_of):
    filled = {*SPEC.row_key(), *judge(diagnosis_of("wind"), "pair", SPEC.injected), *gain(diagnosis_of()), *TIMES}
    filled |= {
        *description(diagnosis_of(), [Effect("harmonic", {"constants": (1.0, 3.0, 2.0, 0.0, 0.0, 0.0), "size": 0.1})])
    }
    filled |= {"status", "error", "noncentrality", "detectable", "healthy_bias"}
    filled |= set(regime_scores(diagnosis_of(), inject(FaultCase("cargo", duration_s=20.0), np.random.default_rng(0))))
    assert filled <= set(CASE_COLUMNS)
    assert all(name.startswith("rmse_") for name in set(CASE_COLUMNS) - filled)


def test_a_size_fills_every_column(size):
    assert {*KEYS, "cause", *compare(size("speed", 5.0, 1.0), 5.5)} == set(SIZE_COLUMNS)
