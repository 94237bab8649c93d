"""Tables of one identification."""

import math
from dataclasses import replace

import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.assessment import assess
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.reporting.identification.page import assessed_table, share, standard_error


@pytest.fixture(scope="module")
def found():
    record = generate(Case("response-1", "zigzag:20/20", "low"))
    return assess(make("ls").fit([record], resolve("response-1")), [record])


def test_every_parameter_has_its_value_and_error(found):
    estimate, rows = found.estimate, assessed_table(found).rows
    assert [row[0].text for row in rows] == list(estimate.parameters)
    for row, (name, value), one in zip(rows, estimate.parameters.items(), found.parameters, strict=True):
        assert row[1].value == value
        assert abs(float(row[1].text.split()[0]) - value) < 0.05 * (one.high - one.low)
        assert row[3].text == standard_error(estimate.stderr[name])


def test_open_ends_have_round_brackets(found):
    profile = {"low": 0.1, "high": 2.0, "low_open": False, "high_open": True}
    name = next(iter(found.estimate.parameters))
    profiled = replace(found.estimate, extra={"profile": {name: profile}})
    assert assessed_table(replace(found, estimate=profiled)).rows[0][1].text.endswith(" [0.1, 2)")


@pytest.mark.parametrize(
    ("value", "text"), [(0.0123, "+- 0.012"), (0.0, "fixed"), (math.inf, "not identified"), (math.nan, "")]
)
def test_standard_errors(value, text):
    assert standard_error(value) == text


@pytest.mark.parametrize(
    ("bound", "text"), [(0.0123, "1.2 %"), (2.5, "250 %"), (math.inf, "not determined"), (math.nan, "–")]
)
def test_shares(bound, text):
    assert share(bound) == text
