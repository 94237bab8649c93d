"""Every registered method keeps the shipped contract."""

from dataclasses import replace

import pytest

from helmbench.methods import contract
from helmbench.methods.learner import Learner
from helmbench.methods.ls import Ls
from helmbench.methods.registry import methods

SLOW = {"pem", "grey-gp", "grey-residual", "ls-svr", "iv", "output-error", "ekf", "ukf", "eso-rw-lssvr", "lts"}
SLOW |= {"rw-ls-svr", "svf-ls"}
SLOW |= {name for name, cls in methods().items() if cls.minutes or issubclass(cls, Learner)}
"""Methods whose whole contract takes more than a few seconds."""
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


@pytest.mark.parametrize("name", sorted(SLOW))
def test_contract_in_brief(name, monkeypatch):
    monkeypatch.setattr(contract, "VESSELS", contract.VESSELS[:1])
    once = type(name, (methods()[name],), {})  # its fits are kept apart from those of the whole contract
    for check in BRIEF:
        check(once)


class UsesTruth(Ls):
    """Returns the true coefficients, which it must not use."""

    name = "uses-truth"
    title = "uses the true coefficients"

    def fit(self, records, model):
        found = super().fit(records, model)
        return replace(found, coefficients=model.coefficients) if model.known else found


class Random(Ls):
    """Another estimate each time."""

    name = "random"
    title = "not deterministic"
    count = 0

    def estimate(self, records, model):
        Random.count += 1
        found = super().estimate(records, model)
        return found._replace(coefficients=found.coefficients * (1.0 + 0.01 * Random.count))


class FirstOnly(Ls):
    """Uses the first record only."""

    name = "first-only"
    title = "depends on the order of the records"

    def estimate(self, records, model):
        return super().estimate(records[:1], model)


class Crashing(Ls):
    """Raises exceptions of its own."""

    name = "crashing"
    title = "raises other exceptions than CannotFit and FitFailed"

    def fit(self, records, model):
        if records and records[0].n < 20:
            raise IndexError("too short")
        return super().fit(records, model)


class IgnoresSign(Ls):
    """Ignores the metadata."""

    name = "ignores-sign"
    title = "ignores the rudder's sign"

    def fit(self, records, model):
        return super().fit([replace(r, meta=replace(r.meta, positive_rudder=None)) for r in records], model)


class ChangesOption(Ls):
    """Does not store its option as given."""

    name = "changes-option"
    title = "changes its option"

    def __init__(self, scheme="forward") -> None:
        super().__init__(scheme + "")
        self.scheme = list(self.scheme)


class ListOnly(Ls):
    """Takes a list of records, not one record."""

    name = "list-only"
    title = "does not take one record"

    def fit(self, records, model):
        return super().fit([*records], model)


class ChangesRecords(Ls):
    """Takes the first heading off the record it was given."""

    name = "changes-records"
    title = "changes the records"

    def fit(self, records, model):
        found = super().fit(records, model)
        for record in records if isinstance(records, (list, tuple)) else [records]:
            heading = record.channels["heading_rad"]
            object.__setattr__(record, "channels", {**record.channels, "heading_rad": heading - heading[0] - 1.0})
        return found


@pytest.mark.parametrize(
    ("cls", "check", "error"),
    [
        (ChangesOption, contract.check_options, AssertionError),
        (ListOnly, contract.check_one_record, TypeError),
        (UsesTruth, contract.check_truth_is_not_used, AssertionError),
        (Random, contract.check_deterministic, AssertionError),
        (FirstOnly, contract.check_record_order, AssertionError),
        (IgnoresSign, contract.check_rudder_sign, AssertionError),
        (ChangesRecords, contract.check_records_are_not_changed, AssertionError),
        (Crashing, contract.check_too_short, IndexError),
    ],
    ids=[
        "changes-option",
        "list-only",
        "uses-truth",
        "random",
        "first-only",
        "ignores-sign",
        "changes-records",
        "crashing",
    ],
)
def test_the_checks_find_methods_that_break_the_contract(cls, check, error):
    with pytest.raises(error):
        check(cls)
