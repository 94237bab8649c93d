"""Ratios taken in one run: both sides timed in turn, one thread of linear algebra, a table after the timings.

With `--rows FILE` every row is appended to the file as it is found, and what the file holds of the same code is not
measured again: an interrupted run goes on.  `helmbench.reporting.timing` makes the published report of it.
"""

import json
import os
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from helmbench.bench.environment import code_version
from helmbench.estimation.results.fit import blas_limited

FIELDS = ("what", "unit", "ours", "other", "ratio", "low", "high", "target", "remark")
ROWS = pytest.StashKey[list]()


class Side(NamedTuple):
    """One of two that are compared: a function without arguments, and how many units one call is worth."""

    call: object
    units: float = 1.0


class Ratios:
    """Writes rows of the table, and the same figures into the benchmark's `extra_info`."""

    def __init__(self, benchmark, config, test):
        self.benchmark, self.config, self.test = benchmark, config, test

    def row(self, what, unit, ours=None, other=None, *, ratios=(), least=None, most=None, remark="", limit="", **more):
        """A row: ours and the other in `unit`; `ratios` of the repeats, of which the median has to be at least `least`,
        or ours at most `most`; `limit` says what keeps it from that."""
        low, ratio, high = np.quantile(ratios, [0.0, 0.5, 1.0]).tolist() if len(ratios) else (None,) * 3
        target = "" if least is most is None else f">= {least:g}" if least is not None else f"<= {most:g}"
        judged = ratio if least is not None else ours
        held = None if not target or judged is None else judged >= least if least is not None else judged <= most
        reached = None if held is None else bool(held)
        row = {"what": what, "unit": unit, "ours": ours, "other": other, "ratio": ratio, "low": low, "high": high}
        row |= {"repeats": len(ratios), "target": target, "reached": reached, "remark": remark, "limit": limit, **more}
        self.config.stash.setdefault(ROWS, []).append(row)
        self.benchmark.extra_info.setdefault("ratios", []).append(row)
        if path := self.config.getoption("--rows"):
            with Path(path).open("a", encoding="utf-8") as file:
                load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
                file.write(json.dumps({"test": self.test, "code": code_version(), "load": load, **row}) + "\n")

    def compare(self, what, unit, ours, other, least, rounds=5, remark="", limit=""):
        """Time both sides in turn, one warm-up and `rounds` each (one round: no warm-up), by CPU time."""
        taken, warm = [], min(rounds - 1, 1)

        def their_turn():
            start = time.process_time()
            other.call()
            taken.append(time.process_time() - start)

        with blas_limited():
            self.benchmark.pedantic(ours.call, setup=their_turn, rounds=rounds, warmup_rounds=warm)
        own, theirs = np.array(self.benchmark.stats.stats.data), np.array(taken[warm:])
        ratios = (ours.units / own) / (other.units / theirs)
        rates = float(np.median(ours.units / own)), float(np.median(other.units / theirs))
        self.row(what, unit, *rates, ratios=ratios.tolist(), least=least, remark=remark, limit=limit)

    def absent(self, what, unit, least, package):
        """The row of a pair whose other side is not installed."""
        self.benchmark.pedantic(lambda: None, rounds=1)
        self.row(what, unit, least=least, remark=f"{package} is not installed; `make timing` installs what PyPI has")

    def cost(self, what, axis, points, most=None, remark="", limit=""):
        """The row of a cost that grows: points (size, CPU s); the slope is that of the last decade, of parameters that
        of all, since other models take other steps."""
        sizes, times = np.log10(np.array(points)).T
        far = sizes >= sizes[-1] - 1.001 if axis != "parameters" else slice(None)
        last, whole = (float(np.polyfit(sizes[chosen], times[chosen], 1)[0]) for chosen in (far, slice(None)))
        told = f"slope of all {whole:.2f}; {remark}"
        self.row(what, "slope", last, most=most, remark=told, limit=limit, axis=axis, points=[list(p) for p in points])


@pytest.fixture
def ratios(benchmark, request):
    return Ratios(benchmark, request.config, request.node.name)


def pytest_addoption(parser):
    parser.addoption("--rows", metavar="FILE", help="append the rows to this file, and go on where it ends")


def pytest_configure(config):
    if path := config.getoption("--rows"):  # a test may work in another folder
        config.option.rows = str(Path(path).absolute())


def pytest_collection_modifyitems(config, items):
    path = config.getoption("--rows")
    if not path or not Path(path).exists():
        return
    rows = [json.loads(line) for line in Path(path).read_text(encoding="utf-8").splitlines()]
    done = {row["test"] for row in rows if row["code"] == code_version()}
    config.hook.pytest_deselected(items=[item for item in items if item.name in done])
    items[:] = [item for item in items if item.name not in done]


def pytest_terminal_summary(terminalreporter, config):
    if not config.stash.get(ROWS, []):
        return
    terminalreporter.section("ratios (CPU time, both sides in this run)")
    for cells in (FIELDS, *([_text(row[field]) for field in FIELDS] for row in config.stash[ROWS])):
        line = "{:46} {:10} {:>9} {:>9} {:>8} {:>8} {:>8} {:>9}  {}".format(*cells)
        terminalreporter.write_line(line.rstrip())


def _text(value):
    return (
        "" if value is None else value if isinstance(value, str) else f"{value:.3g}" if value < 1e6 else f"{value:.2e}"
    )
