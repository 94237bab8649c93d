"""The page and the terminal form of a validation: the figures are those of the result."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from helmbench.datasets.display import shown_name, shown_unit
from helmbench.datasets.generator import Case, generate
from helmbench.estimation.validation.result import FREE
from helmbench.estimation.validation.validate import validate
from helmbench.models.model import resolve
from helmbench.reporting import media
from helmbench.reporting.numbers import number, r_squared
from helmbench.reporting.validation.page import page as page_of

from ...support.page_tables import page_tables


@pytest.fixture(scope="module")
def found():
    model = resolve("mariner")
    other = replace(model.with_coefficients(1.03 * model.coefficients), id="other")
    records = [generate(Case("mariner", text, "low", seed=k)) for k, text in enumerate(("zigzag:10/10", "turn:35"))]
    return validate(
        {"mariner": model, "other": other, "response-1": resolve("response-1")},
        {"zigzag": records[0], "<turn>": records[1]},
    )


def html(found):
    return media.html(page_of(found))


def test_the_figures_of_the_page_are_those_of_the_json(found):
    free, _, ahead, indices, records = page_tables(html(found))
    every = found.to_json()
    scores = {(s["model"], s["record"], s["channel"], s["horizon"]): s for s in every["scores"] + every["simple"]}
    checked = 0
    for row in free[1:]:
        channel = next((c for _, _, c, _ in scores if c and shown_name(c) == row[0]), None)
        for column, title in enumerate(free[0][2:], start=2):
            kind, model = title.split(" ", 1)
            score = scores.get((model, None, channel, FREE))
            factor = shown_unit(channel)[1] if channel else np.nan
            text = (
                "–" if score is None else number(factor * score["rmse"]) if kind == "RMSE" else r_squared(score["r2"])
            )
            assert row[column] == text
            checked += 1
    for row in ahead[1:]:
        channel = next(c for _, _, c, _ in scores if c and shown_name(c) == row[0])
        for column, title in enumerate(ahead[0][3:], start=3):
            score = scores.get((row[2], None, channel, title.removeprefix("after ")))
            if row[2] == "sensor noise" and title.startswith("after "):
                score = {"rmse": found.noise[channel]}
            assert row[column] == ("–" if score is None else number(shown_unit(channel)[1] * score["rmse"]))
            checked += 1
    for row in records[1:]:
        for column, title in enumerate(records[0][2:-1], start=2):
            channel = next(c for _, _, c, _ in scores if c and shown_name(c) == title.split(",")[0])
            score = scores.get((row[1], row[0], channel, FREE))
            assert row[column] == ("–" if score is None else number(shown_unit(channel)[1] * score["rmse"]))
            checked += 1
    for row in indices[1:]:
        own = [i for i in found.to_json()["indices"] if (i["record"], i["name"].replace("_", " ")) == (row[0], row[2])]
        factor = np.rad2deg(1.0) if row[3] == "deg" else 1.0
        assert row[4] == number(factor * own[0]["measured"])
        for column, title in enumerate(indices[0][5:8], start=5):
            (index,) = [i for i in own if title == f"simulated {i['model']}"]
            assert row[column] == number(factor * index["simulated"])
            checked += 1
    assert checked > 80


def test_the_page_is_one_file_with_the_runs_and_the_track_of_each_record(found):
    page = html(found)
    assert not re.findall(r"""(?:src|href)\s*=\s*"(?!#)|url\((?!#)|@import""", page)
    drawings = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(drawings) == 2 + 2 * 2
    for drawing in drawings:
        ElementTree.fromstring(drawing)
    assert not any("nan" in path for path in re.findall(r' d="(.*?)"', page))
    assert "<turn>" not in page and "&lt;turn&gt;" in page
    heads = re.findall(r"<h2>(.*?)</h2>", page)
    assert heads == ["Measured and simulated", "Errors of free runs", "Errors ahead", "Manoeuvring indices", "More"]


def test_a_divergence_is_told_first_and_on_the_terminal():
    model = resolve("response-1")
    wild = model.with_coefficients([0.05, model.coefficients[1], 0.0])
    found = validate({"wild": wild}, {"one": generate(Case("response-1", "zigzag:20/20"))})
    page, text = html(found), media.terminal(page_of(found))
    told = f"wild along one: {found.runs[0].told}"
    assert found.runs[0].told.startswith("diverged after")
    assert page.index(told) < page.index("<h2>") and told in text


def test_the_terminal_shows_errors_indices_and_what_is_left_out(found):
    text = media.terminal(page_of(found))
    assert text.startswith("Validation of mariner, other, response-1: ") and "\n  on 2 records" in text
    score = found.score("yaw_rate_rad_s", "other")
    line = next(line for line in text.splitlines() if line.startswith("  yaw rate"))
    assert number(np.rad2deg(score.rmse)) in line
    assert (
        "tactical diameter" in text and "the model has no such state" in text and max(map(len, text.splitlines())) < 260
    )
