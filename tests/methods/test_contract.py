"""Every registered method keeps the shipped contract."""

from dataclasses import replace

import pytest

from helmbench.methods import contract
from helmbench.methods.ls import Ls
from helmbench.methods.registry import methods


@pytest.mark.parametrize("check", contract.CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", methods())
def test_contract(name, check):
    check(methods()[name])


class Peeking(Ls):
    """Hands back the truth, which it is not to know."""

    name = "peeking"
    title = "a cheat"

    def fit(self, records, model):
        found = super().fit(records, model)
        return replace(found, coefficients=model.coefficients) if model.known else found


class Wavering(Ls):
    """Something else each time."""

    name = "wavering"
    title = "not deterministic"
    count = 0

    def estimate(self, records, model):
        Wavering.count += 1
        found = super().estimate(records, model)
        return found._replace(coefficients=found.coefficients * (1.0 + 0.01 * Wavering.count))


class Recent(Ls):
    """Only looks at the first record."""

    name = "recent"
    title = "depends on the order of the records"

    def estimate(self, records, model):
        return super().estimate(records[:1], model)


class Crashing(Ls):
    """Lets its own exceptions through."""

    name = "crashing"
    title = "raises what it should not"

    def fit(self, records, model):
        if records and records[0].n < 20:
            raise IndexError("too short")
        return super().fit(records, model)


class Blind(Ls):
    """Does not look at the metadata."""

    name = "blind"
    title = "ignores the rudder's sign"

    def fit(self, records, model):
        return super().fit([replace(r, meta=replace(r.meta, positive_rudder=None)) for r in records], model)


@pytest.mark.parametrize(
    ("cls", "check", "error"),
    [
        (Peeking, contract.check_truth_is_not_used, AssertionError),
        (Wavering, contract.check_deterministic, AssertionError),
        (Recent, contract.check_record_order, AssertionError),
        (Blind, contract.check_rudder_sign, AssertionError),
        (Crashing, contract.check_too_short, IndexError),
    ],
    ids=["peeking", "wavering", "recent", "blind", "crashing"],
)
def test_the_checks_catch_offenders(cls, check, error):
    with pytest.raises(error):
        check(cls)
