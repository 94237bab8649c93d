"""Diagnosis from Python: what is asked of the engine, and the outcome's page, figure and files."""

from dataclasses import replace

import pytest

import helmbench
from helmbench.diagnosis import diagnose as engine

from ...made_up.diagnosis import made_up


@pytest.fixture(scope="module")
def found():
    return made_up("response-1", "rudder_offset", {"rudder_offset": 0.02})


@pytest.fixture(scope="module")
def record():
    return helmbench.simulate("response-1", "zigzag:20/20", noise="low")


@pytest.fixture
def asked(found, monkeypatch):
    """What was asked of the engine, which answers with the diagnosis made by hand."""
    calls = []

    def answer(model, train, held_out, options, watch):
        watch("causes of today")
        calls.append((model, train, held_out, options))
        roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
        return replace(made_up("response-1", "rudder_offset"), records=tuple(roles))

    monkeypatch.setattr(engine, "diagnose", answer)
    return calls


def test_records_and_files_are_taken(record, asked, tmp_path):
    path = tmp_path / "other.csv"
    helmbench.write_record(record.slice(record.n // 2, None), path)
    first, ask = record.slice(0, record.n // 2), {"channels": ["heading", "yaw_rate_rad_s"], "causes": ["wind"]}
    found = helmbench.diagnose("response-1", first, [path], **ask)
    ((model, train, held_out, options),) = asked
    assert (model.id, train[0].n, [r.name for r in held_out]) == ("response-1", first.n, ["other"])
    assert options.channels == ("heading_rad", "yaw_rate_rad_s") and options.only == ("wind",)
    assert isinstance(found, helmbench.Diagnosis)
    assert found.records == ((record.name, "train"), (str(path), "held_out"))


@pytest.mark.parametrize("shown", [True, False])
def test_the_stage_is_shown_on_standard_error(record, asked, capsys, shown):
    helmbench.diagnose("response-1", record, progress=shown)
    out, err = capsys.readouterr()
    assert out == "" and ("diagnosis: causes of today" in err) is shown


def test_bad_input_is_found_before_anything_is_computed(record, asked, tmp_path):
    with pytest.raises(helmbench.BadInput, match="both a training record and held out"):
        helmbench.diagnose("response-1", record, [replace(record, name="copy")])
    with pytest.raises(helmbench.BadInput, match="holds the same samples"):
        helmbench.diagnose("response-1", [record, replace(record, name="copy")])
    with pytest.raises(helmbench.BadInput, match="unknown channel 'draught'"):
        helmbench.diagnose("response-1", record, channels=["draught"])
    with pytest.raises(helmbench.BadInput, match="unknown cause"):
        helmbench.diagnose("response-1", record, causes=["gremlins"])
    assert asked == []


def test_the_outcome_shows_itself(found):
    assert repr(found) == "<Diagnosis of response-1: named rudder_offset>"
    assert found.summary().splitlines()[0].partition(": ")[2][:60] in found._repr_html_()
    assert found.to_html().lower().startswith("<!doctype html>")


def test_the_figure_has_a_panel_a_channel_and_a_line_a_run(found):
    figure = found.plot()
    trace = next(trace for trace in found.traces if trace.role == "held_out")
    assert trace.record in figure.get_suptitle() and len(figure.axes) == len(trace.measured)
    assert [len(panel.lines) for panel in figure.axes] == [3] * len(figure.axes)
    adequate = made_up("response-1", "rudder_offset", verdict="adequate")
    assert [len(panel.lines) for panel in adequate.plot("run_0").axes] == [2] * len(figure.axes)
    with pytest.raises(helmbench.BadInput, match="no such record"):
        found.plot("nothing")


def test_files_are_written_all_or_none(found, tmp_path, monkeypatch):
    paths = found.write(tmp_path / "out")
    assert [path.name for path in paths] == list(found.files)
    assert helmbench.resolve(paths[2]).parameters["rudder_offset"] == 0.02

    def fails(*_):
        raise OSError(28, "no space left on device")

    monkeypatch.setattr("helmbench.models.model.model_to_json", fails)
    with pytest.raises(helmbench.BadInput, match="no space left"):
        found.write(tmp_path / "other")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
