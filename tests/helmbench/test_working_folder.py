"""Files of the working folder are never run: a log folder may hold a `threading.py` or a `joblib.py`."""

import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

import helmbench
from helmbench.models.folders import VARIABLE, without_working_folder
from helmbench.open import serve

HOSTILE = (
    "threading", "joblib", "numpy", "random", "socket", "tempfile", "subprocess", "pickle", "json",
    "argparse", "multiprocessing", "signal", "selectors", "typing", "dataclasses", "pathlib", "struct",
    "hashlib", "logging", "queue", "click", "scipy", "pandas", "numba", "cloudpickle",
    "distributed", "starlette", "uvicorn", "pydantic", "openpyxl", "sitecustomize", "usercustomize",
)  # fmt: skip
POOL = """
from helmbench.bench.pool import processes

if __name__ == "__main__":
    with processes(2) as pool:
        assert sorted(one.result for one in pool.outcomes(abs, [-1, 2, -3])) == [1, 2, 3]
"""


@pytest.fixture
def hostile(tmp_path, monkeypatch):
    """The working folder, with modules that write their name into `ran` when they are imported."""
    folder = tmp_path / "logs"
    folder.mkdir()
    for name in HOSTILE:
        (folder / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'a').write('{name} ')\n")
    monkeypatch.chdir(folder)
    monkeypatch.delenv(VARIABLE, raising=False)
    return folder


def ran(folder):
    """Names of the files of the working folder that were run."""
    file = folder.parent / "ran"
    return file.read_text() if file.exists() else ""


def command(folder, *words):
    done = subprocess.run([sys.executable, *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_worker_processes_run_nothing_of_it(hostile):
    (hostile.parent / "pool.py").write_text(POOL)
    command(hostile, hostile.parent / "pool.py")
    assert ran(hostile) == ""


def test_python_m_runs_nothing_of_it(hostile):
    command(hostile, "-m", "helmbench", "list", "suites")
    assert ran(hostile) == ""


def test_the_processes_of_the_page_run_nothing_of_it(hostile, monkeypatch):
    """Also where the server is started from an interactive session, whose path begins with the working folder."""
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    (hostile / "log.xlsx").write_bytes(b"PK\x03\x04")  # is read in a process of its own
    with serve.site() as made:
        project = made.projects.get(serve._with_logs(made.projects, [hostile / "log.xlsx"]))
        while project.busy():
            time.sleep(0.02)
    assert project.job.state == "done" and ran(hostile) == ""


def test_the_path_of_a_session_is_as_before_afterwards(monkeypatch):
    monkeypatch.setattr(sys, "path", ["first", "", "last"])
    monkeypatch.setenv(VARIABLE, "")
    with without_working_folder():
        assert sys.path == ["first", "last"] and os.environ[VARIABLE] == "1"
        assert multiprocessing.spawn.get_preparation_data("worker")["sys_path"] == ["first", "last"]
    assert sys.path == ["first", "", "last"] and os.environ[VARIABLE] == ""


def test_a_package_that_lies_in_the_working_folder_is_run(tmp_path):
    """A checkout that is not installed."""
    (tmp_path / "helmbench").mkdir()
    (tmp_path / "helmbench" / "__main__.py").write_text("import sys; print(sys.path[0])")
    for name in ("__init__.py", "__init__.pyi"):
        text = Path(helmbench.__file__).with_name(name).read_text("utf-8")
        (tmp_path / "helmbench" / name).write_text(text, "utf-8")
    done = subprocess.run([sys.executable, "-m", "helmbench"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(tmp_path)]
