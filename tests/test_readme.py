"""The README: its blocks run as they stand, in order, and give what it says; its links lead to files; it is short."""

import csv
import re
import tomllib
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from .support.blocks import blocks, run_block
from .support.inline_pool import without_workers

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
TEXT = README.read_text(encoding="utf-8")


def builds_an_environment(block: str) -> bool:
    """Such blocks are run by tests/nightly/test_readme_roads.py."""
    return ".venv/bin/activate" in block


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """(folder, what was printed) after all blocks that build no environment have run in an empty folder."""
    folder, names = tmp_path_factory.mktemp("readme"), {}
    with pytest.MonkeyPatch.context() as patch, without_workers():
        patch.chdir(folder)
        with redirect_stdout(StringIO()) as printed:
            for language, text in blocks(README):
                if not builds_an_environment(text):
                    run_block(language, text, names)
    return folder, printed.getvalue()


def test_the_blocks_write_what_is_said(ran):
    folder, _ = ran
    assert (folder / "ship" / "model.json").exists() and (folder / "cause" / "extended_model.json").exists()
    assert all((folder / page).stat().st_size > 10_000 for page in ("ship/identification.html", "cause/diagnosis.html"))
    with (folder / "out" / "mine" / "leaderboard.csv").open(encoding="utf-8") as file:
        assert {row["method"] for row in csv.DictReader(file)} == {"mine", "ls"}


def test_the_commands_print_what_is_shown(ran):
    _, printed = ran
    shown = [
        line
        for block in re.findall(r"^```text\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
        for line in block.splitlines()
    ]
    assert len(shown) == 4 and [line for line in shown if line not in printed] == []


def test_every_road_to_an_environment_activates_it_before_helmbench_is_used():
    before, roads = [], 0
    for _, text in blocks(README):
        if builds_an_environment(text):
            before, roads = text.partition(".venv/bin/activate")[0].splitlines(), roads + 1
            assert not [line for line in before if line.startswith("helmbench")]
        elif not roads:
            assert "helmbench" not in text
    assert roads == 2


def test_links_within_the_repository_lead_to_files():
    links = re.findall(r"\]\(([^)#:]+)\)", TEXT)
    assert len(links) > 10 and [link for link in links if not (ROOT / link).exists()] == []


def test_no_block_writes_into_a_folder_of_the_repository():
    """The reader may well be in the clone."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rooms = {*project["tool"]["setuptools"]["package-dir"].values(), "helmbench", "docs", "tests", "reports"}
    written = set(re.findall(r" -o (\w+)", TEXT))
    assert len(written) > 5 and not written & rooms


def test_readme_and_contributing_are_short():
    sizes = {name: (ROOT / name).stat().st_size for name in ("README.md", "CONTRIBUTING.md")}
    assert sizes["README.md"] <= 9_000 and sizes["CONTRIBUTING.md"] <= 6_000, sizes
