"""The examples of docs/how-to/extend.md work as they stand; CONTRIBUTING.md says where everything stands."""

import csv
import importlib
import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import helmbench
from helmbench.cli import status_of

from .expectations.injections import injected
from .nightly_marks import nightly_but
from .support.inline_pool import inline

pytestmark = pytest.mark.usefixtures("in_this_process")
ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "docs" / "how-to" / "extend.md").read_text(encoding="utf-8")
OWN_METHOD = "A method of your own, outside this repository"
CAUSES = {
    "surge_offset": "A sensor cause",
    "rudder_stall": "A rudder cause",
    "resistance_in_turn": "A force cause",
}
"""Cause -> the heading of its example."""


def example(language: str, heading: str) -> str:
    """The only example in a language below a heading."""
    (section,) = re.findall(rf"^##+ {re.escape(heading)}\n(.*?)(?=^##+ |\Z)", TEXT, re.DOTALL | re.MULTILINE)
    (block,) = re.findall(rf"^```{language}\n(.*?)^```", section, re.DOTALL | re.MULTILINE)
    return block


def loaded(name: str, text: str, folder: Path, monkeypatch: pytest.MonkeyPatch):
    """The example as a module of its package, which it joins as one further file."""
    package = importlib.import_module(name.rpartition(".")[0])
    (folder / f"{name.rpartition('.')[2]}.py").write_text(text, encoding="utf-8")
    monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
    monkeypatch.delitem(sys.modules, name, raising=False)
    importlib.invalidate_caches()
    return importlib.import_module(name)


@pytest.fixture
def vessel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The example vessel, as if its file lay beside the others."""
    from helmbench.models import vessel as vessels

    path = tmp_path / "training-ship.yaml"
    path.write_text(example("yaml", "A vessel: one YAML file"), encoding="utf-8")
    files = {**vessels.vessel_files(), path.stem: path}
    monkeypatch.setattr("helmbench.models.model.vessel_files", lambda: files)
    return helmbench.resolve("training-ship")


@pytest.fixture
def method(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The example method, loaded as a module of the methods room."""
    text = example("python", "A method: one file")
    return loaded("helmbench.methods.shrinkage", text, tmp_path, monkeypatch).Shrinkage


def test_contributing_names_every_folder_that_is_installed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rooms = set(project["tool"]["setuptools"]["package-dir"].values())
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = re.findall(r"^    (\w+)/", text, re.MULTILINE)
    assert len(named) == len(set(named)) and set(named) == rooms | {"helmbench", "docs", "tests", "reports"}


def test_example_vessel_is_read(vessel):
    assert vessel.parameters == pytest.approx({"T": 21.0, "K": 0.11, "alpha": 140.0})
    assert vessel.suite["train"] == ["zigzag:20/20"]


def test_example_method_recovers_the_example_vessel(vessel, method):
    record = helmbench.generate(helmbench.Case("training-ship", "zigzag:20/20@euler"))
    exact = method(penalty=0.0).fit([record], vessel.blanked())
    np.testing.assert_allclose(exact.coefficients, vessel.coefficients, rtol=1e-9)
    shrunk = method(penalty=1e-4).fit([record], vessel.blanked())
    assert 1e-6 < np.max(np.abs(shrunk.coefficients / vessel.coefficients - 1.0)) < 0.5


def test_example_method_keeps_the_contract(method):
    from helmbench.methods.contract import check_method

    check_method(method)


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The example method that is not of this repository, alone in the working directory."""
    (tmp_path / "mine.py").write_text(example("python", OWN_METHOD), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_own_method_is_short():
    assert len(example("python", OWN_METHOD).splitlines()) < 40


def test_own_method_appears_on_the_leaderboard(mine):
    for line in example("sh", OWN_METHOD).splitlines():
        program, *words = shlex.split(line)
        jobs = ["--jobs", "1"] if words[0] == "run" else []
        assert (program, status_of([*words, *jobs])) == ("helmbench", 0), line
    text = (mine / "out" / "leaderboard.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    overall = {row["method"]: row for row in rows}
    assert set(overall) == {"lad", "ls"}
    assert int(overall["lad"]["ok"]) == int(overall["lad"]["runs"]) >= 3
    assert float(overall["lad"]["rel_error"]) < 0.2
    assert "lad" in (mine / "out" / "leaderboard.md").read_text(encoding="utf-8")


def test_own_method_keeps_the_contract(mine):
    from helmbench.methods.contract import check_method
    from helmbench.methods.registry import find

    check_method(find("mine.py:LeastAbsolute"))


def test_own_method_by_entry_point(mine):
    """As an installed package: a module and its metadata on the import path."""
    (name, points), *rest = tomllib.loads(example("toml", OWN_METHOD))["project"]["entry-points"].items()
    info = mine / "mine-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n", encoding="utf-8")
    lines = [f"[{name}]", *(f"{key} = {value}" for key, value in points.items())]
    (info / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    command = [sys.executable, "-m", "helmbench", "list", "methods", "--json"]
    path = os.pathsep.join(filter(None, [str(mine), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(command, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, check=True)
    assert "lad" in {entry["id"] for entry in json.loads(done.stdout)} and not rest


@pytest.fixture(params=CAUSES)
def cause(request, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """An example cause, found by the registry as one further file of its folder."""
    from helmbench.diagnosis.causes import registry
    from helmbench.diagnosis.causes.base import Cause
    from helmbench.models.discovery import classes_in

    text = example("python", CAUSES[request.param])
    module = loaded(f"helmbench.diagnosis.causes.{request.param}", text, tmp_path, monkeypatch)
    registry.all_causes.cache_clear()
    (cls,) = classes_in(module, Cause)
    yield cls
    monkeypatch.undo()
    registry.all_causes.cache_clear()


def test_example_cause_is_one_file_of_the_bank(cause):
    from helmbench.diagnosis.causes import registry

    assert registry.cause(cause.id) == cause() and cause() in registry.bank()


def test_example_cause_with_a_prior_is_asked_for_by_free_runs(cause):
    from helmbench.diagnosis.one_bank.catalogue import Facts, bank_of

    bank = bank_of(helmbench.resolve("mariner"), Facts({"r", "u"}, False, 1, 300.0), 8.0, None)
    assert (cause.id in {c.id for c in bank.candidates}) == bool(cause.prior.sd)


def test_example_cause_keeps_the_contract(cause):
    from helmbench.diagnosis.contract import check_cause

    check_cause(cause)


FEW = ("rudder_offset", "yaw_rate_scale", "rudder_effectiveness", "yaw_rate_bias")


def test_example_diagnoser_names_one_cause_at_most(tmp_path, monkeypatch, rng):
    from helmbench.diagnosis.options import Options
    from helmbench.diagnosis.registry import find

    loaded("helmbench.diagnosis.baselines.single", example("python", "A diagnoser: one file"), tmp_path, monkeypatch)
    case = injected("mariner", ("rudder_offset", "yaw_rate_scale"), rng)
    found = find("single")().diagnose(
        helmbench.resolve("mariner"), case.train, case.held_out[:1], Options(coefficient_sd=0.0, only=FEW)
    )
    print(found.verdict, found.causes)
    assert len(found.causes) == 1


@pytest.mark.parametrize("cause", ["surge_offset"], indirect=True)
def test_example_cause_is_named_by_free_runs(cause):
    from helmbench.diagnosis.diagnose import diagnose
    from helmbench.diagnosis.options import Options

    noise = "low,surge.bias=0.3m_s"
    records = [helmbench.generate(helmbench.Case("mariner", f"zigzag:{a}/{a}", noise, seed=a)) for a in (10, 20)]
    options = Options(channels=("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s"))  # positions have a check
    said = diagnose(helmbench.resolve("mariner"), records[:1], records[1:], options)
    print(said.verdict, said.reason, said.causes)
    (found,) = said.causes
    assert found.cause == cause.id and found.sizes[0].value == pytest.approx(0.3, rel=0.1)


@pytest.fixture
def injectable(cause, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The example cause together with the effect that it should find."""
    from helmbench.bench.faults.effects import base

    folder = tmp_path / "effects"
    folder.mkdir()
    heading = f"The effect of the {CAUSES[cause.id].removeprefix('A ')}"
    loaded(f"helmbench.bench.faults.effects.{cause.id}", example("python", heading), folder, monkeypatch)
    base.kinds.cache_clear()
    yield cause.id
    monkeypatch.undo()
    base.kinds.cache_clear()


@pytest.mark.parametrize("cause", nightly_but(CAUSES, "surge_offset"), indirect=True)
def test_example_cause_finds_the_effect_of_the_truth_simulator(injectable, rng):
    from helmbench.diagnosis.diagnose import diagnose
    from helmbench.diagnosis.options import Options

    case = injected("mariner", (injectable,), rng)
    options = Options(coefficient_sd=0.0, max_effects=1, only=(injectable,))
    (finding,) = diagnose(helmbench.resolve("mariner"), case.train, options=options).causes
    truths = case.effects[0].kind.truths(case.effects[0].at(0), case.case.ship, finding.details)
    print(case.truth, truths, finding)
    assert finding.cause == injectable
    assert finding.sizes
    for size in finding.sizes:  # five standard errors: 90 % intervals are 3.29 wide
        assert abs(size.value - truths[size.parameter]) < 5.0 * (size.high - size.low) / 3.29


def test_example_suite_is_listed_and_holds_what_it_says(tmp_path, monkeypatch):
    from helmbench.bench import suites
    from helmbench.bench.kinds import kind_of
    from helmbench.bench.kinds.base import RunSelection

    (tmp_path / "gentle.yaml").write_text(example("yaml", "A suite: one YAML file"), encoding="utf-8")
    monkeypatch.setattr(suites, "FOLDER", tmp_path)
    assert suites.suite_names() == ["gentle"]
    suite = suites.load_suite("gentle")
    specs = kind_of(suite.kind).plan(suite, RunSelection("gentle"))
    rows = [spec.row_key() for spec in specs]
    assert len(rows) == 2 * 2 * 2 * 2 * 2
    assert {row["train"] for row in rows} == {"zigzag:5/5", "zigzag:5/5+turn:10"}


def test_example_score_fills_its_column(tmp_path, monkeypatch):
    from helmbench.bench import runner, suites
    from helmbench.bench.kinds import kind_of
    from helmbench.bench.kinds.base import RunSelection
    from helmbench.bench.scores import base as registry
    from helmbench.bench.store import read_tables

    (tmp_path / "mine.yaml").write_text(
        "entries: [{vessels: response-1, methods: ls-forward, euler: true}]", encoding="utf-8"
    )
    loaded("helmbench.bench.scores.nearly_right", example("python", "A score: one file"), tmp_path, monkeypatch)
    registry.scores.cache_clear()
    suite = suites.load_suite(str(tmp_path / "mine.yaml"))
    specs = kind_of(suite.kind).plan(suite, RunSelection("mine"))
    with inline() as workers, runner.open_store(tmp_path / "out", suite, RunSelection("mine"), specs) as store:
        runner.run(specs, store, workers)
    monkeypatch.undo()
    registry.scores.cache_clear()
    assert read_tables(tmp_path / "out")[0]["share_within_5_percent"].tolist() == [1.0]
