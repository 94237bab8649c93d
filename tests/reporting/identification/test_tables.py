"""Tables of one identification."""

import math
from dataclasses import replace

import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.reporting.identification.tables import parameter_table, profile_interval, share, standard_error
from helmbench.reporting.tables import console


@pytest.fixture(scope="module")
def estimate():
    return make("ls").fit([generate(Case("response-1", "zigzag:20/20", "low"))], resolve("response-1"))


def test_every_parameter_has_its_value_and_error(estimate):
    rows = parameter_table(estimate).rows
    assert [row[0].text for row in rows] == list(estimate.parameters)
    for row, (name, value) in zip(rows, estimate.parameters.items(), strict=True):
        assert row[1].value == value and float(row[1].text) == pytest.approx(value, rel=1e-4)
        assert row[2].text == standard_error(estimate.stderr[name])


def test_open_ends_have_round_brackets(estimate):
    profile = {"low": 0.1, "high": 2.0, "low_open": False, "high_open": True}
    assert profile_interval(profile) == "[0.1, 2)" and profile_interval(None) == ""
    name = next(iter(estimate.parameters))
    shown = console(parameter_table(replace(estimate, extra={"profile": {name: profile}})))
    assert shown.splitlines()[0].endswith("profile interval") and shown.splitlines()[1].endswith("[0.1, 2)")


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
