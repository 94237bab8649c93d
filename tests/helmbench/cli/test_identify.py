"""`helmbench identify`: what it prints for people and for machines."""

import json

import pytest

import helmbench
from helmbench.cli import status_of


@pytest.fixture
def call(tmp_path, capsys):
    """Identify the made-up records; returns what was printed."""
    for name, manoeuvre in (("train", "zigzag:20/20"), ("other", "zigzag:10/10:port")):
        helmbench.write_record(helmbench.simulate("response-1", manoeuvre, noise="low"), tmp_path / f"{name}.csv")

    def run(method, *more, model="response-1"):
        arguments = [
            "identify",
            tmp_path / "train.csv",
            "--model",
            model,
            "--method",
            method,
            "-o",
            tmp_path / "m.json",
            "--force",
        ]
        status = status_of([str(a).format(tmp_path) for a in (*arguments, *more)])
        return status, *capsys.readouterr()

    return run


def test_json_holds_parameters_and_validation(call):
    told = json.loads(call("output-error", "--validate", "{}/other.csv", "--json")[1])
    assert (told["train"], told["validation"]["records"], told["warnings"]) == (["train"], ["other"], [])
    assert told["validation"]["r2_free_heading_rad"] > 0.999 and not told["validation"]["diverged"]
    first = told["parameters"][0]
    assert (first["parameter"], first["unit"]) == ("T", "s") and first["stderr"] > 0
    truth = helmbench.resolve("response-1").parameters
    assert {p["parameter"]: p["estimate"] for p in told["parameters"]} == pytest.approx(truth, rel=0.02)


def test_identifiability_is_printed_on_request(call):
    assert "determined within 10 % (3)" not in call("output-error")[1]
    assert "determined within 10 % (3)" in call("output-error", "--identifiability")[1]
    told = json.loads(call("output-error,fixed=K,profile=T", "--json")[1])
    assert told["identifiability"]["counts"] == {"within_10_percent": 3, "within_50_percent": 0, "not_determined": 0}
    interval, values = told["profile"]["T"], {p["parameter"]: p["estimate"] for p in told["parameters"]}
    assert told["identifiability"]["candidates"]
    assert interval["low"] < values["T"] < interval["high"]
    assert values["K"] == pytest.approx(helmbench.resolve("response-1").parameters["K"], rel=1e-12)


def test_intervals_and_fixed_parameters_are_printed(call):
    status, out, _ = call("output-error,fixed=K,profile=T")
    lines = {line.split()[0]: line for line in out.splitlines() if line.startswith("  ")}
    assert status == 0 and "fixed" in lines["K"] and "[" in lines["T"] and "+-" in lines["alpha"]


@pytest.mark.nightly
def test_a_black_box_has_no_model_file(call, tmp_path):
    status, _, err = call("sklearn:Ridge", "--identifiability", model="nomoto-1")
    assert status == 0 and "a black box has no coefficients" in err and not (tmp_path / "m.json").exists()


def test_a_record_that_lacks_a_channel_is_bad_input(call):
    status, out, err = call("ls", model="mariner")
    assert (status, out) == (2, "") and "method ls cannot fit mariner: " in err and "surge_m_s" in err


def test_a_validation_record_that_is_a_training_record_is_refused(call):
    status, _, said = call("ls", "--validate", "{}/train.csv")
    assert status == 2 and "is both a training record and held out" in said and len(said.splitlines()) == 1


def test_the_verdict_is_printed_first(call):
    good, poor = (call("output-error", "--validate", "{}/other.csv", model=m)[1] for m in ("response-1", "nomoto-1"))
    assert good.splitlines()[0].endswith("from train: The model explains the records.")
    assert "approximates the records" in poor.splitlines()[0] and "exceed the sensors' noise: yaw rate" in poor


def test_without_a_held_out_record_it_says_so(call):
    assert "No record was held out" in call("output-error")[1]


def test_a_page_beside_the_model(call, tmp_path):
    status, out, err = call("ls", "--page", "{}/page.html")
    assert status == 0 and (tmp_path / "m.json").exists()
    assert f"wrote {tmp_path / 'page.html'}" in err and "wrote" not in out
    assert "<h2>What remains</h2>" in (tmp_path / "page.html").read_text(encoding="utf-8")
    assert call("ls", "--page", "{}/no/such/page.html")[0] == 2


def test_a_folder_holds_page_figures_and_model(call, tmp_path):
    status, out, _ = call("ls", "--validate", "{}/other.csv", "-o", "{}/out", "--json")
    assert status == 0 and not (tmp_path / "m.json").exists()
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "identification.html", "identification.json", "model.json"
    }  # fmt: skip
    stored = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))
    assert json.loads(out) == stored | {"output": str(tmp_path / "out")}


def test_methods_side_by_side(call):
    told = json.loads(call("ls", "--compare", "rls", "sklearn:Ridge", "--validate", "{}/other.csv", "--json")[1])
    rows = told["comparison"]["candidates"]
    assert [row["method"] for row in rows] == ["ls", "rls", "sklearn:Ridge"] and told["method"] == "ls"
    assert all(row["wall_s"] > 0.0 for row in rows) and told["comparison"]["tested_on"] == ["other"]
    out = call("ls", "--compare", "rls", "--validate", "{}/other.csv")[1]
    line = next(line for line in out.splitlines() if line.startswith("  rls "))
    assert f"T {rows[1]['parameters']['T']:.3g}" in line


def test_auto_chooses_the_structure_of_the_ship(call):
    status, out, _ = call("output-error", "--validate", "{}/other.csv", model="auto")
    assert status == 0 and out.startswith("nomoto-1-cubic by output-error from train: ")
    assert "nomoto-2-quadratic-speed" in out and "no column surge_m_s" in out and "chosen" in out


def test_method_and_folder_have_defaults(call, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    call("ls")
    assert status_of(["identify", "train.csv", "--model", "response-1"]) == 0
    assert "by output-error" in capsys.readouterr().out
    assert {path.name for path in (tmp_path / "identify-results").iterdir()} >= {"identification.html", "model.json"}
    assert status_of(["identify", "train.csv", "--model", "response-1"]) == 2
    assert "exists already; give another place, or --force" in capsys.readouterr().err
