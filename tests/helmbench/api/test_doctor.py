"""The doctor: every kind of fault of a machine is found, named, and told with what to do."""

import io
import json
import os
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import helmbench
from helmbench.api import doctor as room
from helmbench.cli import status_of
from helmbench.models import cache


def found(check):
    """Findings of one check by what they are about."""
    return {one.what: one for one in room._guarded(check)}


def test_a_sound_machine_is_told_so(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=5e10))
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    health = helmbench.doctor()
    assert health.status != "fault" and {"python", "packages", "compiled code", "cache", "threads"} <= {
        one.what for one in health.findings
    }
    assert all(one.todo for one in health.findings if one.status != "ok")
    assert status_of(["doctor", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [one["what"] for one in told["findings"]] == [one.what for one in health.findings]
    assert health.findings[0].told in health.summary() and health.findings[0].told in health._repr_html_()


def test_a_fault_is_exit_status_one(capsys, monkeypatch, tmp_path):
    monkeypatch.setattr(
        room, "_compiled", lambda: iter([room.HealthFinding("compiled code", "fault", "wrong", "delete it")])
    )
    assert status_of(["doctor", "--quiet"]) == 1
    assert capsys.readouterr() == ("", "compiled code: wrong; delete it\n")


def test_old_and_missing_packages(monkeypatch):
    needed = ["numpy>=999.1", "no-such-package>=2.0", "scipy>=1.0", 'torch>=999; extra == "gp"']
    monkeypatch.setattr(room, "requires", lambda _: needed)
    told = [one.told for one in room._guarded(room._packages)]
    assert len(told) == 2 and "999.1 is needed" in told[0] and "no-such-package is missing" in told[1]


@pytest.mark.parametrize(
    ("own", "least", "old"), [("2.0.1", "2.0", False), ("1.9.9", "2.0", True), ("10.0", "9.1", False)]
)
def test_versions_are_compared_as_numbers(own, least, old):
    assert (room._numbers(own) < room._numbers(least)) is old


def test_damaged_files_of_the_cache(monkeypatch, tmp_path):
    cache.store(tmp_path / "good.kernel", b"x = 1")
    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path))
    assert found(room._cache)["cache"].status == "ok"
    (tmp_path / "bad.kernel").write_bytes(b"half a file")
    assert (found(room._cache)["cache"].status, "1 damaged" in found(room._cache)["cache"].told) == ("warning", True)


def test_data_that_are_not_there_or_incomplete(monkeypatch, tmp_path):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    assert {one.status for one in found(room._data).values()} == {"ok"}
    monkeypatch.setattr("helmbench.datasets.measured.missing_files", lambda name: [Path("one")])
    lost = found(room._data)["data kvlcc2-hsva"]
    assert lost.status == "warning" and lost.todo == "helmbench fetch kvlcc2-hsva"
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path / "nowhere"))
    assert found(room._data)["data"].status == "fault"


def test_threads(monkeypatch):
    monkeypatch.setattr("threadpoolctl.threadpool_info", lambda: [{"internal_api": "openblas", "num_threads": 64}])
    monkeypatch.setattr("helmbench.bench.environment.cpu_count", lambda: 2)
    assert found(room._threads)["threads"].status == "warning"
    monkeypatch.setenv("OMP_NUM_THREADS", "many")
    assert found(room._threads)["threads"].status == "fault"


@pytest.mark.parametrize(("free", "status"), [(5e10, "ok"), (1e9, "warning"), (1e6, "fault")])
def test_disks(monkeypatch, free, status):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=free))
    assert {one.status for one in found(room._disk).values()} == {status}


def test_folders_that_cannot_be_written(monkeypatch, tmp_path):
    def refuse(dir):
        if Path(dir) == tmp_path:
            raise OSError(30, os.strerror(30))
        return io.BytesIO()

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(room.tempfile, "TemporaryFile", refuse)
    told = found(room._permissions)
    assert told["writing, working folder"].status == "warning" and told["writing, temporary files"].status == "ok"


def test_a_terminal_without_the_characters(monkeypatch):
    monkeypatch.setattr(sys, "stdout", SimpleNamespace(encoding="ascii"))
    assert found(room._output)["terminal"].todo == "set PYTHONUTF8=1"


def test_a_check_that_breaks_is_a_fault(monkeypatch):
    def broken():
        raise ImportError("libblas.so.3")
        yield

    (one,) = found(broken).values()
    assert one.status == "fault" and "libblas" in one.told and one.todo
    monkeypatch.setattr("helmbench.methods.registry.methods", lambda: (_ for _ in ()).throw(
        helmbench.BadInput("method plug-in cannot be loaded", file="mine", hint="remove it")))  # fmt: skip
    (one,) = found(room._plugins).values()
    assert (one.status, one.todo) == ("fault", "remove it") and "plug-in" in one.told
