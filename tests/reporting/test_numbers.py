"""The number formatter."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helmbench.reporting import numbers


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (None, 3, "–"),
        (math.nan, 3, "–"),
        (math.inf, 3, "inf"),
        (-math.inf, 3, "-inf"),
        (0.0, 3, "0"),
        (-0.0, 3, "0"),
        (0.01234, 3, "0.0123"),
        (3.2e-9, 3, "3.2e-9"),
        (-0.5, 3, "-0.5"),
        (1994.5, 3, "1994"),
        (123456.7, 3, "1.23e5"),
        (364500.0, 5, "364500"),
        (12345678.0, 3, "1.23e7"),
        (0.123456, 5, "0.12346"),
    ],
)
def test_numbers_are_short(value, digits, text):
    assert numbers.number(value, digits) == text


@given(st.floats(-1e300, 1e300), st.integers(2, 8))
def test_a_number_comes_back_to_its_digits(value, digits):
    assert float(numbers.number(value, digits)) == pytest.approx(value, rel=0.51 * 10.0 ** (1 - digits), abs=0.0)


@pytest.mark.parametrize(("value", "text"), [(2.0, "2 s"), (0.0021, "2.1 ms"), (3e-6, "3 us"), (5e-10, "0.5 ns")])
def test_durations_have_a_fitting_unit(value, text):
    assert numbers.duration(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (0.5, "0.500"), (0.00052, "0.00052"), (1.2e-7, "1.2e-7"), (1e-20, "< 1e-16")]
)
def test_p_values(value, text):
    assert numbers.p_value(value) == text


@pytest.mark.parametrize(("value", "text"), [(None, "–"), (0.98765, "0.988"), (-3.0, "-3.000"), (-1234.5, "-1234")])
def test_r_squared(value, text):
    assert numbers.r_squared(value) == text


def test_shares_units_and_intervals():
    assert numbers.percent(0.0432, 1) == "4.3 %" and numbers.percent(None) == "–"
    assert numbers.with_unit(0.5, "m/s") == "0.5 m/s" and numbers.with_unit(0.5, "1") == "0.5"
    assert numbers.interval(0.1, 0.05, 0.2) == "0.1 [0.05, 0.2]"
    assert numbers.interval(math.inf, math.inf, math.inf) == "inf" and numbers.interval(None, None, None) == "–"


@pytest.mark.parametrize(
    ("bounds", "digits"), [((1.0, 0.9, 1.1), 3), ((100.0, 99.99, 100.01), 6), ((1.0, 1.0, 1.0), 3)]
)
def test_digits_show_the_width_of_an_interval(bounds, digits):
    assert numbers.interval_digits(*bounds) == digits
    low, high = (numbers.number(bound, digits) for bound in bounds[1:])
    assert low != high or bounds[1] == bounds[2]
