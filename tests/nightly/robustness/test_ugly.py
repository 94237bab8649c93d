"""Ugly inputs end in a result or in one clear line, and name no cause: `make ugly`.

HELMBENCH_UGLY_DRAWS sets how many inputs of each kind are drawn.
"""

import os

import pytest

from .sweep import KINDS, outcomes

DRAWS = int(os.environ.get("HELMBENCH_UGLY_DRAWS", "5"))


@pytest.mark.parametrize("kind", KINDS)
def test_ugly_records_end_in_a_result_or_in_one_clear_line(kind, seed):
    found = [(seed + draw, one) for draw in range(DRAWS) for one in outcomes(kind, seed + draw)]
    print("\n".join(f"{kind} | {drawn} | {one}" for drawn, one in found))
    assert not [f"{drawn} | {one}" for drawn, one in found if one.failed]
