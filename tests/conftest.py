"""Fixtures for all rooms."""

import gc
import os
from contextlib import nullcontext
from itertools import count

import hypothesis
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from helmbench.checks.result import Size
from helmbench.datasets import measured, randomness
from helmbench.datasets.generator import Case, generate
from helmbench.models.model import resolve

from .cpu_times import (  # noqa: F401
    pytest_report_header,
    pytest_runtest_makereport,
    pytest_runtest_protocol,
    pytest_terminal_summary,
)
from .made_up.cases import make_case, make_diagnosis
from .made_up.runs import make_parameter, make_run
from .seeds import SHIFT, seed_of
from .shared import board, calibrated, craft, once, run_folder, uncertain  # noqa: F401
from .support.inline_pool import without_workers
from .support.inline_reader import without_processes

# A slow machine is no fault of the code: examples are not timed.
hypothesis.settings.register_profile(
    "tests", deadline=None, derandomize=not SHIFT, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("tests")
# The matrices are small: a second thread waits more than it computes, and takes the other worker's processor.
threadpool_limits(1, user_api="blas")
os.environ.setdefault("OMP_NUM_THREADS", "1")  # of libraries that are loaded later: trees of scikit-learn


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Examples of Hypothesis follow the shift of the seeds."""
    if SHIFT and config.option.hypothesis_seed is None:
        config.option.hypothesis_seed = str(SHIFT)


def pytest_collection_finish():
    """The modules and the tests stay until the end: the garbage collector need not look through them again and again,
    which takes a seventh of the time of tests that compile."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20)


@pytest.fixture
def seed(request) -> int:
    """The seed of this test, by its file and name (see `seeds`)."""
    file, _, name = request.node.location
    return seed_of(f"{file}::{name}")


@pytest.fixture
def rng(seed) -> np.random.Generator:
    """A generator made of the test's seed."""
    return np.random.default_rng(seed)


@pytest.fixture(autouse=True)
def seeds_that_the_program_draws(seed, monkeypatch):
    """Where a user gives no seed the program draws one: in a test these, too, follow from the test's seed."""
    monkeypatch.setattr(randomness, "drawn_seed", count(seed).__next__)


@pytest.fixture
def in_this_process():
    """Suites are executed in this process: for tests whose subject is not the worker processes."""
    with without_workers():
        yield


@pytest.fixture(params=["in this process", pytest.param("in a worker", marks=pytest.mark.nightly)])
def here_or_in_a_worker(request):
    """Suites are executed in this process, by `make test-all` in a worker process as well."""
    with without_workers() if request.param == "in this process" else nullcontext():
        yield


@pytest.fixture
def logs_read_here():
    """Binary logs are read in this process: for tests whose subject is not the processes that read them."""
    with without_processes():
        yield


@pytest.fixture
def suite():
    """(model, training records) of a vessel's suite: suite(vessel, noise='none', euler=False, seed=1)."""

    def make(vessel, noise="none", euler=False, seed=1):
        model = resolve(vessel)
        texts = [text + "@euler" * euler for text in model.suite["train"]]
        return model, [generate(Case(vessel, text, noise, seed=seed)) for text in texts]

    return make


@pytest.fixture
def hsva():
    """Measured KVLCC2 zigzags by stem, rudder positive to starboard."""
    folder = measured.data_dir() / "kvlcc2" / "hsva"
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")
    return lambda stem: measured.load("kvlcc2-hsva", stem).turned("starboard")


@pytest.fixture(scope="session")
def run_of():
    """Factory of stored runs."""
    return make_run


@pytest.fixture
def parameter_of():
    """Factory of parameter rows."""
    return make_parameter


@pytest.fixture(scope="session")
def manifest():
    """Factory of manifests for `planned` runs."""

    def build(planned):
        facts = {"suite": "made-up", "title": "made up", "suite_digest": "0", "version": "0.0.0", "plan_digest": "0"}
        return facts | {"planned": planned, "selection": {"suite": "made-up"}, "seeds": "0", "packages": {"numpy": "2"}}

    return build


@pytest.fixture
def diagnosis_of():
    """Factory of diagnoses."""
    return make_diagnosis


@pytest.fixture
def case_of():
    """Factory of stored cases."""
    return make_case


@pytest.fixture
def size():
    """Factory of sizes."""

    def build(parameter, value, half, record=None, unit="1"):
        return Size(parameter, value, value - half, value + half, unit, record)

    return build


@pytest.fixture
def nan():
    return np.nan
