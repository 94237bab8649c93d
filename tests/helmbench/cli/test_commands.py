"""The command line: what it prints, what it writes, and that bad input is one line, status 2 and nothing written."""

import json
import re
import subprocess
import sys
from pathlib import Path

import click
import pandas as pd
import pytest

from helmbench.cli import cli, status_of
from helmbench.cli._shared import spread
from helmbench.datasets.io import read_record
from helmbench.methods.registry import methods
from helmbench.models.model import list_vessels, resolve

HEAVY = ("numpy", "pandas", "pyarrow", "scipy", "sympy", "numba", "sklearn", "jinja2", "joblib", "yaml", "tqdm")
GOOD = "\n".join(
    ["time_s,rudder_rad,yaw_rate_rad_s,heading_rad"]
    + [f"{t / 10},{0.1 if t % 40 < 20 else -0.1},{0.001 * (t % 17)},{0.01 * (t % 23)}" for t in range(60)]
)


def line(text, number, new):
    lines = text.split("\n")
    lines[number - 1] = new
    return "\n".join(lines)


def columns(text, **new):
    """The text with columns replaced by functions of the row's number."""
    header, *rows = [row.split(",") for row in text.split("\n")]
    for name, value in new.items():
        place = header.index(name)
        for number, row in enumerate(rows):
            row[place] = str(value(number))
    return "\n".join(",".join(row) for row in [header, *rows])


BAD_RECORDS = {
    "missing time": (GOOD.replace("time_s", "roll_rad", 1), "time"),
    "missing rudder": (GOOD.replace("rudder_rad", "roll_rad"), "rudder"),
    "unknown column": (GOOD.replace("heading_rad", "headding_rad"), "headding_rad"),
    "unknown unit": (GOOD.replace("heading_rad", "heading_grad"), "heading_grad"),
    "duplicate column": (GOOD.replace("heading_rad", "rudder_rad"), "rudder_rad"),
    "time goes back": (line(GOOD, 12, "0.3,0.1,0.0,0.1"), "row 12"),
    "duplicate time": (line(GOOD, 12, "0.9,0.1,0.0,0.1"), "row 12"),
    "constant channel": (columns(GOOD, heading_rad=lambda _: 0.5, yaw_rate_rad_s=lambda _: 0.0), "heading_rad"),
    "too short": ("\n".join(GOOD.split("\n")[:4]), "samples"),
    "empty channel": (columns(GOOD, yaw_rate_rad_s=lambda _: "nan"), "yaw_rate_rad_s"),
    "text in a number column": (line(GOOD, 30, "2.8,port,0.0,0.1"), "row 30"),
    "infinite value": (line(GOOD, 30, "2.8,inf,0.0,0.1"), "row 30"),
    "row too short": (line(GOOD, 30, "2.8,0.1"), "row 30"),
    "wrong encoding": (GOOD.encode("utf-16"), ""),
    "empty file": ("", ""),
}


def test_no_default_place_is_a_folder_of_the_repository():
    """The reader may well be in the clone."""
    root = Path(__file__).resolve().parents[3]
    groups = [
        *cli.commands.values(),
        *(own for c in cli.commands.values() for own in getattr(c, "commands", {}).values()),
    ]
    options = [option for command in groups for option in command.params if option.name == "output"]
    places = {option.default for option in options if isinstance(option.default, str)}
    assert len(places) > 5 and [place for place in places if (root / place).exists()] == []


@pytest.fixture
def call(capsys):
    """Run the command line in this process: status, stdout, stderr."""

    def run(*arguments):
        status = status_of([str(argument) for argument in arguments])
        return status, *capsys.readouterr()

    return run


@pytest.fixture
def refused(call, tmp_path, monkeypatch):
    """Run the command line in an empty folder; it must refuse in one line and leave the folder as it was."""

    def run(*arguments):
        folder = tmp_path / "work"
        folder.mkdir(exist_ok=True)
        monkeypatch.chdir(folder)
        before = sorted(path.name for path in folder.rglob("*"))
        status, out, err = call(*arguments)
        assert status == 2 and out == "", (out, err)
        assert err.startswith("helmbench: ") and err.count("\n") == 1 and "Traceback" not in err
        assert sorted(path.name for path in folder.rglob("*")) == before
        return err

    return run


@pytest.fixture
def suite(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(
        "title: mine\n"
        "entries:\n"
        "  - {vessels: [response-1, remus-kt], methods: [ls, rls], noise: [none, low], seeds: 2}\n"
    )
    return path


@pytest.fixture
def record(tmp_path, call):
    def make(name, manoeuvre="zigzag:20/20", *more):
        path = tmp_path / f"{name}.csv"
        assert call("simulate", "response-1", "--manoeuvre", manoeuvre, *more, "-o", path)[0] == 0
        return path

    return make


# starting


def test_help_imports_nothing_heavy_and_is_quick():
    code = (
        "import sys, time\n"
        "from helmbench.cli import status_of\n"
        "assert status_of(['--help']) == 0\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules], time.process_time(), file=sys.stderr)"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded, seconds = found.stderr.rsplit(" ", 1)
    assert "identify" in found.stdout and loaded == "[]"
    assert float(seconds) < 0.3  # the target that the specification sets for the CPU time of --help


def test_main_leaves_with_the_status(tmp_path):
    command = [sys.executable, "-m", "helmbench", "report", str(tmp_path)]
    found = subprocess.run(command, capture_output=True, text=True)
    assert found.returncode == 2 and found.stdout == "" and found.stderr.count("\n") == 1
    assert subprocess.run([sys.executable, "-m", "helmbench", "--version"], capture_output=True).returncode == 0


def test_without_arguments_the_help_is_shown(call):
    status, _, err = call()
    assert status == 2 and "Your record:" in err


@pytest.mark.parametrize("words", [(), ("exam",), ("identibench",)], ids=["helmbench", "exam", "identibench"])
def test_help_shows_every_command_once_with_its_whole_summary(call, words):
    group = cli.commands[words[0]] if words else cli
    status, out, _ = call(*words, "--help")
    listed = out.partition("-h, --help")[2]
    assert status == 0 and re.findall(r"^  ([a-z-]+)", listed, re.MULTILINE) == list(group.commands)
    for command in group.commands.values():
        summary = command.help.partition("\n\n")[0]
        assert f" {command.name} {' '.join(summary.split())}" in " ".join(listed.split())


@pytest.mark.parametrize("command", ["diagnose", "calibrate"])
def test_help_begins_with_the_options_of_every_day(call, command):
    _, out, _ = call(command, "--help")
    options, listed = r"^  (?:-\w, )?(--[a-z-]+)", out.partition("\nOptions:\n")[2]
    first, further = (re.findall(options, part, re.MULTILINE) for part in listed.split("\nFurther options:\n"))
    assert first == ["--model", "--train", "--held-out", "--positive-rudder", "--output"]
    own = cli.commands[command]
    assert sorted(first + further) == sorted(option.opts[-1] for option in own.get_params(click.Context(own)))


@pytest.mark.parametrize("kind", ["models", "vessels", "manoeuvres", "methods", "causes", "suites"])
def test_lists_name_everything(call, kind):
    expected = {
        "models": {"nomoto-1", "nomoto-2-quadratic", "kt", "integrator", "abkowitz", "mmg"},
        "vessels": set(list_vessels()),
        "manoeuvres": set(),
        "methods": set(methods()),
        "causes": {"rudder_offset", "wave_motion", "shallow_water", "coefficient_shift"},
        "suites": {"quick", "default", "measured"},
    }[kind]
    status, out, _ = call("list", kind, "--json")
    ids = {entry["id"] for entry in json.loads(out)}
    assert status == 0 and ids >= expected and all(entry["title"] for entry in json.loads(out))
    status, out, _ = call("list", kind)
    assert status == 0 and len(out.splitlines()) == len(ids)


# simulate and identify


def test_simulate_writes_a_record_and_its_sidecar(call, tmp_path):
    path = tmp_path / "record.csv"
    arguments = ("simulate", "mariner", "--manoeuvre", "zigzag:20/20", "--duration", 60, "--dt", 1, "--noise", "low")
    status, out, _ = call(*arguments, "--disturbance", "wind:12@40deg", "--seed", 3, "-o", path, "--json")
    told = json.loads(out)
    assert status == 0 and told["samples"] == 61 and told["positive_rudder"] == "port"
    found = read_record(path)
    assert (found.n, found.dt, found.meta.manoeuvre, found.meta.vessel) == (61, 1.0, "zigzag:20/20", "mariner")
    again = tmp_path / "again.csv"
    call(*arguments, "--disturbance", "wind:12@40deg", "--seed", 3, "-o", again)
    assert again.read_bytes() == path.read_bytes()


def test_simulate_can_turn_the_rudders_sign(call, tmp_path):
    for side in ("port", "starboard"):
        path = tmp_path / f"{side}.csv"
        assert call("simulate", "response-1", "--manoeuvre", "turn:20", "--positive-rudder", side, "-o", path)[0] == 0
    port, starboard = (read_record(tmp_path / f"{side}.csv") for side in ("port", "starboard"))
    assert port.meta.positive_rudder == "port"
    assert (port.column("rudder_rad") == -starboard.column("rudder_rad")).all()


def test_identify_prints_parameters_and_validation_and_writes_a_model(call, record, tmp_path):
    train, other, path = (
        record("train", "zigzag:20/20", "--noise", "low"),
        record("other", "turn:15"),
        tmp_path / "m.json",
    )
    arguments = ("identify", train, "--model", "nomoto-1-cubic", "--method", "output-error", "--validate", other)
    status, out, err = call(*arguments, "-o", path)
    assert status == 0 and err == f"wrote {path}\n"
    assert "alpha" in out and "+-" in out and "heading" in out and "R²" in out
    assert resolve(str(path)).parameters == pytest.approx(resolve("response-1").parameters, rel=0.02)
    told = json.loads(call(*arguments, "-o", path, "--json", "--force")[1])
    assert told["validation"]["r2_free_heading_rad"] > 0.999 and told["output"] == str(path)
    assert call(*arguments, "-o", path, "--quiet", "--force")[1] == ""


def test_identify_takes_several_records_to_train_and_to_validate(call, record, tmp_path):
    one, two, three, four = (
        record(name, f"turn:{angle}") for name, angle in zip("abcd", (10, 15, 20, 25), strict=True)
    )
    arguments = ("identify", one, two, "--model", "nomoto-1-cubic", "--method", "ls", "--validate", three, four)
    told = json.loads(call(*arguments, "--json", "-o", tmp_path / "m.json")[1])
    assert (told["train"], told["validation"]["records"]) == (["a", "b"], ["c", "d"])


def test_an_identified_model_can_be_simulated_and_identified_again(call, record, tmp_path):
    model = tmp_path / "m.json"
    call("identify", record("train"), "--model", "response-1", "--method", "output-error", "-o", model)
    assert call("simulate", model, "--manoeuvre", "turn:20", "-o", tmp_path / "again.csv")[0] == 0
    assert (
        call("identify", tmp_path / "again.csv", "--model", model, "--method", "ls", "-o", tmp_path / "n.json")[0] == 0
    )


def test_a_contradicting_rudder_sign_is_told_first(call, record, tmp_path):
    path = record("train")
    side = "port" if resolve("response-1").positive_rudder == "starboard" else "starboard"
    arguments = ("identify", path, "--model", "nomoto-1", "--method", "ls", "--force", "-o", tmp_path / "m.json")
    wrote = f"wrote {tmp_path / 'm.json'}"
    assert call(*arguments)[2] == f"{wrote}\n"
    status, _, err = call(*arguments, "--positive-rudder", side)
    first, *rest = err.splitlines()
    assert status == 0 and "rudder_sign" in first and rest == [wrote]


def test_a_method_that_fails_is_status_one(call, record, tmp_path):
    own = tmp_path / "own.py"
    own.write_text(
        "from helmbench.methods.base import FitFailed, Method\n"
        "class Mine(Method):\n"
        "    name = 'mine'\n"
        "    def estimate(self, records, model):\n"
        "        raise FitFailed('singular')\n"
    )
    arguments = (
        "identify",
        record("train"),
        "--model",
        "nomoto-1",
        "--method",
        f"{own}:Mine",
        "-o",
        tmp_path / "m.json",
    )
    status, out, err = call(*arguments)
    assert (status, out) == (1, "") and "singular" in err and not (tmp_path / "m.json").exists()


def test_greedy_options_take_values_up_to_the_next_option():
    greedy = ("--validate",)
    assert spread(["a", "--validate", "b", "c", "-o", "d"], greedy) == [
        "a",
        "--validate",
        "b",
        "--validate",
        "c",
        "-o",
        "d",
    ]
    assert spread(["--validate", "b", "--model", "m", "a"], greedy) == ["--validate", "b", "--model", "m", "a"]
    assert spread(["--validate=b", "c"], greedy) == ["--validate=b", "c"]


# run and report


def test_run_and_report_from_suite_to_leaderboard(call, suite, tmp_path):
    out = tmp_path / "out"
    status, told, err = call("run", "--suite", suite, "--jobs", 1, "-o", out)
    assert (status, err) == (0, "") and "12 runs, 12 ok" in told
    results = pd.read_parquet(out / "results.parquet")
    assert len(results) == 12 and set(results["suite"]) == {"mine"}
    status, told, _ = call("report", out)
    assert status == 0 and told.startswith("Suite mine, 12 runs: 12 ok") and len(told.splitlines()) < 30
    assert len(told.split("\n\n")[2].splitlines()) == 1 + results["method"].nunique()
    assert sorted(path.name for path in out.iterdir()) == [
        "environment.json", "leaderboard.csv", "leaderboard.html", "leaderboard.md",
        "parameters.parquet", "results.parquet", "runs.jsonl",
    ]  # fmt: skip
    assert json.loads(call("report", out, "--json")[1])["complete"] is True
    assert call("report", out, "--quiet")[1] == ""


@pytest.mark.usefixtures("in_this_process")
def test_resume_remembers_what_was_selected_and_has_nothing_to_do(call, suite, tmp_path):
    out = tmp_path / "out"
    arguments = ("--vessel", "remus-kt", "--method", "ls", "--seeds", "1")
    assert call("run", "--suite", suite, *arguments, "--jobs", 1, "--quiet", "-o", out)[:2] == (0, "")
    log = (out / "runs.jsonl").read_bytes()
    status, told, _ = call("run", "--resume", "-o", out, "--json")
    assert status == 0 and json.loads(told)["runs"] == 2 and (out / "runs.jsonl").read_bytes() == log


@pytest.mark.usefixtures("in_this_process")
def test_resume_starts_where_nothing_was_started(call, suite, tmp_path):
    arguments = ("--suite", suite, "--vessel", "remus-kt", "--method", "ls", "--jobs", 1, "--quiet")
    assert call("run", *arguments, "--resume", "-o", tmp_path / "out")[0] == 0


@pytest.mark.usefixtures("in_this_process")
def test_failed_runs_are_listed_and_status_one(call, tmp_path):
    own = tmp_path / "own.py"
    own.write_text(
        "from helmbench.methods.base import Method\n"
        "class Mine(Method):\n"
        "    name = 'mine'\n"
        "    def estimate(self, records, model):\n"
        "        raise RuntimeError('out of luck')\n"
    )
    suite = tmp_path / "mine.yaml"
    suite.write_text("entries: [{vessels: response-1, methods: ls, noise: low, seeds: 2}]")
    arguments = ("run", "--suite", suite, "--method", f"{own}:Mine", "--jobs", 1)
    status, out, err = call(*arguments, "-o", tmp_path / "out")
    assert status == 1 and "2 failed" in out
    assert err == "failed: mine on response-1 as nomoto-1-cubic, noise low: RuntimeError: out of luck (2 runs)\n"
    status, out, _ = call(*arguments, "-o", tmp_path / "json", "--json")
    assert status == 1 and [failure["seed"] for failure in json.loads(out)["failures"]] == [0, 1]
    assert "2 failed" in call("report", tmp_path / "out")[1]
    assert "out of luck" in (tmp_path / "out" / "leaderboard.md").read_text()


@pytest.mark.usefixtures("in_this_process")
def test_an_interrupt_is_told_and_what_was_finished_is_kept(call, suite, tmp_path, monkeypatch):
    def interrupted(specs, store, *_):
        store.append({"key": specs[0].key, "row": specs[0].row_key() | {"status": "ok"}, "parameters": []})
        raise KeyboardInterrupt

    out = tmp_path / "out"
    with monkeypatch.context() as patch:
        patch.setattr("helmbench.bench.runner.run", interrupted)
        status, _, err = call("run", "--suite", suite, "--jobs", 1, "-o", out)
    assert (status, err.strip()) == (130, "helmbench: interrupted (a run is continued with --resume)")
    status, told, _ = call("run", "--resume", "--jobs", 1, "-o", out)
    assert status == 0 and "12 runs, 12 ok" in told


# bad input


@pytest.mark.parametrize("fault", BAD_RECORDS)
def test_a_bad_record_is_refused(refused, tmp_path, fault):
    content, told = BAD_RECORDS[fault]
    path = tmp_path / "bad.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    err = refused("identify", path, "--model", "nomoto-1", "--method", "ls", "-o", "model.json")
    assert "bad.csv" in err and told in err


def test_a_good_record_is_not(call, tmp_path):
    (tmp_path / "good.csv").write_text(GOOD)
    arguments = (
        "identify",
        tmp_path / "good.csv",
        "--model",
        "nomoto-1",
        "--method",
        "ls",
        "-o",
        tmp_path / "model.json",
    )
    assert call(*arguments)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["frobnicate"], "frobnicate"),
        (["list", "ships"], "ships"),
        (["simulate", "mariner"], "--manoeuvre"),
        (["simulate", "titanic", "--manoeuvre", "turn:35", "-o", "r.csv"], "titanic"),
        (["simulate", "nomoto-1", "--manoeuvre", "turn:35", "-o", "r.csv"], "nomoto-1"),
        (["simulate", "mariner", "--manoeuvre", "zigzag:20", "-o", "r.csv"], "zigzag:20"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "--noise", "loud", "-o", "r.csv"], "loud"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "--disturbance", "fog:2", "-o", "r.csv"], "fog:2"),
        (["simulate", "response-1", "--manoeuvre", "turn:9", "--disturbance", "wind:9@0", "-o", "r.csv"], "wind"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "--dt", "-1", "-o", "r.csv"], "-1"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "--seed", "-1", "-o", "r.csv"], "-1"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "--positive-rudder", "left", "-o", "r.csv"], "left"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "-o", "no/such/folder/r.csv"], "no/such/folder"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "-o", "."], "directory"),
        (["simulate", "mariner", "--manoeuvre", "turn:35", "-o", "r.xlsx"], "r.xlsx"),
        (["identify", "--model", "nomoto-1", "--method", "ls", "-o", "m.json"], "RECORD"),
        (["identify", "missing.csv", "--model", "nomoto-1", "--method", "ls", "-o", "m.json"], "missing.csv"),
        (["identify", "missing.csv", "--model", "nomoto-9", "--method", "ls", "-o", "m.json"], "nomoto-9"),
        (["identify", "missing.csv", "--model", "nomoto-1", "--method", "best", "-o", "m.json"], "best"),
        (["identify", "missing.csv", "--model", "nomoto-1", "--method", "ls,scheme=odd", "-o", "m.json"], "odd"),
        (["identify", "missing.csv", "--model", "nomoto-1", "--method", "own.py:Mine", "-o", "m.json"], "own.py"),
        (["run", "--suite", "quik", "-o", "out"], "quik"),
        (["run", "--method", "best", "-o", "out"], "best"),
        (["run", "--vessel", "titanic", "-o", "out"], "titanic"),
        (["run", "--seeds", "0", "-o", "out"], "seeds"),
        (["run", "--jobs", "0", "-o", "out"], "jobs"),
        (["report", "nowhere"], "nowhere"),
        (["fetch", "kvlcc3"], "kvlcc3"),
    ],
    ids=lambda value: " ".join(value)[:60] if isinstance(value, list) else "",
)
def test_bad_arguments_are_refused(refused, arguments, told):
    assert told in refused(*arguments)


def test_a_run_does_not_touch_a_directory_that_holds_something(refused, tmp_path):
    (tmp_path / "work" / "out").mkdir(parents=True)
    (tmp_path / "work" / "out" / "thesis.tex").write_text("years of work")
    assert "not empty" in refused("run", "-o", "out")


@pytest.mark.usefixtures("in_this_process")
def test_a_started_run_is_not_started_again_nor_resumed_as_another(refused, call, suite, tmp_path):
    out = tmp_path / "out"
    chosen = ("--vessel", "remus-kt", "--method", "ls", "--jobs", 1)
    assert call("run", "--suite", suite, *chosen, "--quiet", "-o", out)[0] == 0
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    assert "--resume" in refused("run", "--suite", suite, *chosen, "-o", out)
    assert "selection" in refused("run", "--suite", suite, *chosen, "--seeds", 9, "--resume", "-o", out)
    assert "suite" in refused("run", "--suite", "quick", "--resume", "-o", out)
    assert before == {path.name: path.read_bytes() for path in out.iterdir()}


def test_a_measured_suite_without_its_data_is_refused_before_anything_is_run(refused, tmp_path, monkeypatch):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path / "empty"))
    err = refused("run", "--suite", "measured", "-o", "out")
    assert "helmbench fetch kvlcc2-hsva" in err


def test_a_scheduler_without_dask_is_refused_before_anything_is_written(refused, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "dask" in refused("run", "--scheduler", "tcp://127.0.0.1:8786", "-o", "out")


def test_what_the_file_system_refuses_is_one_line(refused, monkeypatch):
    def denied(*_):
        raise PermissionError(13, "Permission denied", "r.csv")

    monkeypatch.setattr("helmbench.write_record", denied)
    assert "r.csv: Permission denied" in refused("simulate", "remus-kt", "--manoeuvre", "turn:5", "-o", "r.csv")
