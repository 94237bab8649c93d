"""Speed against other implementations, both timed in the same run, and how cost grows with the samples.

The table of targets is that of the design; nothing is asserted but that both sides compute the same.
"""

import contextlib
import importlib
import importlib.util
import json
import resource
import subprocess
import sys
import time
import tracemalloc
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares

from helmbench.datasets.generator import Case, generate, record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.estimation.likelihood.minimiser import levenberg_marquardt
from helmbench.estimation.likelihood.problem import Problem
from helmbench.estimation.methods_only import svr
from helmbench.estimation.methods_only.recursive import _kernels as _rls_kernels
from helmbench.estimation.observers import _kernels as observers
from helmbench.estimation.observers.smoothing import random_walk
from helmbench.estimation.records.series import series_of
from helmbench.estimation.simulation import free_run
from helmbench.methods.registry import make, methods
from helmbench.models.errors import CannotFit, FitFailed
from helmbench.models.lanes import open_loops
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate, substeps

from ..models import test_reference_kvlcc2 as reference
from .conftest import Side

pytestmark = pytest.mark.benchmark(timer=time.process_time)
RUNS = 1000
MULTIPLIERS = 10_000
SIZES = (1_000, 10_000, 100_000, 1_000_000)
LONGEST_FIT_S = 10.0
MORE_STEPS = "linear in each iteration; longer records need more of them"
MEMORY = "one pass over the rows, which no longer fit in the processor's caches at the largest size"
CORNERS = "free runs and rows of whole records at 11 corner frequencies, which no longer fit in the processor's caches"
CLOSER = f"{CORNERS}; the corner that is chosen for the longest record keeps more rows a sample"
LIMITS = {
    **dict.fromkeys(("output-error", "pem"), MORE_STEPS),
    **dict.fromkeys(("grey-residual", "grey-gp"), f"output error, which they start from: {MORE_STEPS}"),
    **dict.fromkeys(("mean", "straight-line", "ls-forward", "arx", "lts", "sindy", "subspace", "narx-poly"), MEMORY),
    "svf-ls": CORNERS,
    **dict.fromkeys(("ls-svr", "rw-ls-svr"), CLOSER),
}
"""What keeps a method's cost from being linear in samples."""
STEERED = {"response-2": "zigzag:20/20", "mariner": "prbs:30deg/20s"}
"""Vessel and manoeuvre of long records, in the order in which a method is tried; the second stays in its waters."""


def ship(vessel, samples=401):
    """Model, inputs (N, nu) of a rudder that moves all the time, step and initial state."""
    model = resolve(vessel)
    dt = float(model.suite["dt_s"])
    rudder = 0.3 * np.sin(2.0 * np.pi * np.arange(samples) / 97.0)
    return model, inputs_of(model, rudder), dt, initial_state(model)


def peer(name):
    """A module of another package, None where that is not installed; old packages warn when they are compiled."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return importlib.import_module(name) if importlib.util.find_spec(name.partition(".")[0]) else None


# ---- simulation


@pytest.mark.parametrize("vessel", ["mariner", "kvlcc2-l7", "response-2"])
def test_lanes_and_scalar_kernel(ratios, vessel):
    model, inputs, dt, start = ship(vessel)
    coefficients, batch, starts = (np.stack([value] * RUNS) for value in (model.coefficients, inputs, start))
    steps = RUNS * (len(inputs) - 1) * substeps(model, dt)
    ours = Side(lambda: open_loops(model, coefficients, batch, dt, starts), steps)
    other = Side(lambda: [simulate(model, inputs, dt, start) for _ in range(RUNS)], steps)
    limit = "the layout of inputs and results in memory, beside the kernel"
    ratios.compare(f"lanes, scalar kernel, {RUNS} runs: {vessel}", "steps/s", ours, other, 4.0, limit=limit)


def test_zigzag_and_shipmmg(ratios):
    """Shipmmg at tolerances that bring its error down to about ours; errors are largest differences of a state (SI)
    from the same code at tighter tolerances or shorter steps."""
    if importlib.util.find_spec("shipmmg") is None:
        return ratios.absent("200 s zigzag, shipmmg", "s/s", 50.0, "shipmmg")
    model, dt = reference.ship_of_shipmmg(), 0.1
    record = record_run(model, parse_manoeuvre("zigzag:20/20"), duration_s=200.0, dt_s=dt)
    rudder, clock = record.rudder().copy(), record.time_s
    inputs, start, count = inputs_of(model, rudder), initial_state(model), substeps(model, dt)
    exact = np.empty((len(inputs), start.size))
    model.kernels.simulate(start, inputs, model.theta, dt / (8 * count), 8 * count, False, exact)
    own = np.abs(simulate(model, inputs, dt, start) - exact).max()

    def theirs(rtol=1e-9, atol=1e-11):
        return reference.run_shipmmg(model, rudder, clock, rtol, atol)

    error = np.abs(theirs() - theirs(1e-11, 1e-13)).max()
    ours = Side(lambda: [simulate(model, inputs, dt, start) for _ in range(10)], 2000.0)
    ratios.compare(
        "200 s zigzag, shipmmg", "s/s", ours, Side(theirs, 200.0), 50.0, remark=f"errors {own:.0e} and {error:.0e}"
    )


# ---- regressions and filters


@pytest.mark.parametrize(("d", "rows", "target"), [(4, 200_000, 300.0), (22, 50_000, 50.0)])
def test_rls_and_padasip(ratios, d, rows, target):
    """Both store every estimate; P starts at 1000 I and forgets."""
    what = f"recursive least squares, padasip: d = {d}"
    if (filters := peer("padasip.filters")) is None:
        return ratios.absent(what, "rows/s", target, "padasip")
    rng, few = np.random.default_rng(d), 3000
    h = rng.normal(size=(rows, d))
    y, forget, path = h @ rng.normal(size=d) + 0.1 * rng.normal(size=rows), np.full(rows, 0.999), np.empty((rows, d))

    def own():
        _rls_kernels.recursive_ls(y, h, forget, 1.0, np.zeros(d), np.eye(d), np.full(d, 1000.0), path)

    def theirs():
        return filters.FilterRLS(d, mu=0.999, eps=0.001, w="zeros").run(y[:few], h[:few])[2]

    limit = "turns of some milliseconds: the ratios of the repeats scatter by a half"
    ratios.compare(what, "rows/s", Side(own, rows), Side(theirs, few), target, rounds=15, limit=limit)
    np.testing.assert_allclose(path[few - 2], theirs()[-1], rtol=1e-6, atol=1e-9)


def test_linear_svr_and_its_dual(ratios):
    rng = np.random.default_rng(5)
    x = rng.normal(size=(MULTIPLIERS, 7))
    y = x @ rng.normal(size=7) + 0.1 * rng.normal(size=MULTIPLIERS)
    found = {}

    def dual():
        gram = svr.kernel_matrix("linear", x, x, 1.0)
        found["dual"] = x.T @ svr.dual(gram, y, 1.0)[0]

    ours, name = Side(lambda: svr.primal(x, y, 1.0)), f"linear LS-SVR, dual: n = {MULTIPLIERS}"
    fits = Side(lambda: [ours.call() for _ in range(20)], 20.0)
    ratios.compare(name, "fits/s", fits, Side(dual), 1000.0, rounds=2, remark=f"dual in {8e-9 * MULTIPLIERS**2:.1f} GB")
    np.testing.assert_allclose(ours.call()[0], found["dual"], rtol=1e-6)
    peaks = [traced(partial(svr.primal, np.tile(x, (k, 1)), np.tile(y, k), 1.0)) for k in (1, 10)]
    slope = np.log10(peaks[1] / peaks[0])
    remark = f"{peaks[0] / 1e6:.2f} MB at n, {peaks[1] / 1e6:.2f} MB at 10 n, besides the data"
    ratios.row("linear LS-SVR, memory", "slope", slope, most=1.1, remark=remark)


def traced(call):
    """Largest memory (bytes) that NumPy holds during a call."""
    tracemalloc.start()
    call()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return max(peak, 1)


RBF = """
import json, time
from pathlib import Path
import numpy as np
from scipy.spatial.distance import cdist
from helmbench.methods.base import blas_limited
from helmbench.estimation.methods_only import svr
rng = np.random.default_rng(3)
x = rng.normal(size=({n}, 7))
y = np.sin(x).sum(axis=1)

def ours():
    return svr.dual(svr.kernel_matrix("rbf", x, x, 0.1, upper=True), y, 10.0)[1]

def naive():
    omega = np.exp(-0.1 * cdist(x, x, "sqeuclidean"))
    kkt = np.zeros(({n} + 1, {n} + 1))
    kkt[0, 1:] = kkt[1:, 0] = 1.0
    kkt[1:, 1:] = omega
    kkt[np.arange(1, {n} + 1), np.arange(1, {n} + 1)] += 1.0 / 10.0
    return np.linalg.solve(kkt, np.concatenate([[0.0], y]))[0]

def largest():
    return float(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1e6

with blas_limited():
    before, start = largest(), time.process_time()
    level = {side}()
    cpu = time.process_time() - start
print(json.dumps([cpu, largest() - before, level]))
"""


def test_rbf_svr_and_naive_kkt(ratios, benchmark):
    """In processes of their own, for the sake of the memory: a new process, not a forked one, has its own peak."""
    if not Path("/proc/self/status").exists():
        return ratios.absent("RBF LS-SVR, naive KKT: memory", "GB", 2.3, "/proc, where a process's memory is read,")
    found = {"ours": [], "naive": []}

    def turn(side):
        text = subprocess.run(
            [sys.executable, "-c", RBF.format(n=MULTIPLIERS, side=side)], check=True, capture_output=True
        ).stdout
        found[side].append(json.loads(text))

    benchmark.pedantic(turn, args=("ours",), setup=lambda: turn("naive"), rounds=2)
    ours, naive = np.array(found["ours"]), np.array(found["naive"])
    np.testing.assert_allclose(ours[:, 2], naive[:, 2], rtol=1e-6)
    for column, what, unit, least, limit in (
        (0, "", "CPU s", 2.5, "most of the time is the Cholesky factorisation of LAPACK"),
        (1, ", memory", "GB", 2.3, ""),
    ):
        sides = float(np.median(ours[:, column])), float(np.median(naive[:, column]))
        shares = (naive[:, column] / ours[:, column]).tolist()
        ratios.row(
            f"RBF LS-SVR, naive KKT: n = {MULTIPLIERS}{what}", unit, *sides, ratios=shares, least=least, limit=limit
        )


def test_kalman_smoother_and_filterpy(ratios):
    """Integrated random walk of 5 states, two of them measured.  Filterpy gives smoothed covariances besides."""
    what = "Kalman + RTS, filterpy: 5 states"
    if (kalman := peer("filterpy.kalman")) is None:
        return ratios.absent(what, "samples/s", 60.0, "filterpy")
    n, size, few, rng = 5, 100_000, 2000, np.random.default_rng(7)
    f, q = random_walk(n, 1e-3)
    columns, noise, h = np.array([0, 1]), np.array([1.0, 0.3]), np.eye(2, n)
    outputs = 0.01 * np.cumsum(np.cumsum(rng.normal(size=(size, 2)), axis=0), axis=0) + rng.normal(size=(size, 2))

    def own(rows=size):
        kept = [np.empty((rows, *shape)) for shape in ((n,), (n, n), (2, n), (2,), (2,))]
        observers.kalman(f, q, columns, noise, outputs[:rows], np.zeros(n), 10.0 * np.eye(n), *kept, n)
        states = np.empty((rows, n))
        observers.smooth(f, columns, *kept, states)
        return states

    def theirs():
        known = kalman.KalmanFilter(dim_x=n, dim_z=2)
        known.x, known.P, known.F, known.Q, known.H, known.R = np.zeros(n), 10.0 * np.eye(n), f, q, h, np.diag(noise)
        return known.rts_smoother(*known.batch_filter(outputs[:few], update_first=True)[:2])[0]

    ratios.compare(what, "samples/s", Side(own, size), Side(theirs, few), 60.0)
    np.testing.assert_allclose(own(few), theirs(), rtol=1e-5, atol=1e-4)


def test_output_error_and_least_squares(ratios):
    """20 coefficients of kvlcc2-l7 from 1200 samples, both from a start 3 % off.

    Ours estimates the channels' standard deviations along; SciPy is told them, which gives it the same minimum.
    """
    record = generate(Case("kvlcc2-l7", "prbs:30deg/8s", "medium", duration_s=119.9, dt_s=0.1))
    model = resolve("kvlcc2-l7")
    series = series_of(record, model)
    problem = Problem(model, (series,), ((),))
    first = model.coefficients * (1.0 + 0.03 * np.random.default_rng(2).normal(size=model.coefficients.size))
    found = levenberg_marquardt(problem, first, 60)
    sd = found.point.sd[series.columns]

    def residuals(c):
        return (free_run.residuals(model.with_coefficients(c), series, series.start) / sd).ravel()

    def theirs():
        return least_squares(residuals, first, x_scale=np.abs(first))

    ours = Side(lambda: levenberg_marquardt(problem, first, 60))
    costs = [0.5 * np.sum(residuals(c) ** 2) for c in (found.z, theirs().x)]
    remark = "half sums of squares {:.3f} and {:.3f}".format(*costs)
    ratios.compare(
        "output error, least_squares: 20 parameters", "fits/s", ours, Side(theirs), 4.0, rounds=3, remark=remark
    )


# ---- starting

FIRST = """
import time
from helmbench.models.lanes import open_loops
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate
import numpy as np
start = time.process_time()
model = resolve("mariner")
simulate(model, inputs_of(model, np.zeros(100)), 0.1, initial_state(model))
print(time.process_time() - start)
"""
SMALLEST = """
import time
import numpy as np
start = time.process_time()
from numba import njit
@njit("f8(f8[::1])", cache=True)
def first(x):
    return x[0]
first(np.zeros(1))
print(time.process_time() - start)
"""


def test_first_call_of_a_cached_kernel(ratios, benchmark, tmp_path):
    """Import of numba, vessel file and kernels in a fresh process; numba's own share is that of a one-line kernel."""
    files, taken = {"ours": tmp_path / "ours.py", "numba": tmp_path / "smallest.py"}, {"ours": [], "numba": []}
    for side, text in zip(files, (FIRST, SMALLEST), strict=True):
        files[side].write_text(text)

    def turn(side):
        printed = subprocess.run([sys.executable, files[side]], check=True, capture_output=True).stdout
        taken[side].append(float(printed))

    benchmark.pedantic(turn, args=("ours",), setup=lambda: turn("numba"), rounds=5, warmup_rounds=1)
    ours, smallest = (float(np.median(values[1:])) for values in taken.values())
    name = "first call of a cached kernel, numba's share"
    ratios.row(name, "CPU s", ours, smallest, most=0.5, limit="numba's own start, the other column")


def test_help(ratios, benchmark):
    def helped():
        subprocess.run([sys.executable, "-m", "helmbench", "--help"], check=True, capture_output=True)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        total.append(used.ru_utime + used.ru_stime)

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    total = [used.ru_utime + used.ru_stime]
    benchmark.pedantic(helped, rounds=5, warmup_rounds=1)
    ratios.row("helmbench --help", "CPU s", float(np.median(np.diff(total)[1:])), most=0.3)


# ---- cost against the number of samples


@pytest.fixture(scope="module")
def records():
    """A vessel's records by number of samples; each is made when it is asked for, and kept."""
    made = {}

    def of(vessel, n):
        if (vessel, n) not in made:
            dt = float(resolve(vessel).suite["dt_s"])
            made[vessel, n] = generate(Case(vessel, STEERED[vessel], "medium", duration_s=(n - 1) * dt))
        return made[vessel, n]

    return of


def fit_time(name, vessel, record):
    """Least CPU time (s) of three fits, of one if that takes a second; CannotFit if the method does not apply."""
    model, taken = resolve(vessel).blanked(), []
    while len(taken) < 3 and not (taken and taken[-1] > 1.0):
        start = time.process_time()
        with contextlib.suppress(FitFailed):
            make(name).fit([record], model)
        taken.append(time.process_time() - start)
    return min(taken)


@pytest.mark.parametrize("name", methods())
def test_cost_against_samples(ratios, benchmark, records, name):
    """Up to 10^6 samples, or as many as are expected to take less than `LONGEST_FIT_S`."""
    (vessel, fallback), taken = STEERED, {}
    try:
        fit_time(name, vessel, records(vessel, SIZES[0]))
    except CannotFit:
        vessel = fallback
    benchmark.pedantic(fit_time, args=(name, vessel, records(vessel, SIZES[0])), rounds=1)
    for n in SIZES:
        expected = 10.0 * taken[n // 10] if taken else 0.0
        if expected > LONGEST_FIT_S:
            break
        taken[n] = fit_time(name, vessel, records(vessel, n))
    left_out = "" if len(taken) == len(SIZES) else f"; {n:.0e} left out, about {expected:.0f} s"
    limit = LIMITS.get(name, "")
    what = f"cost against samples: {name}"
    if len(taken) < 2:
        remark = f"of {SIZES[0]} samples, {vessel}; more take over {LONGEST_FIT_S:g} s"
        return ratios.row(what, "CPU s", taken[SIZES[0]], remark=remark)
    ratios.cost(what, "samples", list(taken.items()), most=1.1, remark=f"{vessel}{left_out}", limit=limit)
