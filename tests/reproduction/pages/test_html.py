"""The local pages hold every claim and figure of the published ones."""

from pathlib import Path

import pytest

from helmbench.reproduction import results as stored
from helmbench.reproduction.claims import files
from helmbench.reproduction.pages import html

PUBLISHED = Path(__file__).parents[3] / "reports" / "reproduction"


@pytest.mark.parametrize("name", files.papers())
def test_every_claim_and_figure_is_there(name, tmp_path):
    paper = files.load(name)
    found = stored.read(name, PUBLISHED)
    (path,) = html.write([(paper, found)], PUBLISHED, tmp_path / "interactive")
    text = path.read_text("utf-8")
    assert text.count("<tr data-kind=") == len(paper.claims)
    assert text.count('<div class="view"><svg') == len(found.figures)
    assert "http://" not in text.replace("http://www.w3.org", "").replace("http://creativecommons.org", "").replace(
        "http://purl.org", ""
    )
