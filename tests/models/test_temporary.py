"""A killed command leaves no temporary file behind on the next run of the same command, which takes none in use."""

import os
import signal
import subprocess
import sys
import tempfile
from textwrap import dedent

import pytest

from helmbench.models.temporary import _held, leftovers, remove_leftovers, temporary_file, temporary_folder

COMMANDS = {
    "one file": """
        from helmbench.models.folders import write_atomic
        write_atomic(folder / "result", b"1")""",
    "several files": """
        from helmbench.models.files import replace_together
        replace_together({folder / name: lambda path: path.write_bytes(b"1") for name in "ab"})""",
    "compiled code": """
        from helmbench.models.cache import store
        store(folder / "kernel", b"1")""",
    "a folder": """
        from helmbench.bench.exam.folder import _new_folder
        with _new_folder(folder / "exam") as place:
            (place / "world").mkdir()
            (place / "world" / "record.csv").write_bytes(b"1")""",
    "a copy of a log": """
        from helmbench.datasets.importing.formats.autopilots import as_file
        with as_file(b"1", ".bin"):
            os.replace("", "")""",
    "the page": """
        from helmbench.open.serve import site
        with site() as made:
            made.projects.new()
            os.replace("", "")""",
}
"""Code of a command -> what it does in `folder`; it moves what is ready to its place, or does so with nothing."""
BEGIN = """
import os, pathlib, signal, sys, tempfile
folder = pathlib.Path(sys.argv[1])
tempfile.tempdir = sys.argv[1]
def replaced(*_):
    {body}
os.replace = replaced
if True:"""


def process(folder, command, body):
    """A process that does `body` when its command moves a file to its place."""
    code = BEGIN.format(body=body) + COMMANDS[command]
    return subprocess.Popen([sys.executable, "-c", code, folder], stdout=subprocess.PIPE)


@pytest.mark.parametrize("command", COMMANDS)
def test_the_next_run_removes_what_a_killed_one_left(command, tmp_path, monkeypatch):
    with process(tmp_path, command, "os.kill(os.getpid(), signal.SIGKILL)") as killed:
        assert killed.wait(60) == -signal.SIGKILL and list(tmp_path.iterdir()) != []
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(os, "replace", lambda *_: None)
    exec(dedent(COMMANDS[command]), {"folder": tmp_path, "os": os})
    assert list(tmp_path.iterdir()) == []


def test_what_a_live_process_uses_is_left_alone(tmp_path):
    with process(tmp_path, "several files", "print(flush=True); signal.pause()") as live:
        live.stdout.readline()
        before = leftovers(tmp_path)
        remove_leftovers(tmp_path)
        after = leftovers(tmp_path)
        live.kill()
    assert len(before) == 2 and after == before
    remove_leftovers(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_it_is_gone_at_the_end_or_moved(tmp_path):
    with temporary_file(tmp_path) as file, temporary_folder(tmp_path) as folder:
        (folder / "deep").mkdir()
        remove_leftovers(tmp_path)  # this process uses them
        assert folder.is_dir() and folder.stat().st_mode & 0o777 == 0o700
        file.rename(tmp_path / "kept")
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_links_and_what_bears_no_such_name_are_left_alone(tmp_path):
    (tmp_path / "victim").write_text("kept")
    (tmp_path / ".helmbench-link.tmp").symlink_to(tmp_path / "victim")
    (tmp_path / ".other.tmp").write_text("kept")
    before = sorted(tmp_path.iterdir())
    remove_leftovers(tmp_path)
    assert sorted(tmp_path.iterdir()) == before and (tmp_path / "victim").read_text() == "kept"


def test_without_locks_nothing_is_removed(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fcntl", None)
    (tmp_path / ".helmbench-left.tmp").write_text("")
    with temporary_file(tmp_path) as file:
        remove_leftovers(tmp_path)
        assert set(leftovers(tmp_path)) == {tmp_path / ".helmbench-left.tmp", file}


def test_a_name_that_is_taken_for_a_leftover_while_it_is_made_is_made_again(tmp_path):
    """Between the making of a file and its lock another process may look for leftovers."""
    made = []

    def make(path):
        path.write_text("")
        made.append(path)
        if len(made) == 1:
            path.unlink()

    with _held(tmp_path, make, lambda path: path.unlink()) as path:
        assert len(made) == 2 and path == made[1] and path.exists()
