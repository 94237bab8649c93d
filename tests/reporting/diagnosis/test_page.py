"""The page of a diagnosis and its Markdown form, on a diagnosis made by hand."""

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from helmbench.diagnosis.result import Curve, RemainingForce
from helmbench.reporting import media
from helmbench.reporting.diagnosis import words
from helmbench.reporting.diagnosis.page import page as page_of
from helmbench.reporting.diagnosis.tables import bank_table, error_table, gain_table, residual
from helmbench.reporting.numbers import DEG, number
from helmbench.reporting.open.views import view_of
from helmbench.reporting.runs import rms

from ...made_up.diagnosis import made_up
from ...support.page_tables import page_tables


@pytest.fixture(scope="module")
def found():
    return made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, {"yaw_rate_bias": 0.002})


@pytest.fixture(scope="module")
def page(found):
    return media.html(page_of(found))


def test_the_page_has_the_order_of_a_readers_questions(page, found):
    heads = re.findall(r"<h2>(.*?)</h2>", page)
    assert heads == ["Measured and simulated", "What changed", "More"]
    tied = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, verdict="tied")
    heads = re.findall(r"<h2>(.*?)</h2>", media.html(page_of(tied)))
    assert heads == ["Measured and simulated", "What changed", "What to sail next", "More"]
    assert page.index(words.verdict(found).split(".")[0]) < page.index("<h2>")


def test_the_first_figure_has_the_held_out_records_before_and_after(page):
    first = page[page.index("<h2>Measured and simulated") : page.index("<h3>")]
    assert re.findall(r"<figcaption>(.*?)</figcaption>", first) == ["run_2", "run_3"] and first.count("<svg") == 2
    assert "base model" in first and "extended model" in first
    for colour in ("#1d2733", "#c8553d", "#1b6ca8"):
        assert f"stroke: {colour}" in first


def test_what_was_tested_is_folded(page):
    opened = re.sub(r"<details.*</details>", "", page, flags=re.DOTALL)
    assert "explained by" in page and "explained by" not in opened and "<table" in opened


def test_the_page_needs_no_other_file(page):
    links = re.findall(r"""(?:src|href)\s*=\s*["']?([^"' >]+)|url\(([^)]*)\)|(@import)""", page)
    assert all((a or b or c).startswith("#") for a, b, c in links)


def test_charts_and_formulas_are_well_formed(page):
    charts = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(charts) >= 5 and not any("nan" in path for path in re.findall(r' d="([^"]*)"', page))
    for svg in charts:
        ElementTree.fromstring(svg)
    for math in re.findall(r"<math.*?</math>", page, re.DOTALL):
        ElementTree.fromstring(math)


@pytest.mark.parametrize("verdict", ["adequate", "inconclusive", "unexplained", "tied"])
def test_every_verdict_has_its_page(verdict):
    other = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, verdict=verdict, held=0)
    page = media.html(page_of(other))
    assert "the gain was not measured" in page and words.verdict(other).split(":")[0][:40] in page
    assert ("The model stays as it is" in page) == (verdict != "tied")
    assert media.terminal(page_of(other)).startswith(f"Diagnosis of response-1: {verdict.capitalize()}")


def test_names_in_the_page_are_escaped(found):
    page = media.html(page_of(replace(found, reason="<script>alert(1)</script>", records=(("<b>.csv", "train"),))))
    assert "<script>alert" not in page and "&lt;b&gt;.csv" in page


def test_the_gain_on_the_page_is_that_of_the_diagnosis(found, page):
    table = gain_table(found)
    for row, (name, gain) in zip(table.rows, found.gain.items(), strict=True):
        _, unit, factor = words.channel(name)
        assert row[1].text == f"{number(factor * gain.rmse_before)} {unit}".rstrip()
        assert row[2].text == f"{number(factor * gain.rmse_after)} {unit}".rstrip()
        assert (row[4].value, row[5].value) == (gain.r2_before, gain.r2_after)
        assert all(cell.text in page for cell in row)


def test_every_cause_stands_in_a_table(found, page):
    table = bank_table(found)
    tested = [entry for entry in words.ordered_bank(found) if entry.status != "not_testable"]
    assert [row[0].text for row in table.rows] == [words.cause(entry.cause) for entry in tested]
    assert table.kinds == tuple(entry.status for entry in tested)
    cells = page_tables(page)
    assert {row[0] for rows in cells for row in rows} >= {words.cause(entry.cause) for entry in found.bank}


def test_a_significant_cause_that_is_not_named_is_not_called_insignificant(found):
    entries = [replace(entry, status="not_significant") for entry in found.bank if entry.p_adjusted is not None]
    rows = {row[0].text: row[1].text for row in bank_table(replace(found, bank=tuple(entries))).rows}
    assert set(rows.values()) == {"not named", "not significant"}
    for entry in entries:
        told = "not named" if entry.p_adjusted < found.alpha else "not significant"
        assert rows[words.cause(entry.cause)] == told


def test_errors_are_those_of_the_records(found):
    rows = error_table(found).rows
    trace = found.traces[0]
    expected = DEG * rms(residual(trace, "yaw_rate_rad_s", "before"))
    first = next(row for row in rows if [cell.text for cell in row[2:4]] == ["yaw rate", "before"])
    assert first[0].text == trace.record and first[4].text == f"{number(expected)} deg/s"


def test_markdown_carries_statistics_and_no_series(found, tmp_path):
    paths = media.write_markdown(page_of(found), tmp_path, "made-up", "Made up")
    assert [path.name for path in paths] == ["made-up.md", "made-up-errors.svg"]
    text, drawn = (path.read_text() for path in paths)
    assert "| RMSE before" in text and "$$" in text and "![" in text and len(text) < 20_000
    shortest = min(trace.time.size for trace in found.traces)
    assert max(len(re.findall(r"[ML]", d)) for d in re.findall(r' d="([^"]*)"', drawn)) < shortest / 5
    assert all(f">{trace.record} ({trace.role.replace('_', ' ')})</text>" in drawn for trace in found.traces)


def test_the_curve_of_a_force_that_remains_is_published(found, tmp_path):
    curve = Curve("drift", "rad", "N", (0.0, 0.1, 0.2), (0.0, 1.0, 3.0), (-1.0, 0.0, 2.0), (1.0, 2.0, 4.0))
    said = ("a yaw moment that grows with the drift", None, {}, (), False, "a hull of another form", "turns")
    force = RemainingForce("N", ("drift",), *said, curve=curve)
    paths = media.write_markdown(page_of(replace(found, remaining=(force,))), tmp_path, "made-up", "Made up")
    (drawn,) = (path for path in paths if path.name == "made-up-remaining-1.svg")
    assert "![The force with its 90 % band" in paths[0].read_text()
    ElementTree.parse(drawn)


def test_markdown_removes_figures_of_an_earlier_diagnosis(found, tmp_path):
    (tmp_path / "made-up-old.svg").write_text("<svg/>")
    media.write_markdown(page_of(found), tmp_path, "made-up", "Made up")
    assert not (tmp_path / "made-up-old.svg").exists()


def test_a_diverged_run_does_not_hide_the_measured_one(found):
    trace = found.traces[-1]
    wild = np.exp(0.2 * trace.time)
    wild[-10:] = np.inf
    wilder = replace(trace, before={**trace.before, "yaw_rate_rad_s": wild})
    page = media.html(page_of(replace(found, traces=(wilder,))))
    ticks = [float(t.replace("−", "-")) for t in re.findall(r">([−\d.]+)</text>", page)]
    assert ticks and max(map(abs, ticks)) < 1e5


@pytest.mark.parametrize("values", [np.inf, np.nan, 1e300, 0.0])
@pytest.mark.parametrize("side", ["measured", "before"])
def test_channels_of_any_numbers_have_a_page(found, side, values, tmp_path):
    """Warnings are errors here."""
    trace = found.traces[-1]
    wild = {name: np.where(trace.time > 300.0, values, own) for name, own in getattr(trace, side).items()}
    page = page_of(replace(found, traces=(replace(trace, **{side: wild}),)))
    assert trace.record in media.html(page) and media.write_markdown(page, tmp_path, "wild", "Wild")
    assert view_of(page)["traces"][0]["record"] == trace.record
