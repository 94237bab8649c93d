"""Tables of claims in short."""

import pytest

from helmbench.models.errors import BadInput
from helmbench.reproduction.claims.files import expanded


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
