"""`helmbench validate`: arguments, output, files, exit status."""

import json

import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.plausibility import PlausibilityWarning


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    for seed, (name, text) in enumerate((("one", "zigzag:20/20"), ("two", "zigzag:10/10"))):
        record = helmbench.simulate("response-1", text, noise="low", seed=seed)
        helmbench.write_record(record, folder / f"{name}.csv")
    return folder


def test_it_prints_errors_and_writes_two_files(files, tmp_path, capsys):
    records = [str(files / f"{name}.csv") for name in ("one", "two")]
    compare = ["--compare", "response-2", "mariner"]
    assert status_of(["validate", "response-1", *records, *compare, "-o", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    assert (
        out.startswith("Validation of response-1, response-2, mariner: ")
        and "\n  on 2 records" in out
        and "first overshoot" in out
    )
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["validation.html", "validation.json"]
    assert err.count("wrote") == 2


def test_json_is_the_file_and_what_python_gives(files, tmp_path, capsys):
    record = files / "one.csv"
    assert status_of(["validate", "response-1", str(record), "--json", "-o", str(tmp_path / "out")]) == 0
    out = capsys.readouterr().out
    assert json.loads(out) == json.loads((tmp_path / "out" / "validation.json").read_text(encoding="utf-8"))
    expected = helmbench.validate("response-1", record).score("heading_rad").rmse
    scores = json.loads(out)["scores"]
    assert next(s["rmse"] for s in scores if s["channel"] == "heading_rad") == expected
    assert status_of(["validate", "response-1", str(record), "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_a_dead_channel_is_told_and_not_scored(files, tmp_path, capsys):
    record = helmbench.read_record(files / "one.csv")
    helmbench.write_record(record.with_channels(yaw_rate_rad_s=np.zeros(record.n)), tmp_path / "dead.csv")
    (tmp_path / "dead.yaml").unlink()  # it says that the channel is constant on purpose
    assert status_of(["validate", "response-1", str(tmp_path / "dead.csv"), "--json", "-o", str(tmp_path / "out")]) == 0
    result = json.loads(capsys.readouterr().out)
    scored = {s["channel"] for s in result["scores"]}
    assert "heading_rad" in scored and "yaw_rate_rad_s" not in scored
    said = "yaw_rate_rad_s is 0 rad/s in every row, and is left out"
    assert result["doubts"] == [f"dead: {said}"]
    with pytest.warns(PlausibilityWarning, match=said):
        helmbench.identify(tmp_path / "dead.csv", "nomoto-1", "ls")
    assert status_of(["check", str(tmp_path / "dead.csv")]) == 1
    assert said.partition(",")[0] in capsys.readouterr().out


def test_a_divergence_is_a_result(files, tmp_path, capsys):
    model = helmbench.resolve("response-1")
    from helmbench.models.model import model_to_json

    model_to_json(model.with_coefficients([0.5, model.coefficients[1], 0.0]), tmp_path / "wild.json")
    assert status_of(["validate", str(tmp_path / "wild.json"), str(files / "one.csv")]) == 0
    assert "wild along one: diverged after" in capsys.readouterr().out


BAD = {
    "family": (["nomoto-1", "{}/one.csv"], "model nomoto-1 has no coefficients"),
    "no such record": (["response-1", "{}/three.csv"], "three.csv"),
    "no such model": (["respons", "{}/one.csv"], "unknown model"),
    "compared": (["response-1", "{}/one.csv", "--compare", "nobody"], "unknown model 'nobody'"),
    "no record": (["response-1"], "Missing argument"),
    "folder": (["response-1", "{}/one.csv", "-o", "{}/one.csv"], "is a file"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, files, capsys):
    arguments, told = BAD[case]
    before = sorted(files.iterdir())
    assert status_of(["validate", *[a.format(files) for a in arguments]]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and told in err
    assert sorted(files.iterdir()) == before
