"""`helmbench diagnose`: its command, files, page and words, on a diagnosis made by hand (no engine)."""

import json
from dataclasses import replace

import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import write_record
from helmbench.diagnosis import diagnose as engine
from helmbench.models.errors import FitFailed
from helmbench.models.extend import extended
from helmbench.models.model import model_to_json, resolve

from ...made_up.diagnosis import made_up


@pytest.fixture(scope="module")
def found():
    return made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}, {"yaw_rate_bias": 0.002})


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    for name, manoeuvre in (("train", "zigzag:20/20"), ("other", "zigzag:10/10:port")):
        write_record(generate(Case("response-1", manoeuvre, "low")), folder / f"{name}.csv")
    return folder


@pytest.fixture
def asked(found, monkeypatch):
    """What the command asked of the engine, which answers with the diagnosis made by hand."""
    calls = []

    def answer(model, train, held_out, options, _watch=None):
        calls.append((model, train, held_out, options))
        roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
        return replace(found, records=tuple(roles))

    monkeypatch.setattr(engine, "diagnose", answer)
    return calls


def test_the_command_parses_calls_and_writes_three_files(files, asked, tmp_path, capsys):
    arguments = ["diagnose", "--model", "response-1", "--train", files / "train.csv", "--held-out", files / "other.csv"]
    arguments += ["--channels", "heading,yaw_rate", "--alpha", "0.05", "--max-effects", "2", "--seed", "7"]
    arguments += ["--base-parameters", "file", "--coefficient-sd", "0.1", "-o", tmp_path / "out"]
    assert status_of([str(a) for a in arguments]) == 0
    out, err = capsys.readouterr()
    ((model, train, held_out, options),) = asked
    assert (model.id, [r.name for r in train], [r.name for r in held_out]) == ("response-1", ["train"], ["other"])
    assert options == engine.Options("file", 0.1, ("heading_rad", "yaw_rate_rad_s"), 2, 0.05, 7)
    assert out.startswith("Diagnosis of response-1: Named: rudder offset (1.15 deg); held-out heading error from ")
    assert "\n  The simulation lacks rudder offset (1.15 deg [1.03, 1.26])" in out
    assert "RMSE before" in out and "diagnosis.html" in err
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(helmbench.Diagnosis.files)
    document = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert document["schema"] == 3 and document["verdict"] == "named"
    assert document["records"] == [
        {"file": str(files / "train.csv"), "role": "train"}, {"file": str(files / "other.csv"), "role": "held_out"},
    ]  # fmt: skip
    model = resolve(tmp_path / "out" / "extended_model.json")
    assert model.parameters["rudder_offset"] == 0.02 and model.instruments == {"yaw_rate_bias": 0.002}


def test_json_and_quiet(files, asked, tmp_path, capsys):
    arguments = ["diagnose", "--model", "response-1", "--train", str(files / "train.csv"), "-o", str(tmp_path / "out")]
    assert status_of([*arguments, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["causes"][0]["cause"] == "rudder_offset"
    assert status_of([*arguments, "--quiet", "--force"]) == 0
    assert capsys.readouterr() == ("", "")


BAD = {
    "no such file": (["--model", "response-1", "--train", "{0}/none.csv"], "none.csv"),
    "both sides": (["--model", "response-1", "--train", "{0}/train.csv", "--held-out", "{0}/train.csv"], "held out"),
    "unknown model": (["--model", "nothing", "--train", "{0}/train.csv"], "nothing"),
    "unknown extension": (["--model", "nomoto-1+wings", "--train", "{0}/train.csv"], "wings"),
    "nothing known": (["--model", "nomoto-1", "--train", "{0}/train.csv", "--base-parameters", "file"], "coefficients"),
    "unknown channel": (["--model", "response-1", "--train", "{0}/train.csv", "--channels", "draught"], "draught"),
    "alpha": (["--model", "response-1", "--train", "{0}/train.csv", "--alpha", "2"], "alpha"),
    "no record": (["--model", "response-1"], "--train"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_writes_nothing(case, files, asked, tmp_path, capsys):
    arguments, told = BAD[case]
    assert status_of(["diagnose", *[a.format(files) for a in arguments], "-o", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1 and told in err
    assert list(tmp_path.iterdir()) == []


def test_a_model_that_cannot_be_run_is_one_line(files, monkeypatch, tmp_path, capsys):
    def fail(*_):
        raise FitFailed("its filter is not finite")

    monkeypatch.setattr(engine, "diagnose", fail)
    train = str(files / "train.csv")
    status = status_of(["diagnose", "--model", "response-1", "--train", train, "-o", str(tmp_path / "out")])
    assert status == 1 and not (tmp_path / "out").exists()
    assert capsys.readouterr().err == "helmbench: response-1 cannot be diagnosed: its filter is not finite\n"


def test_a_target_that_cannot_be_is_refused_before_anything_is_computed(files, asked, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    for target in (tmp_path / "taken", tmp_path / "none" / "out"):
        arguments = ["diagnose", "--model", "response-1", "--train", str(files / "train.csv"), "-o", str(target)]
        assert status_of(arguments) == 2 and capsys.readouterr().err.count("\n") == 1
    assert asked == []


def test_simulate_identify_and_diagnose_take_an_extended_model(tmp_path, capsys):
    """The chain with the engine: a record that an extended model wrote holds nothing that this model lacks."""
    truth = replace(
        extended(resolve("response-1"), "rudder_offset", {"rudder_offset": 0.02}),
        instruments={"yaw_rate_bias": 0.002, "rudder_delay": 1.0},
    )
    model_to_json(truth, tmp_path / "truth.json")

    def call(*arguments):
        assert status_of([str(a) for a in arguments]) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    for seed, manoeuvre in enumerate(("zigzag:20/20", "sine:20deg/90s", "zigzag:10/10")):
        out = ["-o", tmp_path / f"{seed}.csv", "--seed", seed, "--quiet"]
        duration = ["--duration", 300, "--dt", 0.5, "--noise", "low"]
        call("simulate", tmp_path / "truth.json", "--manoeuvre", manoeuvre, *duration, *out)
    records = [tmp_path / f"{seed}.csv" for seed in range(3)]
    given = ["--model", tmp_path / "truth.json", "--method", "output-error", "-o", tmp_path / "fit.json"]
    told = json.loads(call("identify", *records[:2], *given, "--validate", records[2], "--json"))
    fitted = {entry["parameter"]: entry["estimate"] for entry in told["parameters"]}
    assert fitted["rudder_offset"] == pytest.approx(0.02, rel=0.05)
    assert fitted["K"] == pytest.approx(truth.parameters["K"], rel=0.02)
    assert told["validation"]["r2_free_heading_rad"] > 0.999
    assert resolve(tmp_path / "fit.json").instruments == truth.instruments
    given = ["--train", *records[:2], "--held-out", records[2], "-o", tmp_path / "out", "--json"]
    told = json.loads(call("diagnose", "--model", tmp_path / "truth.json", *given))
    assert told["verdict"] == "adequate" and told["causes"] == []
    call(
        "simulate", tmp_path / "out" / "extended_model.json", "--manoeuvre", "zigzag:20/20", *duration, *out, "--force"
    )
