"""Effects injected by a simulator that shares no code with the kernels must be found; nothing injected must not be.

A random check passes in one of so many draws as its promised rate allows (`tests/expectations/injections.py`); fixed
records are compared with stored outcomes (`test_golden.py`); `make rates` draws many more.
"""

import pytest
from scipy.stats import binom

from helmbench.diagnosis.causes.registry import causes
from helmbench.diagnosis.diagnose import diagnose
from helmbench.diagnosis.innovations.report import SMALL
from helmbench.diagnosis.options import Options
from helmbench.models.model import resolve

from ..expectations.injections import ALONE, COMMON, SPECIAL, fewest, injected, most_draws, passes
from ..nightly_marks import nightly_but

GROUPS = 4
OF_SENSORS = [name for name, cause in causes().items() if cause.where == "sensor"]
BELOW = (SMALL, "significant by its score alone, far behind the strongest cause")


def enough(expectations, rng) -> bool:
    """Whether so many of the expectations pass, each drawn once, as correct code passes at a rate of 0.9."""
    outcome = [expected.check(rng) for expected in expectations]
    print(outcome)
    return sum(outcome) >= fewest(len(outcome), 0.9)


@pytest.mark.nightly
@pytest.mark.parametrize("group", range(GROUPS))
def test_causes_are_found_when_each_is_all_that_the_bank_holds(group, rng):
    assert enough([ALONE[cause] for cause in list(ALONE)[group::GROUPS]], rng)


@pytest.mark.nightly
def test_special_cases_are_told(rng):
    assert enough(SPECIAL, rng)


@pytest.mark.parametrize(("outcome", "drawn"), [(True, 1), (False, most_draws(0.9))])
def test_draws_end_with_the_first_pass(outcome, drawn):
    seen = []
    assert passes(lambda: seen.append(outcome) or outcome, 0.9) == outcome
    assert len(seen) == drawn
    assert binom.cdf(0, most_draws(0.9), 0.9) <= 1e-6 < binom.cdf(0, most_draws(0.9) - 1, 0.9)


@pytest.mark.parametrize("expected", nightly_but(COMMON, COMMON[1], COMMON[3]), ids=[e.name for e in COMMON])
def test_rate_of_what_is_promised(expected, rng):
    assert passes(lambda: expected.check(rng), expected.rate)


def test_a_straight_course_is_inconclusive_and_says_what_to_run(rng):
    case = injected("mariner", (), rng, train=("straight",), held_out=("straight",))
    found = diagnose(resolve("mariner"), case.train)
    assert found.verdict == "inconclusive"
    assert found.causes == ()
    assert "zigzag" in (found.next_manoeuvre or "")


def test_what_is_significant_alone_is_not_told_to_lack_evidence(rng):
    """A faint offset beside fitted coefficients: below the size that matters, if the records show it."""
    case = injected("response-1", ("rudder_offset",), rng, strength="faint")
    found = diagnose(resolve("response-1"), case.train, (), Options(base_parameters="identify", max_effects=1))
    print([(e.cause, e.p_adjusted, e.why) for e in found.bank if e.status == "not_significant"])
    own = [entry for entry in found.bank if entry.cause not in OF_SENSORS]
    for entry in own:
        if entry.status == "not_significant" and entry.p_adjusted is not None:
            assert (entry.p_adjusted < found.alpha) == (entry.why in BELOW)


@pytest.mark.nightly
def test_diagnosis_is_repeatable(rng):
    case = injected("response-1", ("rudder_delay",), rng)
    first, second = (diagnose(resolve("response-1"), case.train, case.held_out[:1]).to_json() for _ in range(2))
    assert without_times(first) == without_times(second)


def without_times(value):
    """A document without the times that its making took."""
    if isinstance(value, dict):
        return {key: without_times(v) for key, v in value.items() if key not in ("wall_s", "cpu_s")}
    return [without_times(v) for v in value] if isinstance(value, list) else value


def test_free_coefficients_take_the_rudder_along(rng):
    """With the coefficients of a response model free its rudder's effectiveness cannot be told."""
    case = injected("cargo", ("yaw_rate_bias",), rng)
    found = diagnose(resolve("cargo"), case.train, options=Options(base_parameters="identify"))
    entries = {e.cause: e for e in found.bank}
    print(case.truth, found.causes, entries["rudder_effectiveness"])
    assert entries["rudder_effectiveness"].status == "not_testable"
