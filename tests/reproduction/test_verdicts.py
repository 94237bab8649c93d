"""Intervals over seeds and the four verdicts."""

import math

import numpy as np
import pytest
from pydantic import TypeAdapter

from helmbench.models.plain import plain
from helmbench.reproduction.claims.claim import Claim, Reference, Tolerance
from helmbench.reproduction.verdicts import (
    CONSISTENT,
    CONTRADICTED,
    CORRECTED,
    IN_REACH,
    NO_VALUE,
    NOT_COMPUTABLE,
    NOT_REACHED,
    NOT_USED,
    REPRODUCED,
    Spread,
    judge,
    prediction_interval,
    spread,
    summarise,
    within,
)

FACTS = {
    "id": "a",
    "kind": "result",
    "stated": True,
    "item": "Table 1",
    "quantity": "q",
    "study": "s",
    "corrected": "c",
    "as_printed": "p",
}
CLAIM = Claim(**FACTS, published=10.0, tolerance=Tolerance(absolute=0.5))
ALONE = CLAIM.model_copy(update=dict(as_printed=""))


def verdict(claim, **runs):
    return judge(claim, {key: spread(values) for key, values in runs.items()}).verdict


@pytest.mark.parametrize(
    ("corrected", "printed", "expected"),
    [
        ([10.4], [10.4], REPRODUCED),
        ([20.0], [10.4], REPRODUCED),
        ([9.6], [20.0], CORRECTED),
        ([9.6], [math.nan], CORRECTED),
        ([9.4], [20.0], CONTRADICTED),
        ([math.nan], [20.0], CONTRADICTED),
        ([math.nan], [math.nan], NO_VALUE),
    ],
)
def test_verdicts_of_values(corrected, printed, expected):
    assert verdict(CLAIM, c=corrected, p=printed) == expected


def test_without_a_printed_form_ours_decides():
    assert verdict(ALONE, c=[10.4]) == REPRODUCED
    assert verdict(ALONE, c=[11.0]) == CONTRADICTED
    assert verdict(ALONE) == NO_VALUE


def test_contradicted_only_outside_the_interval():
    runs = [7.0, 8.0, 9.0, 8.5, 7.5]
    low, high = prediction_interval(np.sort(runs))
    for published, expected in ((high + 0.4, REPRODUCED), (high + 0.6, CONTRADICTED), (low - 0.4, REPRODUCED)):
        assert verdict(ALONE.model_copy(update=dict(published=published)), c=runs) == expected


@pytest.mark.parametrize(("form", "good", "bad"), [("at_most", 3.0, 11.0), ("at_least", 30.0, 9.0)])
def test_bounds(form, good, bad):
    claim = ALONE.model_copy(update=dict(form=form))
    assert verdict(claim, c=[good]) == REPRODUCED
    assert verdict(claim, c=[bad]) == CONTRADICTED


def test_statements_hold_where_well_over_half_of_the_runs_show_them():
    claim = CLAIM.model_copy(update=dict(form="holds", published=True))
    assert verdict(claim, c=[True, True, True, False], p=[False, True, False, False]) == CORRECTED
    assert verdict(claim.model_copy(update=dict(published=False)), c=[True], p=[False]) == REPRODUCED
    assert verdict(claim, c=[False], p=[False]) == CONTRADICTED


@pytest.mark.parametrize(("true", "expected"), [(4, CONTRADICTED), (5, CONSISTENT), (6, REPRODUCED)])
def test_statements_that_half_of_the_runs_show_are_not_decided(true, expected):
    """Of ten runs 4 are false, 6 are true, 5 decide nothing: the tolerance is a tenth."""
    claim = ALONE.model_copy(update=dict(form="holds", published=True))
    runs = [True] * true + [False] * (10 - true)
    assert verdict(claim, c=runs) == expected
    if expected == CONSISTENT:
        assert "about half of the runs" in judge(claim, {"c": spread(runs)}).reason


def test_nothing_is_contradicted_that_depends_on_what_is_not_printed():
    """Without `stated` and without a search a disagreement decides nothing; nor does an agreement with a stand-in."""
    unsaid = ALONE.model_copy(update=dict(stated=False))
    assert verdict(unsaid, c=[20.0]) == NOT_REACHED and verdict(unsaid, c=[10.0]) == REPRODUCED
    unprinted = ALONE.model_copy(update=dict(unprinted="The ship is unknown."))
    assert verdict(unprinted, c=[10.0]) == CONSISTENT and verdict(unprinted, c=[20.0]) == NOT_REACHED
    assert judge(unprinted, {"c": spread([10.0])}).reason == "The ship is unknown."


@pytest.mark.parametrize(
    ("searched", "expected"),
    [
        ([14.0, 16.0, 18.0] * 3, CONTRADICTED),
        ([14.0, 16.0, 23.0] * 3, NOT_REACHED),  # a search leaves gaps: the published 10 is near its range
        ([14.0, 16.0, 18.0], NOT_REACHED),
        ([9.0, 12.0] * 4, IN_REACH),
        ([10.4, math.nan] * 4, IN_REACH),
    ],
)
def test_contradicted_only_where_the_range_does_not_hold_it(searched, expected):
    claim = ALONE.model_copy(update=dict(stated=False, search="wide"))
    judged = judge(claim, {"c": spread([20.0])}, searched={"c": spread(searched)}, over="step 1 to 2 s")
    assert judged.verdict == expected and "Searched: step 1 to 2 s" in judged.reason


def test_a_statement_that_is_true_somewhere_in_the_range_is_not_contradicted():
    claim = ALONE.model_copy(update=dict(stated=False, search="wide", form="holds", published=True))
    for found, expected in (([True] + [False] * 9, IN_REACH), ([False] * 10, CONTRADICTED)):
        assert judge(claim, {"c": spread([False])}, searched={"c": spread(found)}, over="x").verdict == expected


@pytest.mark.parametrize(("low", "expected"), [(101.0, CONTRADICTED), (99.0, NOT_REACHED)])
def test_the_range_of_sizes_is_widened_by_its_ratio(low, expected):
    """Half of the decades from 100 to 10000 reach down to 10."""
    claim = ALONE.model_copy(update=dict(stated=False, search="wide", scale="log", tolerance=Tolerance()))
    found = spread([low, 1e4 * low / 100.0] * 4)
    assert judge(claim, {"c": spread([1e3])}, searched={"c": found}, over="x").verdict == expected


@pytest.mark.parametrize(("true", "expected"), [(2, IN_REACH), (0, CONTRADICTED)])
def test_a_statement_that_is_true_in_a_few_of_our_runs_is_not_contradicted(true, expected):
    claim = ALONE.model_copy(update=dict(stated=False, search="wide", form="holds", published=True))
    own = spread([True] * true + [False] * (20 - true))
    assert judge(claim, {"c": own}, searched={"c": spread([False] * 10)}, over="x").verdict == expected


def test_a_search_in_one_run_says_where_it_is_true():
    claim = ALONE.model_copy(update=dict(stated=False, search="wide", form="holds", published=True))
    for found, text in ((True, "true at a part of it"), (False, "nowhere true")):
        judged = judge(claim, {"c": spread([False])}, searched={"c": spread([found])}, over="x")
        assert judged.reason.endswith(f"Searched: x; found: {text}.")


def test_verdicts_do_not_depend_on_the_last_digit():
    claim = ALONE.model_copy(update=dict(tolerance=Tolerance()))
    assert verdict(claim, c=[10.0 * (1.0 + 1e-7)]) == verdict(claim, c=[10.0 * (1.0 - 1e-7)]) == REPRODUCED
    assert verdict(claim, c=[10.0 * (1.0 + 1e-5)]) == CONTRADICTED


def test_reasons_may_name_any_value_of_the_study():
    claim = ALONE.model_copy(update=dict(reason="from {found[other]} s on"))
    assert judge(claim, {"c": spread([1.0]), "other": spread([2.5])}).reason == "from 2.5 s on"


@pytest.mark.parametrize(
    ("corrected", "printed", "expected"),
    [
        ([6.0, 10.0, 14.0], [6.0, 10.0, 14.0], CONSISTENT),
        ([9.8, 10.0, 10.2], [6.0, 10.0, 14.0], CORRECTED),
        ([6.0, 10.0, 14.0], [9.8, 10.0, 10.2], REPRODUCED),
        ([95.0, 100.0, 105.0], [97.0, 100.0, 103.0], CONTRADICTED),
    ],
)
def test_an_interval_wider_than_the_value_reproduces_nothing(corrected, printed, expected):
    assert verdict(CLAIM, c=corrected, p=printed) == expected
    if expected == CONSISTENT:
        assert verdict(CLAIM.model_copy(update=dict(widest=math.inf)), c=corrected, p=printed) == REPRODUCED
        assert "wider than the value" in judge(CLAIM, {"c": spread(corrected), "p": spread(printed)}).reason


def test_errors_have_intervals_of_their_logarithms():
    errors = [0.01, 0.1, 1.0]
    low, high = prediction_interval(np.array(errors), logarithmic=True)
    assert low > 0.0 and low * high == pytest.approx(0.01)
    assert prediction_interval(np.array(errors))[0] < 0.0
    mixed = np.array([-1.0, 0.1, 1.0])
    assert prediction_interval(mixed, logarithmic=True) == prediction_interval(mixed)
    found = summarise([{"error": e, "value": e} for e in errors], {"error"})
    assert found["error"].low > 0.0 > found["value"].low


@pytest.mark.parametrize(("field", "expected"), [("missing", NOT_COMPUTABLE), ("unused", NOT_USED)])
def test_what_is_missing_or_not_used_has_a_label_of_its_own_and_says_why(field, expected):
    facts = {"id": "a", "kind": "setting", "item": "Table 1", "quantity": "q", "published": "words"}
    judged = judge(Claim(**facts, **{field: "There is no number."}), {})
    assert (judged.verdict, judged.reason) == (expected, "There is no number.")
    with pytest.raises(ValueError, match="either a study or what is missing"):
        Claim(**facts)


def test_runs_that_end_before_they_converge_agree_with_a_lower_bound():
    claim = ALONE.model_copy(update=dict(form="at_least", unprinted="The band is not printed.", censored=True))
    assert verdict(claim, c=[math.nan, math.nan]) == CONSISTENT
    assert verdict(claim.model_copy(update=dict(censored=False)), c=[math.nan, math.nan]) == NO_VALUE
    assert verdict(claim.model_copy(update=dict(form="at_most")), c=[math.nan, math.nan]) == NO_VALUE


def test_one_reason_may_serve_all_open_verdicts():
    claim = ALONE.model_copy(update=dict(stated=False, reason={"open": "The noise decides it."}))
    assert judge(claim, {"c": spread([20.0])}).reason == "The noise decides it."
    assert judge(claim, {"c": spread([10.0])}).reason == "Ours agrees."


def test_reasons_are_filled_in():
    claim = CLAIM.model_copy(update=dict(reason={CONTRADICTED: "{published}, {corrected}, {as_printed}"}))
    values = {"c": spread([1.0]), "p": spread([math.nan])}
    assert judge(claim, values).reason == "10, 1, no finite value"


def test_a_run_in_half_of_which_numbers_are_lost():
    assert spread([1.0, math.nan]).known and not spread([1.0, math.nan, math.nan]).known


def test_interval_holds_a_further_run(rng):
    """Prediction intervals of 10 and of 79 normal runs hold the next one in 95 % of the cases."""
    for n in (10, 79):
        hits = 0
        for _ in range(2000):
            values = rng.normal(size=n + 1)
            low, high = prediction_interval(np.sort(values[:n]))
            hits += low <= values[n] <= high
        assert hits / 2000 == pytest.approx(0.95, abs=0.018)


def test_stored_spreads_come_back():
    found = summarise([{"a": 1.0, "b": True}, {"a": None}, {"a": 3.0, "b": False}])
    assert found["a"].finite == 2 and found["b"].n == 3 and found["b"].mean == 0.5
    stored = plain(found)
    assert TypeAdapter(dict[str, Spread]).validate_python(stored) == found
    assert math.isnan(TypeAdapter(Spread).validate_python(stored["a"] | {"low": None}).low)


@pytest.mark.parametrize(
    ("form", "good", "bad"), [("value", 2.04, 2.2), ("at_most", -9.0, 2.2), ("at_least", 9.0, 1.8)]
)
def test_references(form, good, bad):
    reference = Reference(value=2.0, tolerance=Tolerance(relative=0.05), form=form)
    assert within(reference, spread([good])) and not within(reference, spread([bad]))
