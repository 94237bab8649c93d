"""The cache of compiled code: private, checked before use, built again when damaged, and by one process at a time."""

import errno
import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from helmbench.models import cache
from helmbench.models.compilation import njit
from helmbench.models.errors import EnvironmentFault

from ..nightly_marks import nightly_but

LOAD = """
import sys
import numpy as np
from helmbench.models.kernels import load, cache_folder
rhs, rate = load('nomoto-1').rhs, np.empty(2)
rhs(np.array([0.1, 0.2]), np.array([0.3]), np.array([0.5, 0.25]), rate)
print('sympy' in sys.modules, sum(rhs.stats.cache_misses.values()), rate.tolist(), cache_folder(), sep='|')
"""


def start(code=LOAD, **environment):
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(code=LOAD, **environment):
    process = start(code, **environment)
    out, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    return out.strip().split("|"), said


@pytest.fixture(scope="module")
def warm(tmp_path_factory):
    """A cache with the kernels of one family, and what a start with it prints."""
    folder = tmp_path_factory.mktemp("cache")
    (sympy, misses, *printed), _ = run(HELMBENCH_CACHE=str(folder))
    assert (sympy, misses) == ("True", "1")
    return folder, printed


def test_a_warm_start_compiles_nothing_and_never_imports_sympy(warm):
    folder, printed = warm
    found, _ = run(HELMBENCH_CACHE=str(folder))
    assert found == ["False", "0", *printed]
    assert printed[1] == str(folder / "kernels")


LIST = """
import sys
from helmbench.models.model import list_families
print(list_families(), 'sympy' in sys.modules, sep='|')
"""


@pytest.mark.nightly
def test_families_are_listed_without_sympy_once_their_titles_are_kept(tmp_path):
    (first, built), (then, again) = (run(LIST, HELMBENCH_CACHE=str(tmp_path))[0] for _ in range(2))
    assert first == then and "first-order Nomoto" in first and (built, again) == ("True", "False")
    (kept,) = (path for path in files_of(tmp_path) if path.name.startswith("catalogue"))
    kept.write_bytes(kept.read_bytes()[:-3])
    assert run(LIST, HELMBENCH_CACHE=str(tmp_path))[0] == [first, "True"]


def files_of(folder):
    return [path for path in folder.rglob("*") if path.is_file() and path.suffix != ".lock"]


def damaged(path, rng):
    """Damage one file as a full disk, a bad disk, another program or another version does."""
    data, other = path.read_bytes(), rng.bytes(100)
    place = int(rng.integers(len(data)))
    flipped = data[:place] + bytes([data[place] ^ (1 << int(rng.integers(8)))]) + data[place + 1 :]
    foreign = hashlib.sha256(other).digest() + other
    kinds = (data[:place], b"", flipped, other, data + b"\0", bytes(len(data)), foreign, None)
    content = kinds[int(rng.integers(len(kinds)))]
    path.unlink() if content is None else path.write_bytes(content)


@pytest.mark.parametrize("draw", nightly_but(range(2)))
def test_damaged_files_are_built_again(warm, rng, draw):
    folder, printed = warm
    for path in files_of(folder):
        damaged(path, rng)
    (_, _, *found), _ = run(HELMBENCH_CACHE=str(folder))
    assert found == printed
    assert run(HELMBENCH_CACHE=str(folder))[0] == ["False", "0", *printed]


@pytest.mark.nightly
def test_of_two_processes_one_compiles_and_the_other_waits(tmp_path):
    both = [start(HELMBENCH_CACHE=str(tmp_path)) for _ in range(2)]
    printed = [process.communicate(timeout=120)[0].split("|") for process in both]
    assert sorted(misses for _, misses, *_ in printed) == ["0", "1"]
    assert printed[0][2] == printed[1][2]


def test_folders_are_closed_to_others(warm):
    folder, _ = warm
    assert {path.stat().st_mode & 0o777 for path in [folder / "kernels", *folder.glob("kernels/*/")]} == {0o700}


def test_the_folder_of_a_group_keeps_its_permissions_and_that_of_the_kernels_is_closed(tmp_path):
    (tmp_path / "kernels").mkdir()
    (tmp_path / "kernels").chmod(0o777)
    tmp_path.chmod(0o775)
    cache.private_folder(tmp_path)
    assert (tmp_path / "kernels").stat().st_mode & 0o777 == 0o700 and tmp_path.stat().st_mode & 0o777 == 0o775


def test_a_folder_of_another_user_is_refused(tmp_path, monkeypatch):
    cache.private_folder(tmp_path)
    monkeypatch.setattr(os, "geteuid", lambda: 4711)
    with pytest.raises(OSError, match="belongs to another user"):
        cache.private_folder(tmp_path)


def planted(path, how):
    """Put code that others may have written in the place of a file of the cache."""
    data = path.read_bytes()[cache.DIGEST_BYTES :] + b"\nopen('canary', 'w')"
    path.unlink()
    place = path if how != "link" else path.with_name("planted")
    cache.store(place, data)
    if how == "link":
        path.symlink_to(place)
    elif how == "open":
        path.chmod(0o622)
    elif how == "another user":
        os.chown(path, 4711, 4711)


@pytest.mark.parametrize("how", nightly_but(["link", "open", *(["another user"] if os.geteuid() == 0 else [])], "link"))
def test_code_that_another_user_can_have_planted_is_not_loaded(warm, tmp_path, how):
    shutil.copytree(warm[0], tmp_path / "cache")
    (tmp_path / "cache" / "kernels").chmod(0o777)
    for path in [*(tmp_path / "cache").rglob("*.kernel"), *(tmp_path / "cache").rglob("*.nbc")]:
        planted(path, how)
    (_, misses, *found), _ = run(HELMBENCH_CACHE=str(tmp_path / "cache"))
    assert int(misses) > 0 and found[:1] == warm[1][:1] and not list(tmp_path.rglob("canary"))


@pytest.mark.parametrize("linked", ["", "kernels"])
def test_a_link_is_refused(tmp_path, linked):
    (tmp_path / "else").mkdir()
    (tmp_path / "cache" if linked else tmp_path).mkdir(exist_ok=True)
    (tmp_path / "cache" / linked if linked else tmp_path / "cache").symlink_to(tmp_path / "else")
    with pytest.raises(OSError, match="is a link"):
        cache.private_folder(tmp_path / "cache")


@pytest.fixture
def without_home(tmp_path):
    """An environment whose user cache cannot be made, and the folder of its temporary files."""
    (tmp_path / "home").write_text("a file")
    (tmp_path / "tmp").mkdir()
    return {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": str(tmp_path / "home" / "cache"), "HELMBENCH_CACHE": ""}


@pytest.mark.nightly
def test_without_a_home_code_is_kept_in_a_new_private_folder_for_this_run(without_home, tmp_path):
    planted = tmp_path / "tmp" / f"helmbench-{os.getuid()}" / "kernels"
    planted.mkdir(parents=True)
    found, said = run(**without_home, TMPDIR=str(tmp_path / "tmp"))
    folder = Path(found[-1])
    assert folder.parent.parent == tmp_path / "tmp" and folder != planted
    assert "compiled code cannot be kept" in said and "HELMBENCH_CACHE" in said
    assert not folder.exists() and not list(planted.iterdir())


@pytest.mark.parametrize("named", [True, False])
def test_without_any_folder_a_command_ends_in_one_line_and_stores_no_failed_rows(without_home, tmp_path, named):
    blocked = tmp_path / "home"
    set_up = without_home | ({"HELMBENCH_CACHE": str(blocked)} if named else {"TMPDIR": str(blocked)})
    code = (
        "import sys, tempfile\n"
        "from helmbench.cli import status_of\n"
        f"tempfile.tempdir = None if {named} else {str(blocked)!r}\n"
        "words = 'run --suite quick --vessel response-1 --method ls --seeds 1 --jobs 1 -o'\n"
        "print(status_of([*words.split(), sys.argv[1]]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code, str(tmp_path / "out")],
        **{"env": {**os.environ, **set_up}, "capture_output": True, "text": True, "timeout": 120},
    )
    assert done.stdout == "2\n" and done.stderr.count("\n") == 1 and "compiled code" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_full_disk_leaves_compiled_code_in_memory_with_a_warning(monkeypatch, tmp_path):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    monkeypatch.setattr("helmbench.models.compilation.cache_folder", lambda: tmp_path)
    with pytest.warns(RuntimeWarning, match="compiled code is not kept .No space left"):
        assert njit("f8(f8)", cache=True)(lambda x: x + 1.0)(1.0) == 2.0
    assert not files_of(tmp_path)


def test_a_full_disk_ends_the_generation_of_code_in_one_line(monkeypatch, tmp_path):
    from helmbench.models import kernels

    monkeypatch.setattr(kernels, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(errno.ENOSPC, "No space left")))
    with pytest.raises(EnvironmentFault, match=r"No space left.*free some space"):
        kernels.Kernels("nomoto-1")


@pytest.mark.nightly
def test_a_change_of_a_called_function_compiles_its_callers_again(tmp_path):
    (tmp_path / "outer.py").write_text(
        "from helmbench.models.compilation import njit\nfrom inner import inner\n"
        "@njit('f8(f8)', cache=True)\ndef outer(x):\n    return inner(x)\n"
    )
    code = "from outer import outer; print(outer(1.0))"
    place = {"PYTHONPATH": str(tmp_path), "PYTHONDONTWRITEBYTECODE": "1", "HELMBENCH_CACHE": str(tmp_path / "cache")}
    for number in (1.0, 2.0):
        (tmp_path / "inner.py").write_text(
            "from helmbench.models.compilation import njit\n"
            f"@njit(inline='always')\ndef inner(x):\n    return {number}\n"
        )
        assert run(code, **place)[0] == [str(number)]
    assert {path.parent for path in tmp_path.rglob("*.nb[ci]")} == {tmp_path / "cache" / "kernels"}


def test_that_code_is_compiled_is_said_once_and_only_where_it_is(monkeypatch, tmp_path):
    def one_more(x):
        return x + 1.0

    monkeypatch.setattr("helmbench.models.compilation.cache_folder", lambda: tmp_path)
    said = []
    with cache.FIRST_USE.told_to(said.append):
        njit("f8(f8)", "f8(i8)", cache=True)(one_more)
    assert said == [cache.COMPILING]
    with cache.FIRST_USE.told_to(said.append):
        assert njit("f8(f8)", cache=True)(one_more)(1.0) == 2.0
    assert said == [cache.COMPILING]
