"""Binary logs are read in a process of their own: damaged ones and bombs end in one line, and nothing else ends."""

import io
import pickle
import struct
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import openpyxl
import pytest
import scipy.io

from helmbench.datasets.importing import contained
from helmbench.datasets.importing.contained import read_contained
from helmbench.models.errors import BadInput

SERIES = {"time": 0.5 * np.arange(40.0), "rudder": np.sin(np.arange(40.0)), "heading": np.arange(40.0)}

MIXED = np.array([[1, "x"]], dtype=object)
CRASHES = (((632, 9), (144, 5)), ((800, 255),), ((278, 148), (692, 5)), ((692, 3), (148, 16), (729, 17)))
"""Bytes of a MAT file, place and value, that a fuzzer changed."""


@pytest.fixture(scope="module")
def workbook():
    book, file = openpyxl.Workbook(), io.BytesIO()
    book.active.append(list(SERIES))
    for row in zip(*SERIES.values(), strict=True):
        book.active.append([float(value) for value in row])
    book.save(file)
    return file.getvalue()


@pytest.fixture(scope="module")
def mat():
    file = io.BytesIO()
    scipy.io.savemat(file, SERIES)
    return file.getvalue()


def with_sheet(workbook, change):
    """The workbook with another text of its sheet."""
    out, parts = io.BytesIO(), zipfile.ZipFile(io.BytesIO(workbook))
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as written:
        for name in parts.namelist():
            content = parts.read(name)
            written.writestr(name, change(content) if name.endswith("sheet1.xml") else content)
    return out.getvalue()


def zeros(count):
    """A MAT file of some kilobytes that holds so many zeros."""
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    inner = struct.pack("<IIIIIIii", 6, 8, 6, 0, 5, 8, count, 1) + struct.pack("<HH4s", 1, 1, b"t")
    squeeze = zlib.compressobj(9)
    parts = [squeeze.compress(struct.pack("<II", 14, len(inner) + 8 + 8 * count) + inner)]
    parts += [squeeze.compress(struct.pack("<II", 9, 8 * count))]
    parts += [squeeze.compress(bytes(2**20)) for _ in range(8 * count // 2**20)] + [squeeze.flush()]
    packed = b"".join(parts)
    return head + struct.pack("<II", 15, len(packed)) + packed


def test_workbooks_and_mat_files_are_read_as_they_are(workbook, mat):
    for kind, data in (("a workbook", workbook), ("a MAT file", mat)):
        (table,) = read_contained(kind, data, Path("log"))
        assert [column.name for column in table.columns] == list(SERIES)
        np.testing.assert_allclose(table.columns[1].numbers, SERIES["rudder"], rtol=1e-14, atol=0.0)


@pytest.mark.nightly
def test_damaged_files_end_in_one_line(workbook, mat, rng):
    parts = [b"<sheetData>", b'r="A2"', b"<v>", b'spans="', b"</row>"]
    broken = [with_sheet(workbook, lambda text, part=part: text.replace(part, b'"\xff<', 3)) for part in parts]
    cut = [data[: int(rng.integers(200, len(data)))] for data in (workbook, mat)]
    told = []
    for kind, data in [*(("a workbook", data) for data in (*broken, cut[0])), ("a MAT file", cut[1])]:
        try:
            assert read_contained(kind, data, Path("log"))
        except BadInput as error:
            told.append(str(error))
    assert len(told) >= 5 and all(text.startswith("log: ") and "\n" not in text for text in told)


@pytest.mark.nightly
def test_a_bomb_is_told_within_its_limits(workbook, monkeypatch):
    monkeypatch.setattr(contained, "MOST_BYTES", 700 * 2**20)
    with pytest.raises(BadInput, match=r"takes more than 0\.68 GiB of memory to read"):
        read_contained("a MAT file", zeros(2**27), Path("log"))
    monkeypatch.setattr(contained, "LEAST_S", 2.0)
    far = with_sheet(workbook, lambda text: text.replace(b'r="41"', b'r="1048576"').replace(b'C41"', b'XFD1048576"'))
    with pytest.raises(BadInput, match="takes more than 2 s to read"):
        read_contained("a workbook", far, Path("log"))


@pytest.mark.parametrize("edits", CRASHES)
def test_mat_files_that_crash_scipy_end_in_one_line(edits):
    """Each of these ends the process that reads it with a segmentation fault (SciPy 1.17)."""
    file = io.BytesIO()
    scipy.io.savemat(file, {"time": SERIES["time"], "s": {"a": np.arange(3.0), "b": "text"}, "c": MIXED})
    data = bytearray(file.getvalue())
    for place, value in edits:
        data[place] = value
    with pytest.raises(BadInput, match="not a MAT file that can be read"):
        read_contained("a MAT file", bytes(data), Path("crash.mat"))


@pytest.mark.parametrize("status", [-11, -6, 1])
def test_a_reader_that_crashes_ends_in_one_line(monkeypatch, status):
    monkeypatch.setattr(contained.subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=status))
    with pytest.raises(BadInput, match=r"log: not a MAT file that can be read .its reader ended by it"):
        read_contained("a MAT file", b"", Path("log"))


class Code:
    def __reduce__(self):
        return open, ("canary", "w")


def test_what_a_reader_answers_never_runs_code(monkeypatch, tmp_path):
    done = SimpleNamespace(returncode=0, stdout=pickle.dumps([Code()]))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(contained.subprocess, "run", lambda *_, **__: done)
    with pytest.raises(pickle.UnpicklingError):
        read_contained("a MAT file", b"", Path("log"))
    assert not list(tmp_path.iterdir())


def test_no_module_of_the_working_folder_is_run(workbook, monkeypatch, tmp_path):
    for name in ("openpyxl", "numpy", "pickle"):
        (tmp_path / f"{name}.py").write_text("open('canary', 'w')")
    monkeypatch.chdir(tmp_path)
    assert read_contained("a workbook", workbook, Path("log")) and not (tmp_path / "canary").exists()
