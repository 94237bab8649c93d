"""Faults of the machine and of files end a command in one line, with nothing half-written."""

import re
import signal
import subprocess
import sys
import time
from functools import wraps
from pathlib import Path

import pytest

import helmbench
from helmbench.cli import status_of
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.io import write_record


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a record `a.csv`."""
    path = tmp_path_factory.mktemp("records")
    write_record(generate(Case("response-1", "zigzag:20/20", "low", seed=1, duration_s=60.0, dt_s=0.5)), path / "a.csv")
    return path


@pytest.fixture
def told(capsys):
    """Run a command that must fail: its status and its one line."""

    def run(*arguments):
        status = status_of([str(argument) for argument in arguments])
        err = capsys.readouterr().err
        assert err.count("\n") == 1 and err.startswith("helmbench: ") and "Traceback" not in err
        return status, err.strip()

    return run


def identify(folder, *more):
    return "identify", folder / "a.csv", "--model", "response-1", "--method", "ls", "-o", folder / "m.json", *more


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OSError(28, "No space left on device"), "No space left on device"),
        (PermissionError(13, "Permission denied", "x"), "Permission denied"),
        (MemoryError("cannot allocate 9 GiB"), "not enough memory (cannot allocate 9 GiB)"),
    ],
)
def test_a_fault_while_writing_leaves_nothing(error, said, folder, told, monkeypatch):
    def fails(*_, **__):
        raise error

    before = sorted(folder.iterdir())
    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", fails)
        status, line = told(*identify(folder))
    assert status == 2 and said in line
    assert sorted(folder.iterdir()) == before


def test_a_fault_of_the_machine_without_a_file_is_one_line(folder, told, monkeypatch):
    def fails(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("helmbench.methods.ls.Ls.estimate", fails)
    assert told(*identify(folder)) == (2, "helmbench: No space left on device")


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("identify", "helmbench: interrupted"),
        ("run", "helmbench: interrupted (a run is continued with --resume)"),
        ("reproduce", "helmbench: interrupted (a run is continued with --resume)"),
    ],
)
def test_only_what_can_be_resumed_says_so(command, said, folder, capsys, monkeypatch):
    for name in ("resolve", "run_suite", "reproduce"):

        @wraps(getattr(helmbench, name))
        def interrupted(*_, **__):
            raise KeyboardInterrupt

        monkeypatch.setattr(f"helmbench.{name}", interrupted)
    arguments = {"identify": identify(folder), "run": ("run", "-o", folder / "out"), "reproduce": ("reproduce",)}
    assert status_of([str(argument) for argument in arguments[command]]) == 130
    assert capsys.readouterr().err.strip() == said


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_command_as_an_interrupt_does(number):
    code = (
        "import signal, time, click\nfrom helmbench import cli\n"
        f"signal.signal({int(number)}, signal.SIG_DFL)\n"  # a test that runs under nohup inherits that it is ignored
        "@click.command()\ndef wait():\n    print('on', flush=True)\n    time.sleep(60)\n"
        "cli.cli.add_command(wait)\ncli.RESUMED = ('wait',)\ncli.main(['wait'])\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "on\n"
    started = time.perf_counter()
    child.send_signal(number)
    _, err = child.communicate(timeout=30)
    assert child.returncode == 128 + number and time.perf_counter() - started < 20
    assert err.strip() == "helmbench: interrupted (a run is continued with --resume)"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--manoeuvre", "zigzag:20/20", "--duration", "1e12"), "of memory are needed"),
        (("--manoeuvre", "zigzag:20/20", "--dt", "1e-12"), "of memory are needed"),
        (("--manoeuvre", "steps:30deg/1e-9s"), "the clock of 1e-09 s is too short"),
        (("--manoeuvre", "prbs:30deg/1e-9s"), "the clock of 1e-09 s is too short"),
    ],
)
def test_a_simulation_that_would_not_end_is_refused(arguments, said, folder, told):
    status, line = told("simulate", "response-1", *arguments, "-o", folder / "big.csv")
    assert status == 2 and said in line and not (folder / "big.csv").exists()


def test_a_model_of_tiny_steps_is_refused(folder, told, tmp_path):
    assert status_of([str(part) for part in (*identify(folder), "--quiet")]) == 0
    text = (folder / "m.json").read_text()
    (folder / "m.json").unlink()
    (tmp_path / "tiny.json").write_text(re.sub(r'"max_step_s": [\d.e-]+', '"max_step_s": 1e-9', text))
    status, line = told("simulate", tmp_path / "tiny.json", "--manoeuvre", "zigzag:20/20", "-o", folder / "o.csv")
    assert status == 2 and "max_step_s" in line


@pytest.mark.parametrize("seeds", ["1" + "0" * 400, "1000001", "1000"])
def test_a_suite_that_would_not_end_is_refused(seeds, folder, told, monkeypatch):
    monkeypatch.setattr("helmbench.bench.kinds.base.MOST_RUNS", 100)
    suite = folder / "s.yaml"
    suite.write_text(f"entries: [{{vessels: response-1, methods: ls, noise: low, seeds: {seeds}}}]")
    status, line = told("run", "--suite", suite, "-o", folder / "out")
    suite.unlink()
    assert status == 2 and not (folder / "out").exists() and len(line) < 300


def test_a_record_given_twice_is_refused(folder, told, tmp_path):
    (tmp_path / "copy.csv").write_bytes((folder / "a.csv").read_bytes())
    twice = folder / "a.csv", tmp_path / "copy.csv"
    out = ("-o", tmp_path / "out")
    model = ("--model", "response-1")
    for command in (
        ("identify", *twice, *model, "--method", "ls", "-o", tmp_path / "m.json"),
        ("identify", twice[0], "--validate", twice[1], *model, "--method", "ls", "-o", tmp_path / "m.json"),
        ("diagnose", *model, "--train", *twice, *out),
        ("diagnose", *model, "--train", twice[0], "--held-out", twice[1], *out),
        ("calibrate", "--model", "mariner", "--train", *twice, *out),
        ("validate", "response-1", *twice),
    ):
        status, line = told(*command)
        assert status == 2 and ("same samples" in line or "both a training record" in line)
    assert not (tmp_path / "out").exists() and not (tmp_path / "m.json").exists()


def test_names_that_are_no_text_are_refused(folder, told):
    for place in (("a\udcff.csv", "m.json"), ("a.csv", "m\udcff.json")):
        record, output = (folder / name for name in place)
        status, line = told("identify", record, "--model", "response-1", "--method", "ls", "-o", output)
        assert status == 2 and "not UTF-8 text" in line and line.isprintable()


@pytest.mark.parametrize("output", ["/dev/null", "/proc/m.json"])
def test_a_place_that_is_no_file_is_refused_before_anything_is_computed(output, folder, told):
    status, line = told("identify", folder / "a.csv", "--model", "response-1", "--method", "ls", "-o", output)
    assert status == 2 and output.rpartition("/")[0] in line


def test_a_diagnosis_that_needs_more_memory_than_there_is_is_refused(folder, told, monkeypatch, tmp_path):
    monkeypatch.setattr("helmbench.models.memory.available_bytes", lambda: 1e6)
    status, line = told("diagnose", "--model", "response-1", "--train", folder / "a.csv", "-o", tmp_path / "out")
    assert status == 2 and "121 samples of 1 record: about" in line and not (tmp_path / "out").exists()
