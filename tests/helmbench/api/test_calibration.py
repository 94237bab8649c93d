"""Calibration from Python and by the command: page, figure and files show what was found."""

import json

import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of


@pytest.fixture
def found(calibrated):
    return calibrated[2]


def test_it_shows_itself(found):
    groups = [step.group for step in found.steps]
    assert groups and repr(found) == f"<Calibration of kvlcc2-l7: {found.verdict} {', '.join(groups)}>"
    page, told = found.to_html(), found.summary()
    for number in found.moved:
        assert number.name in page and number.name in told
    first = told.splitlines()[0]
    assert all(number.name in first for number in found.moved) and "held-out error of the heading from" in first
    cell = found._repr_html_()
    assert "<table" in cell and "<img" in cell


def test_the_figure_has_the_channels_of_the_held_out_run(found):
    figure = found.plot()
    assert [len(axes.lines) for axes in figure.axes] == [3] * len(found.traces[-1].measured)
    with pytest.raises(helmbench.BadInput, match="calibration has no such record"):
        found.plot("elsewhere")


@pytest.mark.nightly
def test_the_command_writes_what_python_finds(found, calibrated, tmp_path, capsys):
    records = [*calibrated[0], calibrated[1]]
    paths = [tmp_path / f"{i}.csv" for i in range(len(records))]
    for path, record in zip(paths, records, strict=True):
        helmbench.write_record(record, path)
    train = [str(path) for path in paths[:-1]]
    words = ["calibrate", "--model", "kvlcc2-l7", "--train", *train, "--held-out", str(paths[-1])]
    assert status_of([*words, "-o", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.startswith(
        f"Calibration of kvlcc2-l7: {found.verdict.replace('_', ' ').capitalize()}. "
    )
    document = json.loads((tmp_path / "out" / "calibration.json").read_text())
    assert [m["after"] for m in document["moved"]] == pytest.approx([m.after for m in found.moved])
    for name, model in (("extended", found.extended), ("calibrated", found.calibrated)):
        written = helmbench.resolve(tmp_path / "out" / f"{name}_model.json")
        assert np.array_equal(written.theta, model.theta)
    assert (found.extended.id == found.calibrated.id) == (found.extended is found.calibrated)
    assert (tmp_path / "out" / "calibration.html").stat().st_size > 10_000


def test_a_record_on_both_sides_is_refused(calibrated):
    with pytest.raises(helmbench.BadInput):
        helmbench.calibrate("kvlcc2-l7", calibrated[0], calibrated[0][-1])
