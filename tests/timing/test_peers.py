"""Speed of simulation, output error and files against C from the papers' equations and against other packages.

All of these peers are given the same ship, KVLCC2 by the equations of `test_reference_kvlcc2` (the Mariner in C too),
and both sides have to come to the same result.  Peers that are not installed are named by their rows.
"""

import shutil
import time
from types import SimpleNamespace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import read_record, write_record
from helmbench.estimation.likelihood.output_error import fit_output_error, identify
from helmbench.estimation.records.series import series_of
from helmbench.estimation.results.fit import blas_limited
from helmbench.estimation.simulation.free_run import squares
from helmbench.estimation.simulation.selection import fitted_start
from helmbench.methods.registry import make
from helmbench.models.lanes import open_loops
from helmbench.models.model import resolve
from helmbench.models.simulate import substeps

from ..models import test_reference_kvlcc2 as reference
from .conftest import Side
from .in_c import FLAGS, compile_c, compiled
from .test_ratios import peer, ship

pytestmark = pytest.mark.benchmark(timer=time.process_time)
SHIPS = {"kvlcc2-l7": "kvlcc2", "mariner": "mariner"}
"""Vessel -> its equations in c/."""
SIDE_BY_SIDE = 16
"""Runs that C takes side by side: 8, 16 and 32 hardly differ."""
RUNS = 256
ROWS = 100_000
STARTS = 20


def facts(model):
    return reference.numbers(model)


# ---- C


@pytest.mark.parametrize("vessel", SHIPS)
def test_one_run_and_c(ratios, tmp_path, vessel):
    what = f"one run, C from the paper (gcc -O3): {vessel}"
    if (gcc := shutil.which("gcc")) is None:
        return ratios.absent(what, "steps/s", 0.95, "gcc")
    model, inputs, dt, start = ship(vessel, 20_001)
    count, found = substeps(model, dt), np.empty((2, len(inputs), start.size))
    in_c, steps = compiled(SHIPS[vessel], facts(model), gcc, tmp_path), (len(inputs) - 1) * count
    ours = Side(lambda: model.kernels.simulate(start, inputs, model.theta, dt / count, count, False, found[0]), steps)
    other = Side(lambda: in_c(inputs, dt, count, start, found[1]), steps)
    ratios.compare(what, "steps/s", ours, other, 0.95, rounds=15)
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("vessel", SHIPS)
def test_many_runs_and_c(ratios, tmp_path, vessel):
    what = f"{RUNS} runs, C from the paper with a vector library: {vessel}"
    if (gcc := shutil.which("gcc")) is None:
        return ratios.absent(what, "steps/s", 0.77, "gcc")
    model, inputs, dt, start = ship(vessel)
    count, blocks = substeps(model, dt), RUNS // SIDE_BY_SIDE
    coefficients, batch, starts = (np.stack([value] * RUNS) for value in (model.coefficients, inputs, start))
    in_c = compiled(SHIPS[vessel], facts(model), gcc, tmp_path, SIDE_BY_SIDE)
    wide, begin = np.repeat(inputs, SIDE_BY_SIDE, axis=1), np.repeat(start, SIDE_BY_SIDE)
    states = np.empty((blocks, len(inputs), begin.size))
    steps = RUNS * (len(inputs) - 1) * count
    ours = Side(lambda: open_loops(model, coefficients, batch, dt, starts), steps)
    other = Side(lambda: [in_c(wide, dt, count, begin, block) for block in states], steps)
    remark = "here inputs and states are turned from runs to blocks and back as well"
    limit = "the accelerations are half of it, of all the family's coefficients (C: the published ones); "
    limit += "a quarter are RK4's passes, the rest is turning inputs and states"
    ratios.compare(what, "steps/s", ours, other, 0.77, rounds=15, remark=remark, limit=limit)
    np.testing.assert_allclose(ours.call()[0], states[0, :, ::SIDE_BY_SIDE], rtol=1e-6, atol=1e-6)


# ---- CasADi


def in_casadi(ca, dt, names):
    """One RK4 step of KVLCC2 as a function (x, inputs at both ends, numbers) of CasADi, by the paper's equations."""
    x, before, after = ca.SX.sym("x", 6), ca.SX.sym("u0", 2), ca.SX.sym("u1", 2)
    c = {name: ca.SX.sym(name) for name in names}
    m = SimpleNamespace(sqrt=ca.sqrt, exp=ca.exp, sin=ca.sin, cos=ca.cos, atan2=ca.atan2, where=ca.if_else)

    def rates(x, u):
        moving = reference.published_accelerations(c, [x[i] for i in range(3)], u[0], u[1], m)
        turned = x[0] * ca.cos(x[5]) - x[1] * ca.sin(x[5]), x[0] * ca.sin(x[5]) + x[1] * ca.cos(x[5])
        return ca.vertcat(*moving, *turned, x[2])

    middle = (before + after) / 2
    first = rates(x, before)
    second = rates(x + dt / 2 * first, middle)
    third = rates(x + dt / 2 * second, middle)
    last = rates(x + dt * third, after)
    ahead = x + dt / 6 * (first + 2 * (second + third) + last)
    return ca.Function("step", [x, before, after, ca.vertcat(*c.values())], [ahead])


def test_one_run_and_c_of_casadi(ratios, tmp_path, monkeypatch):
    what, ca, gcc = "one run, C that CasADi writes: kvlcc2-l7", peer("casadi"), shutil.which("gcc")
    if ca is None or gcc is None:
        return ratios.absent(what, "steps/s", 1.0, "gcc" if ca else "casadi")
    model, inputs, dt, start = ship("kvlcc2-l7", 4001)
    known, steps = facts(model), len(inputs) - 1
    x, u, numbers = ca.MX.sym("x", start.size), ca.MX.sym("u", 2, len(inputs)), ca.MX.sym("c", len(known))
    step = in_casadi(ca, dt, list(known)).mapaccum(steps)
    states = step(x, u[:, :-1], u[:, 1:], ca.repmat(numbers, 1, steps))
    monkeypatch.chdir(tmp_path)  # CasADi writes into the working folder alone
    ca.Function("run", [x, u, numbers], [states]).generate("run.c")
    compile_c(gcc, FLAGS, tmp_path / "run.c", tmp_path / "run.so")
    whole, values = ca.external("run", str(tmp_path / "run.so")), [*map(ca.DM, (start, inputs.T, list(known.values())))]
    found = np.empty((len(inputs), start.size))
    ours = Side(lambda: model.kernels.simulate(start, inputs, model.theta, dt, 1, False, found), steps)
    other = Side(lambda: whole(*values), steps)
    ratios.compare(what, "steps/s", ours, other, 1.0, rounds=15)
    np.testing.assert_allclose(found[1:], np.array(other.call()).T, rtol=1e-6, atol=1e-6)


def shooting(ca, model, several, sd):
    """A function coefficients -> half the sum of squares at the optimum: multiple shooting over every sample by IPOPT.

    several : series of the records; sd : standard deviations of the measured channels.
    """
    known = facts(model)
    factor, first = (ca.MX.sym(name, len(model.coefficients)) for name in ("factor", "first"))
    named = {name: factor[i] * first[i] for i, name in enumerate(model.coordinates)}
    named |= {"t_R": 1 - named["CRu"], "a_H": named["CRv"] - 1}
    named["x_R"] = named["CRr"] - named["a_H"] * known["x_H"]
    numbers = ca.vertcat(*[named.get(name, value) for name, value in known.items()])
    step, free, begin, gaps, cost = (
        in_casadi(ca, several[0].dt, list(known)),
        [factor],
        [np.ones(factor.numel())],
        [],
        0,
    )
    for number, series in enumerate(several):
        steps, u = len(series.inputs) - 1, ca.DM(series.inputs.T)
        x = ca.MX.sym(f"x{number}", len(model.states), steps + 1)
        ahead = step.map(steps)(x[:, :-1], u[:, :-1], u[:, 1:], ca.repmat(numbers, 1, steps))
        gaps += [ca.vec(ahead - x[:, 1:]), x[3:5, 0]]  # positions are not measured: they begin at zero
        error = (x[series.columns.tolist(), :] - ca.DM(series.outputs.T)) / ca.repmat(ca.DM(sd), 1, steps + 1)
        cost += ca.sumsqr(error) / 2
        guess = np.tile(series.start, (steps + 1, 1))
        guess[:, series.columns] = series.outputs
        free.append(ca.vec(x))
        begin.append(guess.ravel())
    problem = {"x": ca.vertcat(*free), "p": first, "f": cost, "g": ca.vertcat(*gaps)}
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.max_iter": 200}
    solver = ca.nlpsol("fit", "ipopt", problem, options)
    return lambda coefficients: float(solver(x0=np.concatenate(begin), p=coefficients, lbg=0, ubg=0)["f"])


def test_output_error_and_multiple_shooting_of_casadi(ratios):
    """20 coefficients and the initial states of KVLCC2 from two zigzags; CasADi from a start up to 50 % off, with the
    standard deviations of the channels; ours finds its start and them by itself."""
    what = "output error of two zigzags, multiple shooting by CasADi and IPOPT"
    if (ca := peer("casadi")) is None:
        return ratios.absent(what, "fits/s", 1.0, "casadi")
    model = resolve("kvlcc2-l7")
    records = [generate(Case("kvlcc2-l7", text, "medium")) for text in ("zigzag:10/10", "zigzag:20/20")]
    several = [series_of(record, model) for record in records]
    sd = np.array(list(make("output-error").fit(records, model).extra["residual_sd"].values()))
    first = model.coefficients * np.random.default_rng(3).uniform(0.5, 1.5, model.coefficients.size)
    fit, costs = shooting(ca, model, several, sd), []
    ours = Side(lambda: make("output-error").fit(records, model))
    own = sum(series.known.sum() for series in several) / 2  # in units of its own residuals
    ratios.compare(what, "fits/s", ours, Side(lambda: costs.append(fit(first))), 1.0, rounds=1)
    np.testing.assert_allclose(costs, own, rtol=1e-3)


@pytest.mark.parametrize("drawn", ["up to 50 % off", "each 50 % off"])
def test_output_error_from_bad_starts(ratios, benchmark, drawn):
    """As above, each of STARTS bad starts taken as the only one: CPU time of the median and of the slowest."""
    model = resolve("kvlcc2-l7")
    records = [generate(Case("kvlcc2-l7", text, "medium")) for text in ("zigzag:10/10", "zigzag:20/20")]
    several, taken, costs = [series_of(record, model) for record in records], [], []
    with blas_limited(), np.errstate(all="ignore"):
        least = identify(records, model.blanked()).minimum.cost
        for seed in range(STARTS):
            rng, size = np.random.default_rng(seed), model.coefficients.size
            factor = rng.choice([0.5, 1.5], size) if drawn.startswith("each") else rng.uniform(0.5, 1.5, size)
            start = time.process_time()
            costs.append(fit_output_error(several, model.blanked(), [factor * model.coefficients]).minimum.cost)
            taken.append(time.process_time() - start)
    benchmark.pedantic(lambda: None, rounds=1)
    remark = f"median {np.median(taken):.2g} CPU s; all at the optimum"
    limit = "runs over whole records are tried before short ones, which some of these starts need"
    what = f"output error of two zigzags, {STARTS} starts {drawn}: the slowest"
    ratios.row(what, "CPU s", max(taken), most=0.25, remark=remark, limit=limit)
    np.testing.assert_allclose(costs, least, atol=1e-3, rtol=0.0)


@pytest.mark.parametrize("name", ["ekf", "ukf"])
def test_filters_and_output_error(ratios, benchmark, name):
    """The free runs of KVLCC2 along both zigzags by the filter's coefficients, each from its best start."""
    model = resolve("kvlcc2-l7")
    records = [generate(Case("kvlcc2-l7", text, "medium")) for text in ("zigzag:10/10", "zigzag:20/20")]
    several = [series_of(record, model) for record in records]
    fits = [make(method).fit(records, model) for method in ("output-error", name)]
    sd = np.array(list(fits[0].extra["residual_sd"].values()))
    own, filtered = (
        sum(
            float((squares(one.model, series, fitted_start(one.model, series).start) / sd**2).sum())
            for series in several
        )
        for one in fits
    )
    benchmark.pedantic(lambda: None, rounds=1)
    limit = "every sample is linearised at the coefficients of its time; a narrower prior (inflation=2) is within 1 % "
    limit += "here, and errs twice as much on the Esso Osaka in high noise"
    what = f"{name}, output error of two zigzags: squared residuals, as a multiple of the least"
    ratios.row(what, "1", filtered / own, most=1.01, remark=f"{fits[1].cpu_s:.2g} CPU s", limit=limit)


# ---- diffrax


def test_many_runs_and_diffrax(ratios):
    """Tsit5 with constant steps of the sampling time and 256 runs by vmap, in doubles, compiled before it is timed."""
    what = f"{RUNS} runs, diffrax: kvlcc2-l7"
    if (diffrax := peer("diffrax")) is None:
        return ratios.absent(what, "s/s", 1.0, "diffrax")
    jax, jnp = peer("jax"), peer("jax.numpy")
    model, inputs, dt, start = ship("kvlcc2-l7")
    coefficients, batch, starts = (np.stack([value] * RUNS) for value in (model.coefficients, inputs, start))
    known, clock = facts(model), dt * np.arange(len(inputs))
    m = SimpleNamespace(sqrt=jnp.sqrt, exp=jnp.exp, sin=jnp.sin, cos=jnp.cos, atan2=jnp.arctan2, where=jnp.where)

    def rates(time, x, series):
        delta, n = series.evaluate(time)
        moving = reference.published_accelerations(known, x[:3], delta, n, m)
        u, v, sine, cosine = x[0], x[1], jnp.sin(x[5]), jnp.cos(x[5])
        return jnp.stack([*moving, u * cosine - v * sine, u * sine + v * cosine, x[2]])

    def run(series, x0):
        solved = diffrax.diffeqsolve(
            diffrax.ODETerm(rates), diffrax.Tsit5(), 0.0, clock[-1], dt, x0, diffrax.LinearInterpolation(clock, series),
            saveat=diffrax.SaveAt(ts=clock), stepsize_controller=diffrax.ConstantStepSize(), max_steps=len(clock) + 1,
        )  # fmt: skip
        return solved.ys

    with jax.enable_x64(True):
        together = jax.jit(jax.vmap(run))
        ours = Side(lambda: open_loops(model, coefficients, batch, dt, starts), RUNS * clock[-1])
        other = Side(lambda: np.asarray(together(batch, starts)), RUNS * clock[-1])
        ratios.compare(what, "s/s", ours, other, 1.0)
        np.testing.assert_allclose(ours.call()[0], other.call()[0], rtol=1e-4, atol=1e-4)


def test_mmgdynamics(ratios):
    """A row that says that it is missing: it is published on GitHub alone."""
    ratios.absent("one run, mmgdynamics: kvlcc2-l7", "s/s", 1.0, "mmgdynamics")


# ---- files


@pytest.mark.parametrize("package", ["pandas", "polars"])
def test_files(ratios, tmp_path, package):
    """A CSV record; ours besides looks for units, gaps, a sidecar and what is wrong."""
    what = f"read a CSV record of {ROWS} samples, {package}"
    if (library := peer(package)) is None:
        return ratios.absent(what, "rows/s", 1.0, package)
    record = generate(Case("mariner", "prbs:30deg/20s", "medium", duration_s=(ROWS - 1) * 0.5))
    path = tmp_path / "record.csv"
    write_record(record, path)
    ours, other = Side(lambda: read_record(path), ROWS), Side(lambda: library.read_csv(path), ROWS)
    limit = "names, units, gaps and times are checked, and a sidecar is looked for"
    ratios.compare(what, "rows/s", ours, other, 1.0, limit=limit)
    table = other.call()
    np.testing.assert_allclose(ours.call().column("yaw_rate_rad_s"), table["yaw_rate_rad_s"].to_numpy(), rtol=1e-12)
