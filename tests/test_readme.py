"""The README's Python example runs as it stands, and its table of names is complete."""

import re
import tomllib
from pathlib import Path

import pytest

import helmbench

from .support.inline_pool import without_workers

ROOT = Path(__file__).resolve().parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder and names after the example has run in an empty folder."""
    (code,) = re.findall(r"^```python\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)
    folder, names = tmp_path_factory.mktemp("readme"), {}
    with pytest.MonkeyPatch.context() as patch, without_workers():
        patch.chdir(folder)
        exec(compile(code, "README.md", "exec"), names)
    return folder, names


def test_the_example_writes_what_it_says(ran):
    folder, _ = ran
    assert {path.name for path in folder.iterdir()} == {"train.png", "check.png", "diagnosis", "out"}
    assert (folder / "diagnosis" / "diagnosis.html").stat().st_size > 10_000


def test_the_example_gives_what_it_says(ran):
    _, names = ran
    told = re.search(r"<Record 'kvlcc2-l7 zigzag:20/20': [^;]*;", TEXT)
    assert told is not None and repr(names["train"]).startswith(told.group())
    assert names["again"].to_dataframe().equals(names["frame"]) and names["again"].name == "again"
    assert list(names["estimate"].to_dataframe().columns) == ["unit", "estimate", "stderr"]
    assert names["turn"].n == 401
    (finding,) = names["found"].causes
    sizes = {size.parameter: size for size in finding.sizes}
    assert (names["found"].verdict, finding.cause) == ("named", "current")
    assert abs(sizes["speed"].value - 0.1) < 0.005 and sizes["speed"].low < sizes["speed"].high
    assert names["results"].complete


def test_the_five_minutes_are_those_of_the_tour():
    """The commands of the tour are run by the test of the documentation."""
    block, cell = (re.compile(rf"^```{head}\n(.*?)^```", re.DOTALL | re.MULTILINE)
                   for head in ("bash", r"\{code-cell\}\n%%bash"))  # fmt: skip
    tour = (ROOT / "docs" / "tour.md").read_text(encoding="utf-8")
    assert block.findall(TEXT) == ["".join(cell.findall(tour))]


def test_links_within_the_repository_lead_to_files():
    links = re.findall(r"\]\(([^)#:]+)\)", TEXT)
    assert len(links) > 10 and [link for link in links if not (ROOT / link).exists()] == []


def test_every_public_name_is_in_the_table():
    section = TEXT[TEXT.index("## From Python") : TEXT.index("## Command line")]
    named = set(re.findall(r"\w+", section))
    beside = {"Reproduction", "RudderSignWarning", "SuiteResults", "__version__", "rudder_sign_doubt", "with_tuner"}
    assert set(helmbench.__all__) - named == beside


def test_the_layout_names_every_folder_that_is_installed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    rooms = set(project["tool"]["setuptools"]["package-dir"].values())
    section = TEXT[TEXT.index("## Repository layout") : TEXT.index("## Measured data")]
    assert set(re.findall(r"^    (\w+)/", section, re.MULTILINE)) == rooms | {"helmbench", "docs", "tests", "reports"}
