"""The committed pages: complete, equal to what their stored results say, within reach of the independent values."""

import hashlib
import re
from pathlib import Path

import pytest

from helmbench.reproduction import results
from helmbench.reproduction.claims.files import load, papers
from helmbench.reproduction.pages import figures, markdown
from helmbench.reproduction.verdicts.verdict import VERDICTS, within

FOLDER = Path(__file__).resolve().parents[3] / "reports" / "reproduction"


@pytest.mark.parametrize("paper", papers())
def test_page_is_what_the_stored_results_say(paper):
    found = load(paper)
    text = (FOLDER / f"{paper}.md").read_text(encoding="utf-8")
    assert text == markdown.page(found, results.read(paper, FOLDER))


def test_index_is_what_the_stored_results_say():
    found = [(load(paper), results.read(paper, FOLDER)) for paper in papers()]
    assert (FOLDER / markdown.INDEX).read_text(encoding="utf-8") == markdown.index(found)


@pytest.mark.parametrize("paper", papers())
def test_every_claim_has_a_verdict_from_stored_values(paper):
    found, stored = load(paper), results.read(paper, FOLDER)
    assert stored.failures == {}
    lacking = [
        (claim.id, key)
        for claim in found.claims
        for key in (claim.corrected, claim.as_printed)
        if key and key not in stored.values.get(claim.study, {})
    ]
    assert lacking == []
    judged = stored.judged(found)
    assert len(judged) == len(found.claims)
    assert [j.claim.id for j in judged if j.verdict not in VERDICTS or not j.reason.strip()] == []


@pytest.mark.parametrize("paper", papers())
def test_independent_values_are_reached(paper):
    found, stored = load(paper), results.read(paper, FOLDER)
    missed = [(c.quantity, c.value, stored.found(c).median) for c in found.checks() if not within(c, stored.found(c))]
    assert missed == []


@pytest.mark.parametrize("paper", papers())
def test_figures_are_those_of_the_results(paper):
    found, stored = load(paper), results.read(paper, FOLDER)
    assert set(stored.figures) == {figure.id for figure in found.figures}
    for figure in found.figures:
        data = (FOLDER / figures.file_of(paper, figure)).read_bytes()
        assert hashlib.sha256(data).hexdigest() == stored.figures[figure.id], figure.id


def test_pages_are_small_and_their_links_lead_somewhere():
    sizes = [path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()]
    assert sum(sizes) < 5_000_000
    for page in FOLDER.glob("*.md"):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            assert (FOLDER / target).exists() or target.startswith("http"), (page.name, target)
    assert not list(FOLDER.rglob("*.html"))
