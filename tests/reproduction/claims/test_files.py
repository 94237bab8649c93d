"""Claims files: every table of every paper is there, every entry is complete, faults are told in one line."""

import re
from importlib import import_module

import pytest

from helmbench.models.errors import BadInput
from helmbench.reproduction.claims.claim import Tolerance, table_number
from helmbench.reproduction.claims.files import FOLDER, everything, expanded, load, papers, read
from helmbench.reproduction.papers.study import studies_of

TABLES = {"000": (1, 2, 3), "001": (1, 2), "002": (1, 2), "003": (1, 2, 3, 4, 5, 6), "004": (1, 2, 3)}
"""Tables that the papers have."""

GOOD = """
paper: "999"
title: t
citation: c
claims:
  - {id: a, item: Table 1, kind: result, quantity: q, published: 1.0, study: s, corrected: k,
     tolerance: {relative: 0.1}}
"""


@pytest.mark.parametrize("paper", papers())
def test_every_table_has_a_claim(paper):
    assert set(TABLES[paper]) <= set(load(paper).tables)


@pytest.mark.parametrize("paper", papers())
def test_studies_and_drawings_exist(paper):
    found = load(paper)
    assert set(found.studies) <= set(studies_of(paper))
    drawings = import_module(f"helmbench.reproduction.papers.paper_{paper}.figures") if found.figures else None
    assert {figure.draw for figure in found.figures} == {name for name in dir(drawings) if name.startswith("draw_")}


@pytest.mark.parametrize("paper", papers())
def test_every_wrong_equation_is_among_the_errata(paper):
    found = load(paper)
    told = " ".join(erratum.equation for erratum in found.errata)
    wrong = {claim.equation for claim in found.claims if claim.equation}
    assert wrong == set() or told


def test_a_range_is_named_and_never_called_everything():
    """A contradiction names the range that was searched; nothing is said of all settings that there are."""
    for name in everything():
        text = (FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
        assert not re.search(r"no (other )?setting\b", text, re.IGNORECASE), name
        assert all(search.told for search in load(name).searches)


def test_what_a_search_covers_is_in_words():
    told = load("001").search("wide-settings").told
    for words in ("step 0.001 to 0.5 s", "rudder rate", "rudder lag", "speed in the primes instantaneous, constant"):
        assert words in told


@pytest.mark.parametrize("paper", papers())
def test_every_claim_may_be_contradicted_or_says_why_not(paper):
    """What is neither stated in the paper, nor searched, nor impossible, could only be reproduced."""
    open_claims = [c for c in load(paper).claims if not (c.stated or c.search or c.missing or c.unused or c.unprinted)]
    bounds = [claim.id for claim in open_claims if claim.form == "value"]
    assert bounds == []


def test_numbers_of_tables():
    assert [table_number(item) for item in ("Table 5", "Table II", "Table 3, a", "Figure 4", "Table")] == [
        5,
        2,
        3,
        None,
        None,
    ]


def test_one_table_of_a_paper():
    only = load("003").only_table(5)
    assert only.tables == (5,) and not only.figures and not only.references and not only.shown
    with pytest.raises(BadInput, match="003 has no table 7; it has 1, 2, 3, 4, 5, 6"):
        load("003").only_table(7)


def test_unknown_paper():
    with pytest.raises(BadInput, match="unknown paper '900'"):
        load("900")


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("study: s, corrected: k", "corrected: k", "a: needs either a study or what is missing"),
        ("corrected: k,", "", "a: needs the key of the corrected value"),
        ("published: 1.0", "published: much", "a: published is 'much'"),
        ("published: 1.0", "published: 1.0, form: about", "a: form: needs one of value, .* not about"),
        ("kind: result", "kind: number", "a: kind: needs one of result, .* not number"),
        ("kind: result, ", "", "missing: kind"),
        ("published: 1.0", "published: 1.0, search: wide", "a: there is no search wide"),
        ("published: 1.0", "published: 1.0, scale: odd", "a: scale: needs linear or log, not odd"),
        ("published: 1.0", "published: 1.0, form: holds", "a: published must be true or false"),
        ("published: 1.0", "published: 1.0, colour: red", "a: .*colour"),
        ("citation: c", "citation: c\ncite: c", "unknown key 'cite'"),
        ("citation: c", "", "missing: citation"),
        ("relative: 0.1", "relative: much", "a: tolerance relative: needs a number, not much"),
        ("  - {id", "  {id", "claims: needs a list of entries"),
        ("published: 1.0", "rows: {x: [1.0, 2.0]}, columns: {y: }", "a: row x has 2 numbers for 1 columns"),
        ("study: s,", "study: s, reference: {value: 1.0, tolerance: {}, form: odd},", "a: reference form: needs"),
    ],
)
def test_faults_of_a_file(old, new, told, tmp_path):
    path = tmp_path / "999.yaml"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(BadInput, match=told) as error:
        read(path)
    assert "\n" not in str(error.value) and str(path) in str(error.value)


def test_keys_of_a_table_of_values(tmp_path):
    path = tmp_path / "999.yaml"
    rows = "[{quantity: q, key: k}, {quantity: p, key: l}]"
    table = f"{{title: t, text: x, study: w, columns: {{one: a, two: b_c}}, rows: {rows}}}"
    path.write_text(f"{GOOD}shown: [{table}]", encoding="utf-8")
    (found,) = read(path).shown
    assert found.keys == ["a_k", "b_c_k", "a_l", "b_c_l"] and read(path).studies == ("s", "w")
    path.write_text(f"{GOOD}shown: [{table.replace('study: w, ', '')}]", encoding="utf-8")
    with pytest.raises(BadInput, match="study"):
        read(path)


def test_keys_on_a_logarithmic_scale(tmp_path):
    path = tmp_path / "999.yaml"
    path.write_text(GOOD.replace("corrected: k", "corrected: k, as_printed: p, scale: log"), encoding="utf-8")
    assert read(path).logarithmic("s") == {"k", "p"} and read(path).logarithmic("other") == set()


def test_references_take_study_and_key_from_their_claim(tmp_path):
    path = tmp_path / "999.yaml"
    path.write_text(
        GOOD.replace("0.1}}", "0.1}, reference: {value: 2.0, tolerance: {absolute: 0.5}}}"), encoding="utf-8"
    )
    (check,) = read(path).checks()
    assert (check.study, check.key, check.quantity) == ("s", "k", "Table 1: q")
    assert check.tolerance == Tolerance(absolute=0.5)


# ---- Tables of claims in short.


def test_one_claim_for_every_number():
    entry = {
        "rows": {"K": [1.0, None], "T": [2.0, 3.0]},
        "columns": {"a": {"reason": {"reproduced": "{row} of {column} is {corrected}"}}, "b": None},
        "id": "{column}-{row}",
        "tolerance": {"relative": 0.1},
    }
    found = list(expanded(entry, "published", "999.yaml"))
    assert [(claim["id"], claim["published"]) for claim in found] == [("a-K", 1.0), ("a-T", 2.0), ("b-T", 3.0)]
    assert found[1]["reason"] == {"reproduced": "T of a is {corrected}"}
    assert all(claim["tolerance"] == {"relative": 0.1} and "rows" not in claim for claim in found)
    assert next(expanded(entry, "value", "999.yaml"))["value"] == 1.0


def test_an_entry_without_rows_stands_for_itself():
    entry = {"id": "a", "quantity": "{row}"}
    assert list(expanded(entry, "published", "999.yaml")) == [entry]


def test_a_row_of_another_length_is_refused():
    with pytest.raises(BadInput, match=r"999\.yaml, a: row K has 1 numbers for 2 columns"):
        list(expanded({"id": "a", "rows": {"K": [1.0]}, "columns": {"a": None, "b": None}}, "published", "999.yaml"))
