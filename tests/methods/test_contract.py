"""Every registered method keeps the shipped contract."""

from dataclasses import replace
from itertools import count

import pytest

from helmbench.methods import contract
from helmbench.methods.learner import Learner
from helmbench.methods.ls import Ls
from helmbench.methods.registry import methods

from ..nightly_marks import nightly_but

SLOW = {"pem", "grey-gp", "grey-residual", "ls-svr", "iv", "output-error", "ekf", "ukf", "eso-rw-lssvr", "lts"}
SLOW |= {"rw-ls-svr", "svf-ls"}
SLOW |= {name for name, cls in methods().items() if cls.minutes or issubclass(cls, Learner)}
"""Methods whose whole contract takes more than a few seconds."""
FITS = count(1)
BRIEF = (contract.check_options, contract.check_estimate, contract.check_missing_channels)
"""What `make test` checks of them, on one vessel."""
PAIRS = [
    pytest.param(name, check, id=f"{name}-{check.__name__}", marks=[pytest.mark.nightly] * (name in SLOW))
    for name in methods()
    for check in contract.CHECKS
]


@pytest.fixture(autouse=True)
def searches_are_short(monkeypatch):
    """The contract does not depend on how many values a search tries."""
    for cls in methods().values():
        if issubclass(cls, Learner):
            monkeypatch.setattr(cls, "usual_trials", 1)


@pytest.mark.parametrize(("name", "check"), PAIRS)
def test_contract(name, check):
    check(methods()[name])


@pytest.mark.parametrize("name", nightly_but(sorted(SLOW), *SLOW - {"lstm"}))
def test_contract_in_brief(name, monkeypatch):
    monkeypatch.setattr(contract, "VESSELS", contract.VESSELS[:1])
    once = type(name, (methods()[name],), {})  # its fits are kept apart from those of the whole contract
    for check in BRIEF:
        check(once)


def uses_truth(self, records, model):
    found = Ls.fit(self, records, model)
    return replace(found, coefficients=model.coefficients) if model.known else found


def another_each_time(self, records, model):
    found = Ls.estimate(self, records, model)
    return found._replace(coefficients=found.coefficients * (1.0 + 0.01 * next(FITS)))


def uses_the_first_record(self, records, model):
    return Ls.estimate(self, records[:1], model)


def crashes_on_short_records(self, records, model):
    if records and records[0].n < 20:
        raise IndexError("too short")
    return Ls.fit(self, records, model)


def ignores_the_sign(self, records, model):
    return Ls.fit(self, [replace(r, meta=replace(r.meta, positive_rudder=None)) for r in records], model)


def changes_its_option(self, scheme="forward"):
    Ls.__init__(self, scheme + "")
    self.scheme = list(self.scheme)


def takes_a_list_only(self, records, model):
    return Ls.fit(self, [*records], model)


def changes_records(self, records, model):
    """Takes the first heading off the record it was given."""
    found = Ls.fit(self, records, model)
    for record in records if isinstance(records, (list, tuple)) else [records]:
        heading = record.channels["heading_rad"]
        object.__setattr__(record, "channels", {**record.channels, "heading_rad": heading - heading[0] - 1.0})
    return found


@pytest.mark.parametrize(
    ("name", "broken", "check", "error"),
    [
        ("__init__", changes_its_option, contract.check_options, AssertionError),
        ("fit", takes_a_list_only, contract.check_one_record, TypeError),
        ("fit", uses_truth, contract.check_truth_is_not_used, AssertionError),
        ("estimate", another_each_time, contract.check_deterministic, AssertionError),
        ("estimate", uses_the_first_record, contract.check_record_order, AssertionError),
        ("fit", ignores_the_sign, contract.check_rudder_sign, AssertionError),
        ("fit", changes_records, contract.check_records_are_not_changed, AssertionError),
        ("fit", crashes_on_short_records, contract.check_too_short, IndexError),
    ],
)
def test_the_checks_find_methods_that_break_the_contract(name, broken, check, error):
    cls = type("Broken", (Ls,), {"name": "broken", "title": "breaks the contract", name: broken})
    with pytest.raises(error):
        check(cls)
