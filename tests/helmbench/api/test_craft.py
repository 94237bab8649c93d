"""A model built from records: outcome, files, and the commands that need neither model nor method."""

import json
from html import unescape

import pytest

import helmbench
from helmbench import Case, generate
from helmbench.cli import status_of
from helmbench.diagnosis.craft.result import BUILT, SHIP


@pytest.fixture
def records(craft):
    return [*craft[0], craft[1]]


def test_the_outcome_shows_itself_and_its_model_is_read_back(craft, tmp_path):
    _, last, found = craft
    for step in found.steps:
        assert step.title in found.summary() and step.title in unescape(found.to_html())
    assert "<b>" in found._repr_html_() and found.verdict in repr(found)
    assert found.plot().axes
    paths = found.write(tmp_path / "out")
    document = json.loads(paths[0].read_text(encoding="utf-8"))
    assert document["verdict"] == found.verdict and len(document["laws"]) == len(found.laws)
    again = helmbench.resolve(paths[2])
    told = helmbench.validate(again, last)
    for channel in ("yaw_rate_rad_s", "heading_rad"):
        assert told.score(channel).rmse == pytest.approx(found.ahead.score(channel).rmse, rel=1e-6)
    with pytest.raises(helmbench.BadInput, match="no such record"):
        found.plot("other")


@pytest.mark.nightly
def test_a_simulation_of_particulars_stands_beside_the_built_model(tmp_path):
    runs = [generate(Case("kvlcc2-l7", f"zigzag:{text}", "low", seed=3)) for text in ("20/20", "10/10", "20/10")]
    found = helmbench.build_model(runs[:2], runs[2], particulars="kvlcc2-l7")
    assert found.ahead.score("heading_rad", SHIP).rmse < found.ahead.score("heading_rad", BUILT).rmse
    assert "particulars has errors" in found.summary()
    paths = found.write(tmp_path / "out")
    assert helmbench.resolve(paths[-1]).is_3dof and paths[-1].name == "particulars_model.json"
    assert helmbench.identify(runs[:2], "auto", validate=runs[2], particulars="kvlcc2-l7").method == "particulars"
    with pytest.raises(helmbench.BadInput, match="simulation of surge, sway and yaw"):
        helmbench.build_model(runs[:2], particulars="nomoto-1")
    with pytest.raises(helmbench.BadInput, match="particulars beside a model"):
        helmbench.identify(runs[0], "nomoto-1", "ls", particulars="kvlcc2-l7")


@pytest.mark.nightly
def test_commands_need_no_model_and_no_method(records, tmp_path, capsys):
    files = []
    for record in records:
        files.append(str(tmp_path / f"{record.name.replace(' ', '-')}.csv"))
        helmbench.write_record(record, files[-1])
    out = tmp_path / "out"
    assert status_of(["diagnose", "--train", *files[:2], "--held-out", files[2], "-o", str(out)]) == 0
    assert "What steers it" in capsys.readouterr().out
    assert {path.name for path in out.iterdir()} >= {"diagnosis.json", "diagnosis.html", "extended_model.json"}
    model = tmp_path / "model.json"
    assert status_of(["identify", *files[:2], "--model", "auto", "--validate", files[2], "-o", str(model)]) == 0
    assert "by ladder" in capsys.readouterr().out and helmbench.resolve(model).known
