"""The documentation site builds without a warning, its commands and examples run, its pages are complete."""

import ast
import json
import re
import runpy
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest

import helmbench
from helmbench.bench.suites import load_suite
from helmbench.methods.registry import methods

from .nightly_marks import nightly_but
from .support.blocks import BLOCK, blocks, run_block

pytestmark = pytest.mark.usefixtures("in_this_process")
DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGES = sorted(p for p in DOCS.rglob("*.md") if not {"generated", "_build"} & set(p.relative_to(DOCS).parts))
GALLERY = sorted((DOCS / "gallery").glob("*.py"))
SLOW = ("tour", "compare-methods", "exam", "monte-carlo")
"""Pages that `make test` leaves to `make test-all`, as the tutorials."""
RUN = [p for p in PAGES if BLOCK.search(p.read_text(encoding="utf-8")) and p.stem != "extend"]
"""Pages whose blocks run in order; those of `extend` are files of this repository: tests/test_contributing.py."""


def names_the(cause: str) -> Callable[[Path, dict], None]:
    """The page's diagnosis names the cause that the page hides, and nothing else."""

    def check(folder: Path, _: dict) -> None:
        found = json.loads((folder / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
        assert [finding["cause"] for finding in found["causes"]] == [cause]

    return check


def gives_what_it_says(folder: Path, names: dict) -> None:
    """The page of what Python offers."""
    assert {path.name for path in folder.iterdir()} == {"train.png", "check.png", "diagnosis", "out"}
    assert (folder / "diagnosis" / "diagnosis.html").stat().st_size > 10_000
    assert repr(names["train"]).startswith("<Record 'kvlcc2-l7 zigzag:20/20': 601 samples, 0 to 120 s every 0.2 s;")
    assert names["again"].to_dataframe().equals(names["frame"]) and names["again"].name == "again"
    assert list(names["estimate"].to_dataframe().columns) == ["unit", "estimate", "stderr"]
    assert names["turn"].n == 401
    (finding,) = names["found"].causes
    sizes = {size.parameter: size for size in finding.sizes}
    assert (names["found"].verdict, finding.cause) == ("named", "current")
    assert abs(sizes["speed"].value - 0.1) < 0.005 and sizes["speed"].low < sizes["speed"].high
    assert names["results"].complete


def describes_the_moment(_: Path, names: dict) -> None:
    """The page of an effect that nobody knows: what it depends on, its size, what its term does to held-out runs."""
    found = names["found"]
    (force,) = found.remaining
    assert (found.verdict, force.axis, force.depends_on) == ("described", "N", ("heading",))
    sine = next(size for size in force.sizes if size.parameter.endswith("_sin"))
    assert abs(sine.value - 6e6) < 2.5 * (sine.high - sine.low) / 2.0 and sine.low > 5e6
    heading = [names[which].score("heading_rad").rmse for which in ("before", "after")]
    assert heading[1] < 0.1 * heading[0]


CHECKS: dict[str, Callable[[Path, dict], None]] = {
    "tour": names_the("current"),
    "diagnose": names_the("yaw_rate_bias"),
    "from-python": gives_what_it_says,
    "unknown-effect": describes_the_moment,
}
"""Page -> what must hold after its blocks have run in a folder, with the names of its Python."""


@pytest.mark.parametrize(
    "page",
    nightly_but(RUN, *(p for p in RUN if p.parent.name != "tutorials" and p.stem not in SLOW)),
    ids=lambda page: page.relative_to(DOCS).as_posix(),
)
def test_the_examples_of_a_page_run_in_an_empty_folder(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names: dict = {}
    for language, text in blocks(page):
        run_block(language, text, names)
    if page.stem in CHECKS:
        CHECKS[page.stem](tmp_path, names)


def test_the_example_suite_is_one(tmp_path):
    suite = next(text for language, text in blocks(DOCS / "how-to" / "compare-methods.md") if language == "yaml")
    (tmp_path / "mine.yaml").write_text(suite, encoding="utf-8")
    assert load_suite(str(tmp_path / "mine.yaml")).title == "two methods on one ship at two noise levels"


def test_links_within_the_repository_lead_to_pages():
    """Those to generated pages are followed when the site is built."""
    link = re.compile(r"\]\((?!https?:)([^)#\s]+)")
    links = [(page, target) for page in PAGES for target in link.findall(page.read_text(encoding="utf-8"))]
    own = [page.parent / target for page, target in links if "generated/" not in target]
    assert len(own) > 30
    assert [target for target in own if not target.exists()] == []


def test_the_mathematics_of_every_method_is_told():
    text = (DOCS / "mathematics" / "methods.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^### (\S+)$", text, re.MULTILINE)) == set(methods())


@pytest.mark.parametrize("page", ["calibration", "pieces"])
def test_docstrings_cite_every_equation(page):
    text = (DOCS / "mathematics" / f"{page}.md").read_text(encoding="utf-8")
    numbers = [int(n) for n in re.findall(r"\\tag\{(\d+)\}", text)]
    assert numbers == list(range(1, len(numbers) + 1))
    rooms = [DOCS.parent / room for room in ("diagnosis", "estimation")]
    code = "".join(p.read_text(encoding="utf-8") for room in rooms for p in sorted(room.rglob("*.py")))
    cited = re.findall(rf"[Ee]qs?\. ([\d, ]+) of docs/mathematics/{page}\.md", code)
    assert {int(n) for group in cited for n in group.split(",")} == set(numbers)


def test_the_reference_holds_every_public_name():
    text = (DOCS / "reference" / "api.md").read_text(encoding="utf-8")
    told = re.findall(r"^   (\w+)$", text, re.MULTILINE)
    assert sorted([*told, "__version__"]) == sorted(helmbench.__all__)


def test_every_gallery_script_has_a_title_text_a_figure_and_public_names_only():
    assert len(GALLERY) >= 20
    for path in GALLERY:
        text = path.read_text(encoding="utf-8")
        tree = ast.parse(text)
        title, line, empty, *told = (ast.get_docstring(tree) or "").splitlines()
        assert title and line == "=" * len(title) and not empty, path.name
        assert len(re.findall(r"[.?!](?= |$)", " ".join(told))) >= 2, path.name
        assert ".plot(" in text or "plt.subplots(" in text, path.name
        nodes = list(ast.walk(tree))
        imported = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
        imported |= {node.module for node in nodes if isinstance(node, ast.ImportFrom)}
        others = imported - {"helmbench", "matplotlib.pyplot", "numpy", "pandas"}
        assert "helmbench" in imported and others <= sys.stdlib_module_names, path.name
        used = {
            node.attr
            for node in nodes
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "helmbench"
        }
        assert used <= set(helmbench.__all__), path.name


def test_two_gallery_scripts_run_without_a_warning_and_leave_no_file(rng, tmp_path, monkeypatch, capfd):
    """A drawn sample: `make docs` runs all of them and ends at the first that fails."""
    monkeypatch.chdir(tmp_path)
    for path in rng.choice(GALLERY, size=2, replace=False):
        print(path.name)
        runpy.run_path(str(path))
        plt.close("all")
    out, err = capfd.readouterr()
    assert err == "" and not [folder for folder in (str(tmp_path), str(DOCS.parent)) if folder in out]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.nightly
def test_the_site_builds_without_a_warning_and_loads_nothing_from_the_network(tmp_path):
    """Without what `make docs` runs and draws with the same settings, which takes minutes: gallery, tutorials, pictures
    of methods and causes.  That these run is tested on its own; pictures that are not there are passed over.  The tree
    of pages in the side bar, 40 % of the time, stands on the first page alone."""
    build = [
        sys.executable,
        "-m",
        "sphinx",
        "-q",
        "-W",
        "--keep-going",
        "-D",
        "plot_gallery=0",
        "-D",
        "nb_execution_mode=off",
        "-D",
        "draw_pictures=0",
        "-D",
        "every_side_bar=0",
        "-D",
        "suppress_warnings=image.not_readable,myst-nb.lexer",
        "-d",
        tmp_path / "read",
        DOCS,
        tmp_path / "site",
    ]
    done = subprocess.run(build, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    pages = list((tmp_path / "site").rglob("*.html"))
    assert len(pages) > len(PAGES)
    loaded = re.compile(r"<(?:script|link|img|iframe)[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^\"' >]*")
    assert [found for page in pages for found in loaded.findall(page.read_text(encoding="utf-8"))] == []


def test_every_cause_is_on_the_page_of_causes():
    page = "\n".join(runpy.run_path(str(DOCS / "generate.py"))["cause_page"]())
    assert sorted(re.findall(r"^### (\w+)$", page, re.MULTILINE)) == sorted(helmbench.list_causes())
    assert sorted(re.findall(r"cause-(\w+)\.svg", page)) == sorted(helmbench.list_causes())


@pytest.mark.nightly
def test_every_cause_has_a_picture_that_shows_it():
    """Two curves that are not the same, of every cause; and the pictures of the fastest methods."""
    pictures = runpy.run_path(str(DOCS / "pictures.py"))
    own = pictures["_of_cause"].__globals__
    drawn, own["_compared"] = own["_compared"], lambda *curves: curves
    for name in pictures["all_causes"]():
        time, channel, before, after, title = own["_of_cause"](name)
        assert time.shape == before.shape == after.shape and np.nanmax(np.abs(after - before)) > 0.0, name
    assert drawn(time, channel, before, after, title).count("<path") > 2
    for name in ("ls", "straight-line", "euler-ls"):
        picture = own["_of_method"](name)
        assert "free run along" in picture and ("by the bound" in picture) == (name == "ls")
