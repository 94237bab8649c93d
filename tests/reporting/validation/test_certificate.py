"""The certificate: one page whose ranges and errors are those of the records and of the validation."""

import math
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from weasyprint import HTML

from helmbench import validate
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import write_record
from helmbench.estimation.validation.result import FREE
from helmbench.models.model import resolve
from helmbench.reporting.numbers import number
from helmbench.reporting.validation.certificate import digest, limits, reach_of

from ...support.page_tables import page_tables


@pytest.fixture(scope="module")
def record():
    return generate(Case("mariner", "zigzag:20/20", "none", seed=1))


@pytest.fixture(scope="module")
def found(record):
    model = resolve("mariner")
    other = replace(model.with_coefficients(1.1 * model.coefficients), id="other")
    return validate(other, record, [model])


def test_it_tells_what_the_record_holds_and_the_errors_of_the_first_model(found, record):
    page = found.certificate()
    tried, free, ahead, *_ = page_tables(page)
    reach = reach_of(found.records[0])
    assert reach["rudder"] == pytest.approx((record.rudder().min(), record.rudder().max()))
    surge, sway = record.channels["surge_m_s"], record.channels["sway_m_s"]
    assert reach["drift"] == pytest.approx((np.arctan(-sway / surge).min(), np.arctan(-sway / surge).max()))
    assert f"{number(math.degrees(reach['yaw_rate'][0]))} to {number(math.degrees(reach['yaw_rate'][1]))}" in tried[1]
    score = found.score("yaw_rate_rad_s", "other", horizon=FREE)
    (row,) = (row for row in free if row[0] == "yaw rate")
    assert number(math.degrees(score.rmse)) in row
    assert "mariner" not in {cell for row in ahead for cell in row}
    (told,) = re.findall(r"other: ([^.]*trust it for|at no time)", page)
    assert told == "trust it for" and digest(resolve("mariner")) not in page


def test_the_digest_is_that_of_equations_and_numbers():
    model = resolve("mariner")
    assert digest(model) == digest(replace(model, id="renamed", title="x")) != digest(resolve("s175"))
    assert digest(model) != digest(model.with_coefficients(np.nextafter(model.coefficients, 1.0)))


def test_channels_that_were_not_measured_are_limits(record):
    blind = replace(record, channels={k: v for k, v in record.channels.items() if k in ("rudder_rad", "heading_rad")})
    lines = limits(validate("response-1", blind.between(0.0, 200.0)))
    assert "surge speed: not measured" in lines and "drift angle: not measured" in lines


def test_the_command_writes_it_beside_the_rest(record, tmp_path, capsys):
    write_record(record, tmp_path / "run.csv")
    page = tmp_path / "certificate.html"
    command = ["validate", "mariner", str(tmp_path / "run.csv"), "--certificate", str(page)]
    assert status_of(command) == 0 and "Adequacy of the model mariner" in page.read_text(encoding="utf-8")
    assert status_of(command) == 2 and "exists already" in capsys.readouterr().err


def test_as_a_pdf_it_is_one_sheet(record, tmp_path):
    """Six channels and two records with zigzags: the most that the tables usually hold."""
    write_record(record, tmp_path / "one.csv")
    write_record(generate(Case("mariner", "zigzag:10/10", "low", seed=2)), tmp_path / "two.csv")
    page = tmp_path / "certificate.pdf"
    command = ["validate", "mariner", str(tmp_path / "one.csv"), str(tmp_path / "two.csv"), "--certificate", str(page)]
    assert status_of(command) == 0
    found = validate("mariner", [tmp_path / "one.csv", tmp_path / "two.csv"])
    assert page.read_bytes().startswith(b"%PDF-") and len(HTML(string=found.certificate()).render().pages) == 1


def test_without_weasyprint_a_pdf_is_refused_in_one_line(record, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    write_record(record, tmp_path / "run.csv")
    page = tmp_path / "certificate.pdf"
    assert status_of(["validate", "mariner", str(tmp_path / "run.csv"), "--certificate", str(page)]) == 2
    assert "pip install 'helmbench[pdf]'" in capsys.readouterr().err and not page.exists()
