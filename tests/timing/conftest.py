"""Ratios taken in one run: both sides timed in turn, one thread of linear algebra, a table after the timings."""

import time
from typing import NamedTuple

import pytest

from helmbench.estimation.fit import blas_limited

FIELDS = ("what", "unit", "ours", "other", "ratio", "target", "remark")
ROWS = pytest.StashKey[list]()


class Side(NamedTuple):
    """One of two that are compared: a function without arguments, and how many units one call is worth."""

    call: object
    units: float = 1.0


class Ratios:
    """Writes rows of the table, and the same figures into the benchmark's `extra_info`."""

    def __init__(self, benchmark, rows):
        self.benchmark, self.rows = benchmark, rows

    def row(self, what, unit, ours, target, other=None, ratio=None, remark=""):
        values = (what, unit, ours, other, ratio, target, remark)
        self.rows.append(dict(zip(FIELDS, values, strict=True)))
        self.benchmark.extra_info.setdefault("ratios", []).append(self.rows[-1])

    def compare(self, what, unit, ours, other, target, rounds=5, remark=""):
        """Time both sides in turn, one warm-up and `rounds` each (one round: no warm-up); the least CPU time counts."""
        taken = []

        def their_turn():
            start = time.process_time()
            other.call()
            taken.append(time.process_time() - start)

        with blas_limited():
            self.benchmark.pedantic(ours.call, setup=their_turn, rounds=rounds, warmup_rounds=min(rounds - 1, 1))
        rates = ours.units / self.benchmark.stats.stats.min, other.units / min(taken)
        self.row(what, unit, rates[0], target, rates[1], rates[0] / rates[1], remark)


@pytest.fixture
def ratios(benchmark, request):
    return Ratios(benchmark, request.config.stash.setdefault(ROWS, []))


def pytest_terminal_summary(terminalreporter, config):
    if not config.stash.get(ROWS, []):
        return
    terminalreporter.section("ratios (CPU time, both sides in this run)")
    for cells in (FIELDS, *([_text(row[field]) for field in FIELDS] for row in config.stash[ROWS])):
        line = "{:46} {:10} {:>9} {:>9} {:>8} {:>9}  {}".format(*cells)
        terminalreporter.write_line(line.rstrip())


def _text(value):
    return (
        "" if value is None else value if isinstance(value, str) else f"{value:.3g}" if value < 1e6 else f"{value:.2e}"
    )
