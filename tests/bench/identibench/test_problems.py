"""Problems of helmbench's suites as files, and as benchmarks that identibench runs any model on."""

import json
import sys
from pathlib import Path

import h5py
import identibench
import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.models.errors import BadInput

SUITE = """title: one ship, two methods
entries:
  - vessels: mariner
    methods: [ls, ridge]
    train: ["zigzag:20/20"]
    held_out: [["turn:20", "zigzag:10/10"]]
    noise: [none, low]
    duration_s: 200
    dt_s: 1
  - vessels: response-1
    methods: ls
    train: ["zigzag:20/20"]
    held_out: ["turn:20"]
    duration_s: 100
    dt_s: 0.5
"""


@pytest.fixture(scope="module")
def suite(tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("suite") / "mine.yaml"
    path.write_text(SUITE)
    return str(path)


@pytest.fixture(scope="module")
def folder(suite, tmp_path_factory) -> Path:
    place = tmp_path_factory.mktemp("problems") / "out"
    names = helmbench.export_problems(suite, place)
    assert names == ("1-mariner-abkowitz", "2-mariner-abkowitz", "3-response-1-nomoto-1-cubic")
    return place


def stay(context):
    """A model that keeps the last sample of the window."""
    assert len(list(context.get_train_sequences())) == len(list(context.get_train_valid_sequences())) == 1
    return lambda u, y_init, attrs: np.tile(y_init[-1], (len(u), 1))


def test_identibench_runs_a_trivial_model_on_every_problem(folder):
    specs = helmbench.identibench_specs(folder, init_window=5)
    results = identibench.run_benchmarks(specs, stay, continue_on_error=False)
    assert list(results["benchmark_name"]) == [spec.name for spec in specs]
    for spec, score in zip(specs, results["metric_score"], strict=True):
        errors = []
        for path in sorted((folder / spec.name / "test").iterdir()):
            with h5py.File(path) as file:
                y = np.column_stack([file[name][()] for name in spec.y_cols])
            errors.append(np.sqrt(np.mean((y[5:] - y[4]) ** 2, axis=0)))
        assert score == pytest.approx(np.mean(errors), rel=1e-4) and score > 0.0


def test_a_method_that_knows_the_equations_finds_them_there_and_back(folder):
    spec = helmbench.identibench_specs(folder)[0]
    found = identibench.run_benchmark(spec, helmbench.identibench_model("output-error", "mariner"), seed=1)
    idle = identibench.run_benchmark(spec, stay, seed=1)
    assert found["metric_score"] < 1e-3 * idle["metric_score"]


def test_the_files_hold_the_records(folder):
    sailed = helmbench.simulate("mariner", "turn:20", duration_s=200.0, dt_s=1.0)
    with h5py.File(folder / "1-mariner-abkowitz" / "test" / "test-1.hdf5") as file:
        assert file.attrs["fs"] == pytest.approx(1.0) and file.attrs["positive_rudder"] == sailed.meta.positive_rudder
        assert set(file) == {"time_s", *sailed.channels}
        assert all(file[name].attrs["unit"] for name in file)
        for name in sailed.channels:
            expected = sailed.continuous(name)
            assert np.array_equal(file[name][()], expected), name
        assert np.abs(file["heading_rad"][()]).max() > 1.0


def test_the_manifest_says_what_there_is(folder):
    content = json.loads((folder / "problems.json").read_text())
    exact, noisy, response = content["problems"]
    assert exact["outputs"] == ["heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s"]
    assert response["outputs"] == ["heading_rad", "yaw_rate_rad_s"] and "rudder_rad" in response["inputs"]
    assert (exact["noise"], noisy["noise"]) == ("none", "low") and noisy["seed"] == 0
    assert [one["dt_s"] for one in response["files"]["train"]] == pytest.approx([0.5])
    known = helmbench.resolve("response-1").parameters
    assert {name: one["value"] for name, one in response["truth"].items()} == pytest.approx(known)
    assert all(one["unit"] and one["kind"] == "given" for one in response["truth"].values())
    assert exact["truth"]["Yv"]["crb_sd"] is None and noisy["truth"]["Yv"]["crb_sd"] > 0.0
    readme = (folder / "README.md").read_text()
    assert "3 problems" in readme and all(f"`{name}`: {unit}" in readme for name, unit in content["units"].items())
    listed = [one["file"] for entry in content["problems"] for part in entry["files"].values() for one in part]
    assert sorted(listed) == sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*.hdf5"))


def test_vessels_and_seeds_are_chosen(suite, tmp_path):
    names = helmbench.export_problems(suite, tmp_path / "out", vessels=["mariner"], seeds=2)
    seeds = [entry["seed"] for entry in json.loads((tmp_path / "out" / "problems.json").read_text())["problems"]]
    assert len(names) == 3 and seeds == [0, 0, 1]


def test_what_cannot_be_exported_is_told(folder, tmp_path, suite):
    with pytest.raises(BadInput, match="identifies nothing"):
        helmbench.export_problems("diagnosis", tmp_path / "out")
    with pytest.raises(BadInput, match="not empty"):
        helmbench.export_problems(suite, folder)
    code = tmp_path / "code.yaml"
    code.write_text(SUITE.replace("[ls, ridge]", "[theirs.py:Theirs]"))
    with pytest.raises(BadInput, match="not trusted"):
        helmbench.export_problems(str(code), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_without_problems_and_a_wrong_manifest_are_told(folder, tmp_path):
    with pytest.raises(BadInput, match="holds no exported problems"):
        helmbench.identibench_specs(tmp_path)
    with pytest.raises(BadInput, match="init_window is -1"):
        helmbench.identibench_specs(folder, init_window=-1)
    content = json.loads((folder / "problems.json").read_text())
    content["problems"][0]["name"] = "../elsewhere"
    (tmp_path / "problems.json").write_text(json.dumps(content))
    with pytest.raises(BadInput, match=r"problems\.json"):
        helmbench.identibench_specs(tmp_path)


@pytest.mark.parametrize(("package", "extra"), [("h5py", "readers"), ("identibench", "identibench")])
def test_a_missing_package_is_told_with_its_extra(package, extra, folder, tmp_path, suite, monkeypatch):
    monkeypatch.delitem(sys.modules, "helmbench.bench.identibench.folder", raising=False)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(BadInput, match=rf"needs {package}: pip install 'helmbench\[{extra}\]'"):
        if package == "h5py":
            helmbench.export_problems(suite, tmp_path / "out")
        else:
            helmbench.identibench_specs(folder)
    assert not (tmp_path / "out").exists()


def test_the_command_writes_the_same(suite, folder, tmp_path, capsys):
    assert status_of(["identibench", "export", suite, "-o", str(tmp_path / "out"), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["problems"]) == 3
    for path in (path for path in folder.rglob("*") if path.is_file()):
        assert (tmp_path / "out" / path.relative_to(folder)).read_bytes() == path.read_bytes()
    assert status_of(["identibench", "import", "--data-root", str(tmp_path), "-o", str(tmp_path / "ship")]) == 2
    assert "ship set" in capsys.readouterr().err
