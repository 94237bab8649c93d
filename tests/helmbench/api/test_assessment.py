"""Assessments and comparisons from Python: what is taken, and their tables, figures, pages and files."""

import json
import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import helmbench
from helmbench.api.identification import _better_ahead

from ...simulators.response import GAIN, heading_only, steps, turned


@pytest.fixture(scope="module")
def records():
    return [helmbench.simulate("response-1", text, noise="low", seed=k)
            for k, text in enumerate(("zigzag:20/20", "zigzag:10/10:port"))]  # fmt: skip


@pytest.fixture(scope="module")
def found(records):
    return helmbench.identify(records[0], "nomoto-1-cubic", "ls").assess(records[1])


def test_an_assessment_shows_itself(found, records):
    assert repr(found) == f"<Assessment of nomoto-1-cubic by ls: {found.verdict}>"
    cell = found._repr_html_()
    assert found.statement()[0] in cell and "<table>" in cell
    assert found.statement()[0] in found.summary() and found.statement() == found.to_json()["statement"]
    frame = found.to_dataframe()
    assert list(frame.columns) == ["unit", "value", "stderr", "low", "high", "bound"] and "T" in frame.index
    titles = [found.plot(name).get_suptitle() for name in (None, records[1].name, records[0].name)]
    assert titles == [f"free runs along {records[i].name}" for i in (1, 1, 0)]
    with pytest.raises(helmbench.BadInput, match="no such record"):
        found.plot("another")


def test_its_files_are_written_together(found, tmp_path):
    paths = found.write(tmp_path / "out")
    assert [path.name for path in paths] == list(found.files)
    assert json.loads(paths[0].read_text(encoding="utf-8"))["verdict"] == found.verdict
    assert paths[1].read_text(encoding="utf-8") == found.to_html()
    assert helmbench.resolve(paths[2]).parameters == pytest.approx(found.estimate.parameters, rel=1e-12)
    (tmp_path / "taken" / "model.json").mkdir(parents=True)
    with pytest.raises(helmbench.BadInput, match="cannot be written"):
        found.write(tmp_path / "taken")
    assert [path.name for path in (tmp_path / "taken").iterdir()] == ["model.json"]


def test_an_estimate_needs_its_records(found, records, tmp_path):
    path = tmp_path / "other.csv"
    helmbench.write_record(records[1], path)
    estimate = helmbench.identify(records[0], "nomoto-1-cubic", "ls")
    told = estimate.assess(path).to_json()["validation"]
    expected = found.to_json()["validation"]
    assert told["r2_free_together"] == pytest.approx(expected["r2_free_together"], rel=1e-6)
    assert "<h2>Measured and simulated</h2>" in estimate.to_html()
    with pytest.raises(helmbench.BadInput, match="held out"):
        estimate.assess(records[0])
    bare = replace(estimate, records=())
    with pytest.raises(helmbench.BadInput, match="does not hold its records"):
        bare.assess()


def test_a_comparison_shows_itself(records):
    found = helmbench.compare(records[0], ["nomoto-1", "nomoto-1-cubic"], "ls", validate=records[1])
    assert repr(found) == "<Comparison of 2, held out: nomoto-1-cubic by ls>"
    frame = found.to_dataframe()
    assert list(frame["model"]) == ["nomoto-1", "nomoto-1-cubic"] and list(frame["chosen"]) == [False, True]
    assert frame["error"].iloc[1] == found.chosen.error and frame["r2_free_heading_rad"].iloc[1] > 0.99
    assert "<table>" in found._repr_html_() and "nomoto-1-cubic" in found.summary()
    assert [label.get_text() for label in found.plot().axes[0].get_yticklabels()] == [
        "nomoto-1 by ls", "nomoto-1-cubic by ls"
    ]  # fmt: skip


def test_auto_keeps_its_table(records):
    estimate = helmbench.identify(records[0], "auto", "ls", validate=records[1])
    assert estimate.comparison is not None and estimate.comparison.chosen.estimate.parameters == estimate.parameters
    assert {"nomoto-1", "kt"} <= {one.model.id for one in estimate.comparison.candidates}
    assert "Compared with others" in estimate.to_html(records[1])


def test_what_cannot_be_compared_is_said(records):
    with pytest.raises(helmbench.BadInput, match="no model"):
        helmbench.compare(records, [], "ls")
    with pytest.raises(helmbench.BadInput, match="no record"):
        helmbench.compare([], "nomoto-1", "ls")
    with pytest.raises(helmbench.CannotFit, match="surge_m_s"):
        helmbench.compare(records, "kvlcc2-l7", "ls")


def test_doubtful_records_are_told(records):
    held = records[0].column("heading_rad").copy()
    held[40:140] = held[40]
    frozen = records[0].with_channels(heading_rad=held)
    with pytest.warns(helmbench.PlausibilityWarning, match="heading"):
        helmbench.compare(frozen, "nomoto-1-cubic", "ls", validate=records[1])


def test_held_out_records_of_identify_are_those_that_the_estimate_is_judged_by(records):
    estimate = helmbench.identify(records[0], "nomoto-1-cubic", "output-error", validate=records[1])
    found = estimate.assess()
    assert [record.name for record in estimate.held_out] == [records[1].name]
    assert found.to_json() == estimate.assess(records[1]).to_json()
    assert found.to_json() != helmbench.identify(records[0], "nomoto-1-cubic", "output-error").assess().to_json()
    with pytest.raises(helmbench.BadInput):
        helmbench.identify(records[0], "nomoto-1-cubic", "output-error", validate=records[0])


def test_a_neutral_rudder_angle_is_told_with_sizes_and_leaves_the_numbers():
    record = heading_only(turned(steps(3), np.deg2rad(2.0)))
    found = helmbench.identify(record, "nomoto-1", "output-error").assess()
    (line,) = (one for one in found.statement() if "neutral rudder angle" in one)
    told = (
        r"A neutral rudder angle of (\S+) deg \[\S+, \S+\] would take the free-run error of the heading from (\S+) to "
    )
    size, before, after, new = map(float, re.match(told + r"(\S+) deg, .*K from \S+ to (\S+)\. ", line).groups())
    assert size == pytest.approx(2.0, rel=0.1) and after < 0.3 * before and new == pytest.approx(GAIN, rel=0.03)
    assert found.to_json()["biases"]["sizes"][0]["parameter"] == "rudder_offset"
    assert abs(found.estimate.parameters["K"] - GAIN) > abs(new - GAIN)
    clean = helmbench.identify(heading_only(turned(steps(3))), "nomoto-1", "output-error").assess()
    assert clean.biases is None and clean.to_json()["biases"] is None


@pytest.mark.parametrize(("own", "other", "taken"), [(0.9, 0.8, True), (0.7, 0.8, False), (0.1, 0.2, True)])
def test_a_built_model_replaces_a_family_that_follows_the_records_only_if_it_does_no_worse(
    records, monkeypatch, own, other, taken
):
    """Ahead its errors are half those of the family; R^2 of the free runs, of which poor ones tell nothing."""
    family = helmbench.identify(records[0], "nomoto-1", "ls")
    module = import_module("helmbench.estimation.validation.validate")
    real = module.validate

    def validate(models, *rest):
        found = real(models, *rest)
        halved = (replace(s, rmse=s.rmse * (0.5 if s.model == "built" else 1.0)) for s in found.scores)
        free = {"built": own, "best": other}
        return replace(found, scores=tuple(replace(s, r2=free[s.model]) if s.horizon_s is None else s for s in halved))

    monkeypatch.setattr(module, "validate", validate)
    assert _better_ahead(replace(family, method="ladder"), family, [records[1]]) is taken
