"""A folder of results from elsewhere: nothing outside it is read, written, cut off or removed, whatever lies in it."""

import json
import os
import re
import shutil

import pandas as pd
import pytest

import helmbench
from helmbench.bench.journal import RUNS, DamagedRunsWarning, sealed, unsealed
from helmbench.bench.kinds.base import TIMES
from helmbench.bench.kinds.identification.columns import PARAMETERS, RESULTS
from helmbench.bench.store import MANIFEST
from helmbench.bench.traces import read_traces
from helmbench.models.errors import BadInput
from helmbench.models.folders import write_atomic

pytestmark = pytest.mark.usefixtures("in_this_process")
CONTENT = b"export PATH=/usr/bin\nalias ll='ls -l'"
"""Of a file that the user has elsewhere; its last line has no end, as a torn one of a journal."""


def start(folder, **more):
    return helmbench.run_suite(
        "quick", vessels=["response-1"], methods=["ls"], seeds=1, directory=folder, jobs=1, **more
    )


@pytest.fixture(scope="module")
def finished(tmp_path_factory, request):
    from tests.support.inline_pool import without_workers

    folder = tmp_path_factory.mktemp("finished") / "out"
    with without_workers():
        start(folder)
    return folder


@pytest.fixture
def folder(finished, tmp_path):
    """A copy of a finished run, of which the last run is not stored yet."""
    copy = tmp_path / "out"
    shutil.copytree(finished, copy)
    lines = (copy / RUNS).read_bytes().splitlines(keepends=True)
    (copy / RUNS).write_bytes(b"".join(lines[:-1]))
    for table in (RESULTS, PARAMETERS):
        (copy / table).unlink()
    return copy


@pytest.fixture
def victim(tmp_path):
    path = tmp_path / "bashrc"
    path.write_bytes(CONTENT)
    return path


def replaced(place, victim, how):
    place.unlink(missing_ok=True)
    if how == "link":
        place.symlink_to(victim)
    elif how == "dangling":
        place.symlink_to(victim.parent / "new")
    elif how == "hard link":
        place.hardlink_to(victim)
    elif how == "pipe":
        os.mkfifo(place)
    else:
        place.mkdir()


@pytest.mark.parametrize(
    ("name", "how"),
    [
        *((RUNS, how) for how in ("link", "dangling", "hard link", "pipe", "folder")),
        *((name, how) for name in (MANIFEST, RESULTS, PARAMETERS) for how in ("link", "dangling", "folder")),
    ],
)
def test_a_run_is_continued_in_regular_files_alone(folder, victim, name, how):
    replaced(folder / name, victim, how)
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file() and path.name != name}
    with pytest.raises(BadInput, match=re.escape(name)):
        start(folder, resume=True)
    assert victim.read_bytes() == CONTENT and not (victim.parent / "new").exists()
    assert before == {path: path.read_bytes() for path in before}


def test_a_resume_that_is_refused_writes_nothing(folder):
    manifest = json.loads((folder / MANIFEST).read_text())
    (folder / MANIFEST).write_text(json.dumps(manifest | {"version": "another"}))
    (folder / ".hidden.tmp").write_text("torn")
    with (folder / RUNS).open("ab") as file:
        file.write(b"torn")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(BadInput, match="version differs"):
        start(folder, resume=True)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("name", ["leaderboard.md", "leaderboard.html", "leaderboard.csv"])
def test_a_report_replaces_a_link_and_not_what_it_names(folder, victim, name):
    start(folder, resume=True)
    (folder / name).symlink_to(victim)
    for number in {os.getpid(), *range(1, 50)}:
        (folder / f".{name}.{number}.tmp").symlink_to(victim)
    helmbench.write_report(folder)
    assert victim.read_bytes() == CONTENT and not (folder / name).is_symlink()


@pytest.mark.parametrize("name", [RUNS, RESULTS, MANIFEST])
@pytest.mark.parametrize("how", ["link", "pipe"])
def test_a_report_reads_no_link_and_no_pipe(folder, victim, name, how):
    start(folder, resume=True)
    if name == RUNS:
        (folder / RESULTS).unlink()
    replaced(folder / name, victim, how)
    with pytest.raises(BadInput, match=re.escape(name)):
        helmbench.write_report(folder)
    assert not list(folder.glob("leaderboard.*"))


def test_a_temporary_name_that_is_a_link_is_not_written_through(tmp_path, victim):
    for number in range(os.getpid() - 5, os.getpid() + 5):
        (tmp_path / f".table.{number}.tmp").symlink_to(victim)
    write_atomic(tmp_path / "table", b"new")
    assert victim.read_bytes() == CONTENT and (tmp_path / "table").read_bytes() == b"new"


@pytest.mark.parametrize("name", ["", RUNS])
def test_a_folder_or_a_journal_of_another_user_is_not_written_to(folder, name, monkeypatch):
    other = (folder / name).stat().st_ino
    monkeypatch.setattr("helmbench.models.folders.is_own", lambda found: found.st_ino != other)
    before = (folder / RUNS).read_bytes()
    with pytest.raises(BadInput, match="another user"):
        start(folder, resume=True)
    assert (folder / RUNS).read_bytes() == before and not (folder / RESULTS).exists()


def test_a_new_run_is_not_begun_in_a_folder_of_another_user(tmp_path, monkeypatch):
    monkeypatch.setattr("helmbench.models.folders.is_own", lambda found: False)
    with pytest.raises(BadInput, match="another user"):
        start(tmp_path)
    assert not list(tmp_path.iterdir())


def test_one_changed_digit_does_not_survive_a_resume(finished, tmp_path, rng):
    folder = tmp_path / "out"
    shutil.copytree(finished, folder)
    whole = (folder / RUNS).read_bytes()
    digits = [found.start() for found in re.finditer(rb"[0-9]", whole)]
    place = digits[int(rng.integers(len(digits)))]
    digit = str((int(whole[place : place + 1]) + int(rng.integers(1, 10))) % 10).encode()
    (folder / RUNS).write_bytes(whole[:place] + digit + whole[place + 1 :])
    with pytest.warns(DamagedRunsWarning):
        start(folder, resume=True)
    for table in (RESULTS, PARAMETERS):
        was, now = (pd.read_parquet(one / table).drop(columns=TIMES, errors="ignore") for one in (finished, folder))
        pd.testing.assert_frame_equal(was, now)


def test_one_changed_digit_of_a_trace_is_not_shown(finished, tmp_path, rng):
    whole = (finished / RUNS).read_bytes()
    begin = whole.index(b'"trace"')
    part = whole[begin : whole.index(b'"digest"', begin)]
    digits = [begin + found.start() for found in re.finditer(rb"[0-9]", part)]
    place = digits[int(rng.integers(len(digits)))]
    digit = str((int(whole[place : place + 1]) + 1) % 10).encode()
    (tmp_path / RUNS).write_bytes(whole[:place] + digit + whole[place + 1 :])
    count = len(read_traces(finished))
    with pytest.warns(DamagedRunsWarning):
        assert count and len(read_traces(tmp_path)) == count - 1


def test_a_trace_that_is_one_sample_short_is_not_shown(finished, tmp_path, rng):
    lines = (finished / RUNS).read_bytes().splitlines()
    place = next(i for i, line in enumerate(lines) if b'"trace"' in line)
    run = json.loads(unsealed(lines[place]))
    curve = rng.choice(list(run["trace"]["channels"].values()))
    curve[rng.choice(list(curve))].pop()
    lines[place] = sealed(run).strip()
    (tmp_path / RUNS).write_bytes(b"\n".join([*lines, b""]))
    assert len(read_traces(tmp_path)) == len(read_traces(finished)) - 1
