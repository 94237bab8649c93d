"""How to cite helmbench and the papers that it stands on: one truth in CITATION.cff, the package and the BibTeX."""

import datetime
import re
import tomllib
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
SOURCE = yaml.safe_load((ROOT / "CITATION.cff").read_text())
ENTRY = re.compile(r"@(\w+)\{([\w]+),\n(.*?)\n\}", re.DOTALL)
FIELD = re.compile(r"^  (\w+) *= \{(.*?)\},?$", re.DOTALL | re.MULTILINE)
PAPERS = 5


def bibtex():
    """Title -> fields of every entry of docs/sources.md."""
    text = (ROOT / "docs" / "sources.md").read_text().partition("```bibtex\n")[2].partition("\n```")[0]
    found = [dict(FIELD.findall(body)) for _, _, body in ENTRY.findall(text)]
    return {" ".join(one["title"].split()): one for one in found}


def authors_of(source):
    return [f"{one['family-names']}, {one['given-names']}" for one in source["authors"]]


def test_the_software_has_a_date_a_version_and_a_doi_that_all_places_agree_on():
    own = bibtex()[SOURCE["title"]]
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert SOURCE["version"] == own["version"] == version
    assert SOURCE["date-released"] == own["date"] == datetime.date.fromisoformat(own["date"]).isoformat()
    assert SOURCE["doi"] == own["doi"] and re.fullmatch(r"10\.\d{4,9}/\S+", own["doi"])
    assert own["author"].strip("{}") == SOURCE["authors"][0]["name"]


def test_the_five_papers_and_the_ship_are_cited_in_both_forms():
    entries = bibtex()
    assert len(SOURCE["references"]) == PAPERS + 1 == len(entries) - 1
    for source in SOURCE["references"]:
        entry = entries[" ".join(source["title"].split())]
        assert entry["author"] == " and ".join(authors_of(source))
        assert (entry.get("year"), entry.get("doi")) == (
            str(source["year"]) if "year" in source else None,
            source.get("doi"),
        )
