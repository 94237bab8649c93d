"""The page and the terminal form of an identification: the figures are those of the JSON document."""

import re
from dataclasses import replace
from html import unescape
from xml.etree import ElementTree

import numpy as np
import pytest

from helmbench.datasets.display import shown_name, shown_unit
from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.assessment import assess
from helmbench.estimation.estimates.comparison import compare
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.reporting import media
from helmbench.reporting.identification.page import headline, statement
from helmbench.reporting.identification.page import page as page_of
from helmbench.reporting.numbers import number, r_squared
from helmbench.reporting.runs import key_of, of_validation

from ...support.page_tables import page_tables


@pytest.fixture(scope="module")
def found():
    texts = ("zigzag:20/20", "zigzag:10/10:port")
    train, other = (generate(Case("response-1", text, "low", seed=k)) for k, text in enumerate(texts))
    methods = [(resolve("nomoto-1"), name, make(name)) for name in ("output-error", "ls", "sklearn:Ridge")]
    compared = compare(methods, [train], [other])
    estimate = compared.candidates[0].estimate
    return assess(estimate, [train], [other], compared, ["a doubt about <this>"])


def html(found):
    return media.html(page_of(found))


def terminal(found):
    return media.terminal(page_of(found))


def tables(page):
    return {rows[0][0] + "|" + rows[0][-1]: rows for rows in page_tables(page)[::-1]}


def test_the_figures_of_the_page_are_those_of_the_json(found):
    told, shown = found.to_json(), tables(html(found))
    free = shown["channel|R²"]
    for row in free[1:-1]:
        channel = next(c for c in ("heading_rad", "yaw_rate_rad_s") if shown_name(c) == row[0])
        factor = shown_unit(channel)[1]
        assert row[2] == number(factor * told["validation"][f"rmse_free_{channel}"])
        assert row[3] == r_squared(told["validation"][f"r2_free_{channel}"])
    residuals = shown["records|lags outside 99 %, with the rudder"][1:]
    sides = [*told["residuals"]["train"], *told["residuals"]["held_out"]]
    for row, one in zip(residuals, sides, strict=True):
        assert row[5] == number(one["ratio"], 2) and row[6] == f"{one['in_time']['outside']} of 25"
        assert row[7] == f"{one['with_rudder']['outside']} of {len(one['with_rudder']['values'])}"
    parameters = shown["parameter|published for ships of the kind"][1:]
    for row, one in zip(parameters, told["parameters"], strict=True):
        value, low, high = map(float, re.fullmatch(r"(\S+) \[(\S+), (\S+)\]", row[1]).groups())
        assert [value, low, high] == pytest.approx([one["estimate"], one["low"], one["high"]], rel=2e-2)
        assert all(f"{vessel} {number(v, 4)}" in row[5] for vessel, v in one["published"].items())
    bounds = shown["parameter|smallest relative standard deviation"][1:]
    assert [row[0] for row in bounds] == [one["name"] for one in told["identifiability"]["parameters"]]
    advice = shown["manoeuvre|worst bound after it"][1:]
    assert [row[1] for row in advice] == [number(c["information"], 2) for c in told["identifiability"]["candidates"]]


def test_methods_stand_side_by_side(found):
    rows = tables(html(found))["method|remark"]
    told = found.to_json()["comparison"]["candidates"]
    assert [row[0] for row in rows[1:]] == [one["method"] for one in told] == ["output-error", "ls", "sklearn:Ridge"]
    error = rows[0].index("error")
    assert [row[error] for row in rows[1:]] == [number(one["error"]) for one in told]
    assert rows[3][1] == "black box" and sum("chosen" in row[-1] for row in rows[1:]) == 1


def test_the_runs_of_the_compared_methods_are_drawn_over_the_held_out_record(found):
    drawn = html(found).partition("Free runs along the held-out records")[2]
    methods = [one.method for one in sorted(found.comparison.candidates, key=lambda one: one.error)]
    assert list(found.compared.models) == methods and all(f"</i>{name}</span>" in drawn for name in methods)
    for one in found.comparison.candidates:
        assert found.compared.score("heading_rad", one.method).rmse == pytest.approx(
            one.pooled("heading_rad").scores()[0]
        )
    runs = re.findall(r"<svg.*?</svg>", drawn, re.DOTALL)[0]
    colours = {colour for _, colour, _ in key_of(of_validation(found.compared))}
    assert set(re.findall(r"stroke: (#[0-9a-f]{6})", runs)) >= colours


def test_the_page_is_one_file_with_its_charts(found):
    page = html(found)
    assert not re.findall(r"""(?:src|href)\s*=\s*"(?!#)|url\((?!#)|@import""", page)
    drawings = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    # The held-out record; the runs along both and of the comparison; two correlations a channel.
    assert len(drawings) == 1 + 2 + 2 * 2 + 1
    for drawing in drawings:
        ElementTree.fromstring(drawing)
    assert not any("nan" in path for path in re.findall(r' d="(.*?)"', page))
    assert "&lt;this&gt;" in page and "<this>" not in page
    heads = re.findall(r"<h2>(.*?)</h2>", page)
    assert heads == ["Measured and simulated", "The model", "What remains", "What to sail next", "More"]
    assert page.index(headline(found)) < page.index("<h2>")


def test_the_headline_names_the_model_that_was_chosen_from_several(found):
    """A model that was beaten is not called the best, a built one that was taken instead is."""
    chosen = replace(found, estimate=found.comparison.chosen.estimate)
    assert headline(chosen).startswith(f"The best of 3 models, {found.name}, ")
    beaten = next(one.estimate for one in found.comparison.candidates if one is not found.comparison.chosen)
    assert headline(replace(found, estimate=beaten)).startswith("The model ")
    built = replace(found, estimate=replace(found.estimate, method="ladder"))
    assert headline(built).startswith("The best of 4 models, ")
    assert headline(replace(found, comparison=None)).startswith("The model ")


def test_every_sentence_is_on_page_and_terminal(found):
    page, text = unescape(html(found)), terminal(found)
    assert len(statement(found)) >= 4
    for sentence in statement(found):
        assert sentence in page and sentence in text
    worst = max(found.exceeding, key=lambda one: one.ratio)
    assert f"({number(worst.ratio, 2)} times)" in statement(found)[0]


def test_a_model_that_the_records_do_not_determine_says_which(found):
    train = generate(Case("mariner", "zigzag:10/10", "high", seed=1, duration_s=200.0))
    told = assess(make("ls").fit([train], resolve("mariner")), [train])
    poor = told.identifiability.names[2]
    assert poor and any(
        f"do not determine {len(poor)} of {len(told.parameters)} parameters" in line for line in statement(told)
    )
    assert np.isfinite(told.train.score(None).r2) and "No record was held out" in terminal(told)
