"""Compressed files that hold no log, are too large, damaged or cut."""

import gzip
import zipfile

import pytest

from helmbench.datasets.importing import sources
from helmbench.datasets.importing.sources import MOST_MEMBERS, read_raw
from helmbench.models.errors import BadInput


def _archive(path, members, **options):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content, **options)
    return path.read_bytes()


def _encrypted(data):
    """An archive whose members are marked as encrypted."""
    for mark, at in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        start = data.index(mark) + at
        data = data[:start] + bytes([data[start] | 1]) + data[start + 1 :]
    return data


ROWS = "time_s,heading_deg,rudder_deg\n" + "\n".join(f"{i},{i % 360},{i % 7}" for i in range(50))


@pytest.mark.parametrize(
    "name, written, said",
    [
        ("a tar archive", lambda path: gzip.compress(bytes(257) + b"ustar" + bytes(250)), "a compressed tar archive"),
        ("damaged gzip", lambda path: b"\x1f\x8b\x08" + bytes(range(60)), "a damaged file of gzip"),
        ("a cut archive", lambda path: _archive(path, {"a.csv": ROWS})[:150], "a damaged archive"),
        ("an encrypted archive", lambda path: _encrypted(_archive(path, {"a.csv": ROWS})), "an encrypted archive"),
        ("an empty archive", lambda path: _archive(path, {"__MACOSX/a.csv": ROWS}), "an archive without files"),
        ("an archive of texts", lambda path: _archive(path, {"a.txt": "hello", "b.txt": "you"}), "no rows of numbers"),
        ("an archive in an archive", lambda path: _archive(path, {"a.zip": _archive(path, {"a.csv": ROWS})}), "within"),
        ("many files", lambda path: _archive(path, {f"{i}.csv": "" for i in range(MOST_MEMBERS + 1)}), "201 files"),
        ("a document", lambda path: _archive(path, {"mimetype": "a", "content.xml": "<a/>"}), "of an office program"),
    ],
)  # fmt: skip
def test_a_compressed_file_that_holds_no_log_ends_in_one_line(tmp_path, name, written, said):
    path = tmp_path / "log.zip"
    path.write_bytes(written(path))
    with pytest.raises(BadInput, match=said):
        read_raw(path)


def test_a_compressed_file_beyond_the_limit_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(sources, "MOST_BYTES", 1000)
    for data in (gzip.compress(bytes(2000)), _archive(tmp_path / "a.zip", {"a.csv": bytes(600), "b.csv": bytes(600)})):
        (tmp_path / "log").write_bytes(data)
        with pytest.raises(BadInput, match="a compressed file of more than"):
            read_raw(tmp_path / "log")


def test_no_member_leads_out_of_its_archive(tmp_path):
    path = tmp_path / "log.zip"
    _archive(path, {"x/../../a.csv": ROWS, "/b.csv": ROWS, "c\\..\\d.csv": ROWS})
    assert [table.file for table in read_raw(path)] == ["x/a.csv", "b.csv", "c/d.csv"]


def test_of_a_cut_file_of_gzip_the_begin_is_read(tmp_path):
    whole = gzip.compress(ROWS.encode() * 40)
    (tmp_path / "run.csv.gz").write_bytes(whole[: len(whole) // 2])
    (table,) = read_raw(tmp_path / "run.csv.gz")
    assert table.file == "run.csv" and table.n >= 10
