"""Compact tables hold what the stored ones do, in a fraction of the memory; parameters are put together over seeds."""

import numpy as np
import pandas as pd
import pytest

from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.store import Store, frames, read_tables
from helmbench.reporting.leaderboard import standings
from helmbench.reporting.leaderboard.board import summarised
from helmbench.reporting.leaderboard.compact import LONG, read_compact


@pytest.fixture
def runs(run_of, parameter_of, rng):
    """Two methods, two noises, four seeds and two parameters with made-up errors; one run has failed."""
    found = []
    for method in ("b", "a"):
        for noise in ("low", "high"):
            for seed in range(4):
                errors = rng.lognormal(-3.0, size=2)
                rows = [parameter_of(name, 2.0, 2.0 + e, 0.05) for name, e in zip("TK", errors, strict=True)]
                found.append(run_of(error=0.1, method=method, noise=noise, seed=seed, parameters=rows))
    return [*found, run_of(method="c", noise="low", seed=0, status="failed", reason="no luck")]


@pytest.fixture
def folder(runs, tmp_path):
    """A store of the runs, its tables not written yet."""
    with Store.create(tmp_path / "out", {"suite": "made-up", "version": "0", "planned": len(runs)}) as store:
        for run in runs:
            store.append(run)
    return tmp_path / "out"


@pytest.mark.parametrize("written", [False, True])
def test_values_are_those_of_the_store(folder, written):
    if written:
        with Store.resume(folder) as store:
            store.write_tables()
    for own, stored in zip(read_compact(folder), read_tables(folder), strict=True):
        assert len(own) == len(stored) and {"method", "vessel", "noise", "seed"} <= set(own)
        for name in own:
            expected = stored[name].eq(True) if own[name].dtype == bool else stored[name]
            expected = expected.astype(own[name].dtype) if own[name].dtype == np.float32 else expected
            assert own[name].astype(object).where(own[name].notna(), None).tolist() == (
                expected.astype(object).where(expected.notna(), None).tolist()
            )


def test_texts_are_categories_in_alphabetical_order_and_the_same_in_both_tables(folder):
    runs, parameters = read_compact(folder)
    assert list(runs["method"].cat.categories) == ["a", "b", "c"] == list(parameters["method"].cat.categories)
    assert (runs["noise"].cat.categories == parameters["noise"].cat.categories).all()
    assert set(parameters) == set(LONG)


def test_a_parameter_row_takes_less_than_a_hundred_bytes(run_of, parameter_of, tmp_path):
    rows = [parameter_of(f"p{i}", 2.0, 2.1, 0.05) for i in range(200)]
    found = [run_of(error=0.1, method=m, seed=s, parameters=rows) for m in "ab" for s in range(5)]
    with Store.create(tmp_path / "out", {"suite": "made-up", "version": "0", "planned": len(found)}) as store:
        for run in found:
            store.append(run)
        store.write_tables()
    _, parameters = read_compact(tmp_path / "out")
    columns = [
        parameters[name].cat.codes if parameters[name].dtype == "category" else parameters[name] for name in LONG
    ]
    assert len(parameters) == 2000 and sum(column.memory_usage(index=False) for column in columns) < 100 * 2000


def test_parameters_are_put_together_over_seeds(runs):
    _, parameters = frames(runs, kind_of(IDENTIFICATION).tables)
    found = summarised(parameters)
    keys = [*standings.CELL, "label", "parameter"]
    assert len(found) == 8 and found[keys].equals(found[keys].sort_values(keys))
    for _, row in found.iterrows():
        own = parameters[
            (parameters["method"] == row["label"])
            & (parameters["noise"] == row["noise"])
            & (parameters["parameter"] == row["parameter"])
        ]
        error = own["estimate"] - 2.0
        assert row["seeds"] == 4 and row["first_seed"] and row["judged"]
        assert (row["bound"], row["square"]) == pytest.approx((0.05**2, np.mean(error**2)))
        assert row["first_estimate"] == own.loc[own["seed"] == 0, "estimate"].item()


def test_no_parameters_give_an_empty_table(run_of):
    run = run_of(status="failed", reason="no luck")
    _, parameters = frames([run | {"parameters": []}], kind_of(IDENTIFICATION).tables)
    assert summarised(parameters).empty


def test_methods_of_other_variants_have_labels_of_their_own():
    frame = pd.DataFrame({"method": ["rls", "ls", "rls"], "variant": ["corrected", "corrected", "as_printed"]})
    found = standings.labels(frame)
    assert found.tolist() == ["rls", "ls", "rls (as_printed)"] and found.sort_values().tolist() == [
        "ls",
        "rls",
        "rls (as_printed)",
    ]
