"""Timings of what the benchmark spends its time on; figures are stored (`--benchmark-json`), never asserted.

Every registered method is timed on a response model and on a 3-DOF model, so a new one needs no edit here.  A method
that does not apply, or fails, is timed until it says so.
"""

import contextlib

import numpy as np
import pytest

from helmbench.bench.kinds.identification.execute import execute
from helmbench.bench.kinds.identification.plan import RunSpec
from helmbench.bench.kinds.identification.problems import Task, problem
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import read_record, write_record
from helmbench.methods.registry import make, methods
from helmbench.models.errors import CannotFit, FitFailed
from helmbench.models.lanes import open_loops
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, sensitivities, simulate

SIMULATED = ("response-2", "mariner", "kvlcc2-l7", "s175")
FITTED = ("response-2", "mariner")
RUNS = 64


@pytest.fixture(params=SIMULATED)
def ship(request):
    """Model, inputs (N+1, nu), step and initial state of a 20/20 zigzag."""
    model = resolve(request.param)
    record = generate(Case(request.param, "zigzag:20/20"))
    return model, inputs_of(model, record.rudder()), record.dt, initial_state(model)


def task(vessel):
    """The first training record of a vessel's suite with medium noise."""
    model = resolve(vessel)
    train, held_out = (tuple(model.suite[key][:1]) for key in ("train", "held_out"))
    return Task(vessel, vessel, model.family, train, held_out, noise="medium")


def test_simulation_scalar(benchmark, ship):
    benchmark(simulate, *ship)


def test_simulation_lanes(benchmark, ship):
    model, inputs, dt, start = ship
    coefficients, batch, starts = (np.stack([value] * RUNS) for value in (model.coefficients, inputs, start))
    benchmark.extra_info["runs"] = RUNS
    benchmark(open_loops, model, coefficients, batch, dt, starts)


def test_simulation_sensitivities(benchmark, ship):
    benchmark.extra_info["columns"] = len(ship[0].coordinates)
    benchmark(sensitivities, *ship)


@pytest.mark.parametrize("vessel", FITTED)
@pytest.mark.parametrize("name", methods())
def test_fit(benchmark, name, vessel):
    known = problem(task(vessel))
    records, method = list(known.train), make(name)

    def fit():
        with contextlib.suppress(CannotFit, FitFailed):
            method.fit(records, known.model)

    benchmark.extra_info["samples"] = known.n_samples
    benchmark.pedantic(fit, rounds=5, warmup_rounds=1)


def test_suite_row(benchmark):
    spec = RunSpec("timing", "ls-forward", "corrected", "ls-forward", task("mariner"))
    benchmark(execute, spec)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_record_writing(benchmark, tmp_path, suffix):
    record = generate(Case("mariner", "zigzag:20/20", "medium"))
    benchmark.extra_info["samples"] = record.n
    benchmark(write_record, record, tmp_path / f"record{suffix}")


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_record_reading(benchmark, tmp_path, suffix):
    path = tmp_path / f"record{suffix}"
    write_record(generate(Case("mariner", "zigzag:20/20", "medium")), path)
    benchmark(read_record, path)
