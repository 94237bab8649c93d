"""Rates of the diagnosis over many draws, against the binomial bounds of what it promises: `make rates`.

HELMBENCH_RATE_DRAWS sets how often each expectation is drawn: a few times in `make test-all`.
"""

import os

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
