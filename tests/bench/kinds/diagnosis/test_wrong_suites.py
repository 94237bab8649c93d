"""Suites of diagnosis that name no ship or no records end in one line."""

import pytest

from helmbench.cli import status_of

SUITE = """kind: diagnosis
title: wrong
methods: [innovations]
entries:
  - inject: [rudder_offset]
    vessels: [mariner]
"""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("[mariner]", "[nosuchship]"), "unknown vessel 'nosuchship'"),
        (("[mariner]", "[mariner]\n    records: []"), "records: needs a list of kinds of records"),
        (("[mariner]", "[mariner]\n    base: []"), "base: needs a list of bases"),
        (("[mariner]", "[]"), "vessels: needs a text"),
        (("[rudder_offset]", "[]"), "inject: needs a text"),
    ],
)
def test_a_suite_that_cannot_be_run_ends_in_one_line(change, said, tmp_path, capsys):
    suite = tmp_path / "wrong.yaml"
    suite.write_text(SUITE.replace(*change))
    assert status_of(["run", "--suite", str(suite), "-o", str(tmp_path / "out")]) == 2
    err = capsys.readouterr().err
    assert said in err and len(err.strip().splitlines()) == 1
