"""Both roads of the README, with make and without, block by block in a fresh clone with a fresh environment.

A road is one session of a shell that stops at the first command that fails.  It needs a package index or a mirror, and
minutes.  Of `make test` the tests are narrowed to one: `make test-all` runs all of them anyway.
"""

import faulthandler
import os
import re
import subprocess
from pathlib import Path

import pytest

from ..support.blocks import blocks, file_of

ROOT = Path(__file__).resolve().parents[2]
ROADS = {"with make": "make bench", "without make": "python3 -m venv"}
"""Road -> how its block begins."""
LONGEST_S = 3600


def as_shell(language: str, text: str) -> str:
    """A block as lines of a shell script."""
    if language == "bash":
        return text
    target = f"> {name}" if (name := file_of(text)) else "| python"
    return f"cat <<'END' {target}\n{text}END\n"


def script_of(road: str) -> str:
    """The blocks of the README with one of its roads."""
    lines = ["set -eu"]
    for language, text in blocks(ROOT / "README.md"):
        other = [begin for name, begin in ROADS.items() if name != road and text.startswith(begin)]
        if not other:
            lines += [f"echo '=== {len(lines)}: {text.splitlines()[0]}'".replace("`", ""), as_shell(language, text)]
    return "\n".join(lines)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone of what is committed."""
    subprocess.run(["git", "clone", "--quiet", ROOT, tmp_path / "helmbench"], check=True)
    return tmp_path / "helmbench"


@pytest.mark.parametrize("road", ROADS)
def test_the_road_runs_in_a_fresh_clone(road: str, clone: Path) -> None:
    hidden = ("PYTHON", "VIRTUAL_ENV", "PYTEST", "HELMBENCH_SEED")
    fresh = {name: value for name, value in os.environ.items() if not name.startswith(hidden)}
    fresh |= {"PYTEST_ADDOPTS": "tests/test_readme.py -k links", "HELMBENCH_CACHE": str(clone.parent / "cache")}
    faulthandler.cancel_dump_traceback_later()  # the limit of a test that builds no environment
    session = ["bash", "-c", script_of(road)]
    done = subprocess.run(session, cwd=clone, env=fresh, capture_output=True, text=True, timeout=LONGEST_S)
    assert done.returncode == 0, f"{done.stdout[-4000:]}\n{done.stderr[-4000:]}"
    assert (clone / ".venv" / "bin" / "helmbench").exists()
    assert {
        "out/quick/leaderboard.html",
        "ship/model.json",
        "cause/diagnosis.html",
        "out/mine/leaderboard.html",
    } <= {str(path.relative_to(clone)) for folder in ("out", "ship", "cause") for path in (clone / folder).rglob("*")}
    assert re.search(r"^Named: current\.$", done.stdout, re.MULTILINE)
