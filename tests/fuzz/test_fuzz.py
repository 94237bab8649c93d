"""Inputs that a reader once failed on, and some new ones: each ends in a value or in one line, and runs no code."""

from dataclasses import replace

import pytest

from .readers import readers
from .run import CORPUS, fuzz
from .worker import Worker

READERS = (
    "record",
    "sidecar",
    "model",
    "suite",
    "vessel",
    "prior",
    "bounds",
    "fixed",
    "journal",
    "manifest",
    "mapping",
)
NEW_INPUTS = 60


@pytest.mark.parametrize("name", READERS)
def test_files_that_a_reader_failed_on_are_refused(name, tmp_path):
    reader = readers(tmp_path)[name]
    worker = Worker(reader, tmp_path / "folder")
    try:
        assert [worker.outcome(seed).said for seed in reader.seeds] == [""] * len(reader.seeds)
        found = {path.name: worker.outcome(path.read_bytes()) for path in sorted((CORPUS / name).glob("*"))}
        assert {place: outcome for place, outcome in found.items() if outcome.failed} == {}
    finally:
        worker.close()


@pytest.mark.parametrize("name", READERS)
def test_new_inputs_are_read_or_refused(name, tmp_path, seed, monkeypatch):
    monkeypatch.setitem(fuzz.__globals__, "CORPUS", tmp_path / "corpus")
    counts = fuzz(name, readers(tmp_path)[name], 20.0, seed, tmp_path / "folder", NEW_INPUTS)
    assert {state: counts[state] for state in ("crash", "hang", "memory", "code")} == dict.fromkeys(
        ("crash", "hang", "memory", "code"), 0
    )


def test_every_reader_is_tested(tmp_path):
    assert tuple(readers(tmp_path)) == READERS


def test_the_watch_sees_code_crashes_and_memory(tmp_path):
    reader = replace(readers(tmp_path)["prior"], seeds=(b"ok",))

    def read(path):
        text = path.read_text()
        if text == "code":
            exec(compile((path.parent / "trap.py").read_text(), str(path.parent / "trap.py"), "exec"), {})
        if text == "memory":
            bytearray(3 * 2**30)
        if text == "crash":
            raise KeyError("x")

    worker = Worker(replace(reader, read=read), tmp_path / "folder")
    try:
        for text in ("code", "memory", "crash"):
            assert worker.outcome(text.encode()).state == text
        assert worker.outcome(b"fine").state == "accepted"
    finally:
        worker.close()
