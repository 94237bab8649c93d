"""Every cause keeps the contract; and the contract catches causes that break it."""

import pytest

from helmbench.diagnosis.causes.base import Cause, StageCause
from helmbench.diagnosis.causes.registry import all_causes
from helmbench.diagnosis.contract import CHECKS, OF_STAGES


def cases():
    for name, cause in all_causes().items():
        for check in OF_STAGES if not isinstance(cause, Cause) or isinstance(cause, StageCause) else CHECKS:
            yield pytest.param(type(cause), check, id=f"{name}-{check.__name__.removeprefix('check_')}")


@pytest.mark.parametrize(("cls", "check"), list(cases()))
def test_cause_keeps_the_contract(cls, check):
    check(cls)
