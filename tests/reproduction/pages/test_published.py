"""The committed pages: complete, equal to what their stored results say, within reach of the independent values."""

import hashlib
import re
from pathlib import Path

import pytest

from helmbench.reproduction import results
from helmbench.reproduction.claims.files import ACROSS, everything, load, papers
from helmbench.reproduction.pages import markdown
from helmbench.reproduction.pages.across import cells, proposed
from helmbench.reproduction.papers.paper_across.studies import NOISE, VESSELS
from helmbench.reproduction.verdicts import CONTRADICTED, VERDICTS, within

FOLDER = Path(__file__).resolve().parents[3] / "reports" / "reproduction"


def test_pages_are_what_the_stored_results_say():
    found = [(load(paper), results.read(paper, FOLDER)) for paper in everything()]
    texts = markdown.texts_of(found)
    assert set(texts) == {path.name for path in FOLDER.glob("*.md")}
    assert [name for name, text in texts.items() if (FOLDER / name).read_text(encoding="utf-8") != text] == []


@pytest.mark.parametrize("paper", papers())
def test_only_what_is_stated_or_searched_is_contradicted(paper):
    for judged in results.read(paper, FOLDER).judged(load(paper)):
        if judged.verdict == CONTRADICTED:
            claim = judged.claim
            assert claim.stated or (claim.search and "Searched: " in judged.reason), claim.id
        assert not re.search(r"no (other )?setting\b", judged.reason, re.IGNORECASE), judged.claim.id


def test_the_first_table_is_the_answer():
    text = (FOLDER / markdown.INDEX).read_text(encoding="utf-8")
    begin, end = (text.index(marker) for marker in markdown.MARKERS)
    table = text[begin:end]
    assert begin < text.index("## Results by verdict")
    assert all(f"[{paper}]({paper}.md)" in table for paper in papers())
    for paper in papers():
        page = (FOLDER / f"{paper}.md").read_text(encoding="utf-8")
        assert page.index("## Does it beat the baseline?") < page.index("## Claims")


def test_every_method_is_compared_on_every_vessel():
    stored = results.read(ACROSS, FOLDER)
    assert set(stored.values) == {*VESSELS, "proposed"} and stored.failures == {}
    assert len(proposed(stored)) == len(VESSELS) * len(NOISE)
    for pair in ("fw-rls", "fci-ls", "mi-rls", "nmi-rls", "eso-svf", "eso-ls"):
        found = cells(stored, pair)
        assert len(found) == len(VESSELS) * len(NOISE), pair
        assert all(0.0 <= cell.adjusted <= 1.0 and -1.0 <= cell.found["effect"] <= 1.0 for cell in found)


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
    assert found.headline is not None
    shown = [(table.study, key) for table in found.shown for key in table.keys]
    assert [(study, key) for study, key in shown if key not in stored.values.get(study, {})] == []
    assert [c.key for c in found.headline.own if c.key not in stored.values[c.study]] == []
    searched = [(claim, key) for claim in found.claims if claim.search for key in (claim.corrected, claim.as_printed)]
    assert [(claim.id, key) for claim, key in searched if key and key not in stored.values[claim.search]] == []
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
        data = (FOLDER / markdown.file_of(paper, figure)).read_bytes()
        assert hashlib.sha256(data).hexdigest() == stored.figures[figure.id], figure.id


def test_pages_are_small_and_their_links_lead_somewhere():
    sizes = [path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()]
    assert sum(sizes) < 5_000_000
    for page in FOLDER.glob("*.md"):
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            assert (FOLDER / target).exists() or target.startswith("http"), (page.name, target)
    assert not list(FOLDER.rglob("*.html"))
