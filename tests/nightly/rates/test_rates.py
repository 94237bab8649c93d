"""Rates of the diagnosis over many draws, against the binomial bounds of what it promises: `make rates`.

HELMBENCH_RATE_DRAWS sets how often each expectation is drawn: a few times in `make test-all`.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from ...expectations.calibrations import CALIBRATED
from ...expectations.injections import ALONE, COMMON, SPECIAL, fewest
from .late_rudder import LATE_RUDDER
from .two_numbers import TWO_NUMBERS

DRAWS = int(os.environ.get("HELMBENCH_RATE_DRAWS", "5"))
EXPECTATIONS = {
    **{f"alone-{cause}": expected for cause, expected in ALONE.items()},
    **{expected.name: expected for expected in (*SPECIAL, *COMMON, *CALIBRATED, LATE_RUDDER, TWO_NUMBERS)},
}


@pytest.mark.parametrize("name", EXPECTATIONS)
def test_rate_is_not_below_what_is_promised(name, rng):
    expected = EXPECTATIONS[name]
    passed = sum(expected.check(rng) for _ in range(DRAWS))
    print(f"{name}: {passed} of {DRAWS}, promised {expected.rate}")
    assert passed >= fewest(DRAWS, expected.rate)


# ---- Many kills: `make rates`.

ROOT = Path(__file__).resolve().parents[3]


def test_runs_killed_a_thousand_times_end_as_unbroken_ones(tmp_path, seed):
    command = [sys.executable, "-m", "tests.bench.killed_runs", str(tmp_path), str(seed), "1000"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
