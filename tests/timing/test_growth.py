"""Many runs, many parameters, many records, many rows of a suite, and what whole commands cost."""

import json
import re
import subprocess
import sys
import time

import numpy as np
import pytest

import helmbench
from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve

from .conftest import Side

pytestmark = pytest.mark.benchmark(timer=time.process_time)
MANY = 100_000
SHIPS = {
    "response-1": "zigzag:20/20",
    "response-2": "zigzag:20/20",
    "kvlcc2-l7": "prbs:30deg/8s",
    "mariner": "prbs:30deg/20s",
}
"""Vessel -> a manoeuvre; their numbers of parameters differ."""
SAMPLES = 2000
COUNTS = (20, 200, 2000)
RECORD_S = 10.0
TINY = 2000
REPEATS = 3

MEMORY = """
import json, time
import psutil
from pathlib import Path

def largest():
    text = Path("/proc/self/status").read_text() if Path("/proc/self/status").exists() else ""
    return float(text.split("VmHWM:")[1].split()[0]) / 1e6 if text else None

def report(**more):
    used = psutil.Process().cpu_times()
    spent = {{"cpu": time.process_time(), "children": used.children_user + used.children_system}}
    print(json.dumps({{"gb": largest(), **spent, **more}}))
{body}
"""


def in_a_process(body, folder):
    """What a new process of this text reports: CPU s, those of its children, largest memory in GB, wall time s."""
    start = time.monotonic()
    text = MEMORY.format(body=body)
    done = subprocess.run([sys.executable, "-c", text], check=True, capture_output=True, text=True, cwd=folder)
    return {"wall": time.monotonic() - start, **json.loads(done.stdout.splitlines()[-1])}


def middle(found, key):
    values = [one[key] for one in found if one[key] is not None]
    return float(np.median(values)) if values else None


def repeated(benchmark, body, folder, rounds=REPEATS):
    """Reports of as many new processes, after one that may compile."""
    found = []
    benchmark.pedantic(lambda: found.append(in_a_process(body, folder)), rounds=rounds, warmup_rounds=1)
    return found[1:]


ZIGZAGS = """
import numpy as np
import helmbench
model = helmbench.resolve("mariner")
sets = model.coefficients * (1.0 + 0.02 * np.random.default_rng(1).standard_normal(({runs}, model.coefficients.size)))
kept = {{"channels": [], "indices": ["first_overshoot", "second_overshoot"]}}
found = helmbench.simulate_many(model, "zigzag:10/10", {runs}, coefficients=sets, **kept)
report(samples=found.time_s.size)
"""


def test_a_hundred_thousand_zigzags(ratios, benchmark, tmp_path):
    found = repeated(benchmark, ZIGZAGS.format(runs=MANY), tmp_path)
    (few,) = [in_a_process(ZIGZAGS.format(runs=32), tmp_path)]
    seconds, told = middle(found, "cpu") - few["cpu"], f"{found[0]['samples']} samples each, mariner"
    name = f"{MANY} zigzags 10/10 by simulate_many"
    ratios.row(f"{name}: CPU time on all processors", "CPU s", seconds, most=20.0, remark=told)
    ratios.row(f"{name}: memory over 32 zigzags", "GB", middle(found, "gb") - few["gb"], remark="two angles kept a run")


def test_simulate_many_and_simulate(ratios):
    model, runs = resolve("mariner"), 320
    kept = {"channels": ["heading_rad"], "jobs": 1}
    ours = Side(lambda: helmbench.simulate_many(model, "zigzag:10/10", runs, **kept), runs)
    other = Side(lambda: [helmbench.simulate(model, "zigzag:10/10", seed=i) for i in range(runs)], runs)
    ratios.compare("simulate_many, simulate: zigzags without noise", "runs/s", ours, other, 4.0)


# ---- cost against parameters and records


def fit_time(name, records, model):
    """Median CPU time (s) of three fits, after one."""
    taken = []
    for _ in range(REPEATS + 1):
        start = time.process_time()
        make(name).fit(records, model)
        taken.append(time.process_time() - start)
    return float(np.median(taken[1:]))


@pytest.mark.parametrize("name", ["ls", "rls", "huber", "ekf", "output-error"])
def test_cost_against_parameters(ratios, benchmark, name):
    points = []
    for vessel, manoeuvre in SHIPS.items():
        model = resolve(vessel)
        duration = (SAMPLES - 1) * model.suite["dt_s"]
        record = generate(Case(vessel, manoeuvre, "medium", duration_s=duration))
        points.append((len(model.coordinates), fit_time(name, [record], model.blanked())))
    benchmark.pedantic(lambda: None, rounds=1)
    ratios.cost(
        f"cost against parameters: {name}", "parameters", points, remark=f"{', '.join(SHIPS)}; {SAMPLES} samples"
    )


@pytest.mark.parametrize("name", ["ls", "rls", "output-error"])
def test_cost_against_records(ratios, benchmark, name):
    points, model = [], resolve("response-2").blanked()
    for count in COUNTS:
        runs = helmbench.simulate_many("response-2", "prbs:20deg/3s", count, noise="medium", duration_s=RECORD_S)
        records = [runs.record(i) for i in range(count)]
        start = time.process_time()
        make(name).fit(records, model)
        points.append((count, time.process_time() - start))
    benchmark.pedantic(lambda: None, rounds=1)
    ratios.cost(
        f"cost against records: {name}", "records", points, most=1.1, remark=f"records of {RECORD_S:g} s, response-2"
    )


SHORT = """
import helmbench
runs = helmbench.simulate_many("response-2", "prbs:20deg/3s", {count}, noise="medium", duration_s={duration})
helmbench.identify([runs.record(i) for i in range({count})], "response-2", "output-error")
report()
"""


def test_output_error_of_many_short_records(ratios, benchmark, tmp_path):
    found = repeated(benchmark, SHORT.format(count=COUNTS[-1], duration=RECORD_S), tmp_path, rounds=1)
    name = f"output error of {COUNTS[-1]} records of {RECORD_S:g} s, the whole process"
    limit = "each record is admitted and simulated by calls of its own"
    ratios.row(name, "CPU s", middle(found, "cpu"), most=30.0, limit=limit)
    ratios.row(f"{name}: memory", "GB", middle(found, "gb"), most=1.0)


# ---- whole commands

RECORDS = """
import helmbench
texts = ["zigzag:10/10", "zigzag:20/20", "turn:20", "zigzag:20/20:port", "sine:15deg/120s"]
long = {"noise": "low", "duration_s": 600.0, "dt_s": 0.5}
made = [helmbench.simulate("mariner", text, seed=k, **long) for k, text in enumerate(texts)]
"""
DIAGNOSIS = """
model = helmbench.resolve("mariner")
model = model.with_coefficients({factor} * model.coefficients)
helmbench.diagnose(model, made[:3], made[3:], coefficient_sd={sd})
report()
"""
CHECK = """
start = time.process_time()
helmbench.check(made)
report(own=time.process_time() - start)
"""
BASES = {"known": (1.0, 0.0, 3.0), "off by a tenth and free": (1.1, None, 8.0)}
"""Coefficients of the base model -> their factor, the standard deviations that are given, and the target, s."""


@pytest.mark.parametrize("base", BASES)
def test_diagnosis_of_five_records(ratios, benchmark, tmp_path, base):
    factor, sd, most = BASES[base]
    found = repeated(benchmark, RECORDS + DIAGNOSIS.format(factor=factor, sd=sd), tmp_path)
    name = f"diagnose 3 + 2 records of 600 s at 2 Hz, coefficients {base}, the whole process"
    told, limit = f"{middle(found, 'cpu'):.2f} CPU s", "the filter's likelihood and its derivatives for every cause"
    ratios.row(f"{name}: wall time", "s", middle(found, "wall"), most=most, remark=told, limit=limit)
    limit = "numba, SciPy and the kernels, and the derivatives by all features that are tried"
    ratios.row(f"{name}: memory", "GB", middle(found, "gb"), most=0.4, limit=limit)


def test_check_of_five_records(ratios, benchmark, tmp_path):
    found = repeated(benchmark, RECORDS + CHECK, tmp_path)
    ratios.row("check five records of 600 s at 2 Hz, without the start", "CPU s", middle(found, "own"), most=1.0)


MILLION = """
import helmbench, numpy as np
from helmbench.datasets.arrow_csv import write_csv
from helmbench.datasets.io import write_record
made = helmbench.simulate("mariner", "prbs:20deg/60s", noise="low", duration_s=99999.9, dt_s=0.1)
names = {"rudder_rad": "rudder [deg]", "heading_rad": "heading [deg]", "yaw_rate_rad_s": "rate of turn [deg/s]"}
angles = {title: np.round(np.degrees(made.column(name)), 3) for name, title in names.items()}
write_csv({"time [s]": np.round(made.time_s, 1), **angles}, Path("log.csv"))
write_record(made, Path("record.csv"))
start = time.process_time()
"""
COMMANDS = {
    "import": ('helmbench.import_log("log.csv", positive_rudder="port").write("out.csv", force=True)', 2.0),
    "check": ('helmbench.check("record.csv")', 3.0),
}
"""Command -> its call, and the target, CPU s."""


@pytest.mark.parametrize("command", COMMANDS)
def test_a_million_rows(ratios, benchmark, tmp_path, command):
    call, most = COMMANDS[command]
    found = repeated(benchmark, MILLION + call + "\nreport(own=time.process_time() - start)", tmp_path)
    limit = "samples are looked at one by one for spikes, jumps and repeated values"
    ratios.row(f"{command} a million rows, without the start", "CPU s", middle(found, "own"), most=most, limit=limit)


LONG = """
import helmbench
made = helmbench.simulate("{vessel}", "zigzag:20/20", noise="low", duration_s=({samples} - 1) * {dt}, dt_s={dt}{more})
model = helmbench.resolve("{vessel}")
model = model.with_coefficients({factor} * model.coefficients)
start, said = time.monotonic(), ""
try:
    helmbench.diagnose(model, [made], coefficient_sd={sd})
except helmbench.BadInput as refusal:
    said = str(refusal)
report(own=time.monotonic() - start, said=said)
"""
TOO_LONG = 100_000
"""Samples of a log that is refused; the refusal tells how many are possible."""
LOGS = {
    "mariner, coefficients known": ("mariner", 1.0, 0.0, ""),
    "mariner, coefficients off by a tenth and free": ("mariner", 1.1, None, ""),
    "mariner, coefficients free, in a current": ("mariner", 1.0, None, ', disturbance="current:0.3@90"'),
    "kvlcc2-l7, coefficients off by a tenth and free": ("kvlcc2-l7", 1.1, None, ""),
    "response-2, coefficients off by a tenth and free": ("response-2", 1.1, None, ""),
}
STEPS_S = {"mariner": 1.0, "kvlcc2-l7": 0.2, "response-2": 1.0}


@pytest.mark.parametrize("log", LOGS)
def test_log_of_many_samples(ratios, benchmark, tmp_path, log):
    """A log is refused before anything is computed, or else diagnosed in less than two minutes and 4 GB."""
    vessel, factor, sd, more = LOGS[log]
    given = {"vessel": vessel, "dt": STEPS_S[vessel], "factor": factor, "sd": sd, "more": more}
    refused = repeated(benchmark, LONG.format(samples=TOO_LONG, **given), tmp_path, rounds=1)
    longest = int(re.search(r"at most (\d+) samples a record", refused[0]["said"])[1])
    name = f"a log of {TOO_LONG} samples, {log}: wall time until it is refused"
    ratios.row(name, "s", middle(refused, "own"), most=120.0, remark=f"{longest} samples a record are possible")
    found = in_a_process(LONG.format(samples=longest, **given), tmp_path)
    assert not found["said"]
    name = f"diagnose the longest possible log, {log}"
    limit = "free runs with every group of numbers, of a record that few threads share"
    told = f"{longest} samples, {found['cpu']:.0f} CPU s"
    ratios.row(f"{name}: wall time", "s", found["own"], most=120.0, remark=told, limit=limit)
    ratios.row(f"{name}: memory", "GB", found["gb"], most=4.0, limit="the derivatives of every sample are kept")


SUITE = """
import helmbench
entry = "entries: [{{vessels: response-1, methods: [ls-forward], noise: low, seeds: {seeds}}}]"
Path("mine.yaml").write_text(entry)
found = helmbench.run_suite("mine.yaml", directory="{folder}", jobs=1)
size = sum(path.stat().st_size for path in Path("{folder}").rglob("*") if path.is_file())
report(bytes=size, runs=len(found.rows))
"""

ITSELF = """
import helmbench
from helmbench.bench.execution import quiet
from helmbench.bench.kinds.identification.execute import fit_and_score
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.suites import load_suite
entry = "entries: [{{vessels: response-1, methods: [ls-forward], noise: low, seeds: {seeds}}}]"
Path("mine.yaml").write_text(entry)
first, *specs = plan(load_suite("mine.yaml"))
with quiet():
    fit_and_score(first, {{}}, [])
    start = time.process_time()
    for spec in specs:
        fit_and_score(spec, {{}}, [])
    report(each=(time.process_time() - start) / len(specs))
"""


def test_tiny_runs_of_a_suite(ratios, benchmark, tmp_path):
    """What a run costs beyond the start of the suite: the difference between many runs and few."""
    cases = (("first", 2), ("few", 2), ("many", TINY + 2))
    _, few, many = (in_a_process(SUITE.format(seeds=n, folder=f"{label}-{n}"), tmp_path) for label, n in cases)
    more = many["runs"] - few["runs"]
    cpu = (many["cpu"] + many["children"] - few["cpu"] - few["children"]) / more
    benchmark.pedantic(lambda: None, rounds=1)
    facts = {
        "cpu_s": cpu,
        "parent_cpu_s": (many["cpu"] - few["cpu"]) / more,
        "parent_bytes": 1e9 * (many["gb"] - few["gb"]) / more,
        "start_cpu_s": few["cpu"] + few["children"],
        "stored_bytes": (many["bytes"] - few["bytes"]) / more,
        "fixed_bytes": few["bytes"],
    }
    told = f"{more} runs of ls on response-1; a start {facts['start_cpu_s']:.2g} CPU s"
    limit = "the run in its worker: records with noise, fit and scores, in many short calls of much the same cost"
    ratios.row("a tiny run of a suite, all included", "CPU s", cpu, most=0.002, remark=told, limit=limit, run=facts)
    itself = in_a_process(ITSELF.format(seeds=TINY), tmp_path)["each"]
    told = f"the run itself {itself:.2g} CPU s; the rest plans, hands over, guards, measures and stores"
    ratios.row("a tiny run of a suite: all but records, fit and scores", "CPU s", cpu - itself, most=0.002, remark=told)


DEFAULT = """
import helmbench
found = helmbench.run_suite("default", directory="default", jobs=2)
report(runs=len(found.rows), methods=len({row["method"] for row in found.rows}))
"""


def test_default_suite(ratios, benchmark, tmp_path):
    """The whole suite on two processors, as its file has it."""
    benchmark.pedantic(lambda: None, rounds=1)
    found = in_a_process(DEFAULT, tmp_path)
    told = f"{found['runs']} runs of {found['methods']} methods, {found['cpu'] + found['children']:.0f} CPU s"
    limit = "the fits themselves; hybrids, learners, `pem` and `ukf` take half"
    ratios.row("suite `default` on two processors: wall time", "s", found["wall"], most=180.0, remark=told, limit=limit)
