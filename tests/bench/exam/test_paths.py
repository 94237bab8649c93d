"""What an exam or a submission names is read in its folder only, and nothing else is told of."""

import json
import os
import stat

import pytest

from helmbench.bench.exam import folder as exams
from helmbench.bench.exam.scores import score
from helmbench.cli import status_of
from helmbench.models.errors import BadInput
from helmbench.models.folders import path_within, write_atomic

from .entrants import submission
from .handmade import handmade

SECRET = "root-secret"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    return handmade(tmp_path_factory.mktemp("handmade"))


@pytest.fixture
def outside(tmp_path):
    """A file that is nobody's to read, beside the folder of the submission."""
    path = tmp_path / "elsewhere" / "secret.csv"
    path.parent.mkdir()
    path.write_text(f"{SECRET}:x:0:0\n{SECRET},1\n")
    return path


NAMES = {
    "absolute": "{}",
    "two slashes": "/{}",
    "three slashes": "//{}",
    "dots": "../elsewhere/secret.csv",
    "dots behind a folder": "own/../../elsewhere/secret.csv",
    "dots and blanks": ".. /elsewhere/secret.csv",
    "here": "./.",
    "backslashes": "..\\elsewhere\\secret.csv",
    "drive": "C:{}",
    "drive of backslashes": "C:\\secret.csv",
    "share": "\\\\server\\share\\secret.csv",
    "stream": "secret.csv:stream",
    "slash at the end": "secret.csv/",
    "mark of direction": "secret\u202e.csv",
}


@pytest.mark.parametrize("key", ["motion", "model"])
@pytest.mark.parametrize("case", NAMES)
def test_a_name_outside_the_folder_is_refused(made, tmp_path, outside, case, key):
    name = NAMES[case].format(outside)
    refused(made, tmp_path, name, key, "is outside its folder")


def refused(made, tmp_path, name, key, told):
    exam, _, file = made
    answer = {"model": name} if key == "model" else {"motion": {"held_out-1": name}}
    path = submission(tmp_path / "own", exam, worlds={"world-1": answer})
    with pytest.raises(BadInput, match=told) as found:
        score(exam.folder, file, [path])
    assert SECRET not in str(found.value) and "\n" not in str(found.value)


@pytest.mark.parametrize("key", ["motion", "model"])
@pytest.mark.parametrize("name", ["secret.csv", "folder/secret.csv", "deep/folder/secret.csv"])
def test_a_link_to_a_file_or_a_folder_is_refused(made, tmp_path, outside, name, key):
    place = tmp_path / "own" / "deep"
    place.mkdir(parents=True)
    (tmp_path / "own" / "secret.csv").symlink_to(outside)
    (tmp_path / "own" / "folder").symlink_to(outside.parent)
    (place / "folder").symlink_to(outside.parent)
    refused(made, tmp_path, name, key, "is reached by a link")


@pytest.mark.parametrize("key", ["motion", "model"])
def test_what_is_no_file_is_refused(made, tmp_path, key):
    (tmp_path / "own").mkdir()
    os.mkfifo(tmp_path / "own" / "pipe.csv")
    (tmp_path / "own" / "folder.csv").mkdir()
    refused(made, tmp_path, "pipe.csv", key, "is a pipe or a device, not a file")
    refused(made, tmp_path, "folder.csv", key, "is a directory, not a file")
    refused(made, tmp_path, "none.csv", key, "no such file")
    refused(made, tmp_path, "none.csv/x", key, "no such file")
    refused(made, tmp_path, "/".join("a" * 60), key, "no such file")


@pytest.mark.parametrize("key", ["motion", "model"])
def test_a_file_that_is_too_large_is_not_read(made, tmp_path, key):
    (tmp_path / "own").mkdir()
    with (tmp_path / "own" / "large.csv").open("wb") as file:
        file.truncate(2**33)
    refused(made, tmp_path, "large.csv", key, "KiB, the most that is read")


def test_a_name_in_the_folder_is_taken_as_it_is(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    assert path_within(tmp_path / "link", "a/..b.csv", "x") == tmp_path / "link" / "a" / "..b.csv"
    with pytest.raises(BadInput, match="cannot be used"):
        path_within(tmp_path, 5000 * "a", "x")


def test_files_of_an_exam_are_in_its_folder(made, tmp_path, outside):
    exam, _, file = made
    copy = tmp_path / "exam"
    copy.mkdir()
    (copy / exams.CAUSES).write_bytes((exam.folder / exams.CAUSES).read_bytes())
    manifest = json.loads((exam.folder / exams.MANIFEST).read_text("utf-8"))
    for name in (str(outside), f"/{outside}", "../elsewhere/secret.csv"):
        (copy / exams.MANIFEST).write_text(json.dumps(manifest | {"files": {name: "0" * 64}}), "utf-8")
        with pytest.raises(BadInput, match="is outside its folder"):
            exams.Exam(copy).check()
    for name in manifest["worlds"]:
        (copy / name).symlink_to(exam.folder / name)
    (copy / exams.MANIFEST).write_text(json.dumps(manifest), "utf-8")
    with pytest.raises(BadInput, match="is reached by a link"):
        score(copy, file, [submission(tmp_path / "own", exam)])


def test_the_key_in_the_folder_that_is_handed_out_is_refused(made, tmp_path):
    exam, _, file = made
    inside = exam.folder / "key.json"
    inside.write_bytes(file.read_bytes())
    try:
        with pytest.raises(BadInput, match=r"key\.json: lies in the folder that is handed out"):
            score(exam.folder, inside, [submission(tmp_path / "own", exam)])
    finally:
        inside.unlink()


@pytest.mark.parametrize("umask", [0o000, 0o022])
def test_a_private_file_is_so_from_its_first_byte(tmp_path, monkeypatch, umask):
    modes = []
    replace = os.replace
    monkeypatch.setattr(os, "replace", lambda one, two: (modes.append(os.stat(one).st_mode), replace(one, two)))
    before = os.umask(umask)
    try:
        write_atomic(tmp_path / "key", b"x", 0o600)
    finally:
        os.umask(before)
    assert [stat.S_IMODE(mode) for mode in (*modes, (tmp_path / "key").stat().st_mode)] == [0o600, 0o600]


def test_the_key_of_an_exam_is_for_its_maker_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = os.umask(0)
    try:
        assert status_of(["exam", "make", "exam", "--key", "key.json", "--worlds", "1", "--vessel", "response-1"]) == 0
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "key.json").stat().st_mode) == 0o600
