"""Inputs that a reader once failed on, and some new ones: each ends in a value or in one line, and runs no code."""

import os
import random
import signal
from dataclasses import replace

import pytest

from ...seeds import SHIFT
from .mutate import mutated
from .readers import RAW, readers
from .run import CORPUS
from .worker import ReaderProcess

READERS = (
    *("record", "parquet", "sidecar", "model", "suite", "vessel", "prior", "bounds", "fixed"),
    *("journal", "traces", "manifest", "strings", "api", "mapping", "submission", "problems", "indices", "table", *RAW),
)
NEW_INPUTS, NEW_LOGS = (40, 5) if SHIFT else (6, 1)
"""Inputs of a reader, and of a raw log, which is drafted whole: more where they are drawn; `make fuzz` tries many."""


@pytest.fixture(scope="module")
def every_reader(tmp_path_factory):
    """Name -> reader."""
    return readers(tmp_path_factory.mktemp("readers"))


@pytest.mark.parametrize("name", READERS)
def test_what_failed_once_and_new_inputs_are_read_or_refused(name, every_reader, tmp_path, seed):
    reader, rng = every_reader[name], random.Random(seed)
    kept = [path.read_bytes() for path in sorted((CORPUS / name).glob("*"))]
    new = [
        mutated(rng.choice(reader.seeds), rng.choice(reader.seeds), rng)
        for _ in range(NEW_LOGS if name in RAW else NEW_INPUTS)
    ]
    worker = ReaderProcess(reader, tmp_path / "folder")
    try:
        assert [worker.outcome(valid).state for valid in reader.seeds] == ["accepted"] * len(reader.seeds)
        assert [(data, found) for data in (*kept, *new) if (found := worker.outcome(data)).failed] == []
    finally:
        worker.close()


def test_every_reader_is_tested(every_reader):
    assert tuple(every_reader) == READERS


def test_the_watch_sees_code_crashes_and_memory(every_reader, tmp_path):
    reader = replace(every_reader["prior"], seeds=(b"ok",))

    def read(path):
        text = path.read_text()
        if text == "code":
            exec(compile((path.parent / "trap.py").read_text(), str(path.parent / "trap.py"), "exec"), {})
        if text == "memory":
            bytearray(3 * 2**30)
        if text == "crash":
            raise KeyError("x")
        if text == "end":
            os.kill(os.getpid(), signal.SIGSEGV)

    worker = ReaderProcess(replace(reader, read=read), tmp_path / "folder")
    try:
        for text in ("code", "memory", "crash"):
            assert worker.outcome(text.encode()).state == text
        assert worker.outcome(b"fine").state == "accepted"
        assert worker.outcome(b"end").state == "crash"
        worker.reader = replace(worker.reader, whole=lambda path: path.read_bytes())
        assert worker.outcome(b"end").state == "accepted"
    finally:
        worker.close()
