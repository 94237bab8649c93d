"""CPU time of every test: the ten slowest at the end of a run, and the command that repeats a failure."""

import os
from collections import defaultdict

import pytest

from .seeds import SHIFT

SHOWN = 10
LIMIT_S = 10.0
REASONS = {
    "tests/datasets/importing/bank/test_bank.py::test_nothing_goes_in_wrong_without_a_word": "imports the bank of logs",
    "tests/test_readme.py::test_the_blocks_write_what_is_said": "runs the README",
    "tests/helmbench/open/test_in_browser.py::test_from_a_dropped_log_to_the_diagnosis": "the end of the browser and "
    "of the server, whose time is that of the module",
}
"""Test -> why it takes more than LIMIT_S of CPU time."""
MARK = pytest.StashKey[float]()


def cpu_s() -> float:
    """CPU time of this process and of its children that have ended, s."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    """The clock of the test's first phase starts."""
    item.stash[MARK] = cpu_s()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item):
    """A report of a phase (set-up, call, end) has its CPU time; that of a failure says how to repeat it."""
    report = yield
    now = cpu_s()
    report.cpu_s, item.stash[MARK] = now - item.stash[MARK], now
    if report.failed:
        shift = f"HELMBENCH_SEED={SHIFT} " if SHIFT else ""
        report.sections.append(("repeat with", f"{shift}.venv/bin/pytest '{item.nodeid}'"))
    return report


def pytest_report_header():
    """What all seeds are shifted by."""
    return f"seeds: HELMBENCH_SEED={SHIFT}"


def pytest_terminal_summary(terminalreporter):
    """The slowest tests, and those over the limit for which no reason is stated."""
    reports = [r for reports in terminalreporter.stats.values() for r in reports if hasattr(r, "cpu_s")]
    phases = defaultdict(lambda: {"setup": 0.0, "call": 0.0, "teardown": 0.0})
    for report in reports:
        phases[report.nodeid][report.when] += report.cpu_s
    if not phases:
        return
    slowest = sorted(phases.items(), key=lambda item: -sum(item[1].values()))
    total = sum(sum(spent.values()) for spent in phases.values())
    terminalreporter.section(f"{len(phases)} tests took {total:.0f} s of CPU time; the slowest")
    terminalreporter.write_line("set-up   call    end  s")
    for name, spent in slowest[:SHOWN]:
        over = sum(spent.values()) > LIMIT_S
        reason = f"  ({REASONS.get(name, 'no reason is stated in tests/cpu_times.py')})" if over else ""
        terminalreporter.write_line("".join(f"{s:6.1f} " for s in spent.values()) + f"  {name}{reason}")
