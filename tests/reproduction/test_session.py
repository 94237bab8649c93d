"""A made-up paper through the whole of `reproduce`: runs, resuming, results, figures, pages, command line."""

import json
import re

import numpy as np
import pandas as pd
import pytest

from helmbench import cli
from helmbench.bench.journal import RUNS, DamagedRunsWarning
from helmbench.bench.store import Store
from helmbench.models.errors import BadInput
from helmbench.reproduction import results, runner, session
from helmbench.reproduction.claims import files
from helmbench.reproduction.pages import markdown
from helmbench.reproduction.papers import study
from helmbench.reproduction.papers.study import PaperStudy, StudyResult

from ..support.inline_pool import inline

CLAIMS = """
paper: "999"
title: A made-up paper
citation: nobody
claims:
  - {id: a, kind: result, item: Table 1, quantity: mean, published: 0.0, study: noise, corrected: value,
     as_printed: shifted}
  - {id: b, kind: result, item: Table 1, quantity: sign, published: true, form: holds, study: noise,
     corrected: positive}
  - {id: c, kind: setting, item: Table II, quantity: "|x|", published: 7, study: constant, corrected: seven,
     protocol: counted}
  - {id: d, kind: derived, item: Table II, quantity: speed, published: fast, missing: Nothing is said.}
errata:
  - {equation: "(1)", printed: "$a$", corrected: "$b$", consequence: It differs., claims: [a]}
figures:
  - {id: one, title: One, caption: A line., study: noise, draw: draw}
references:
  - {quantity: seven, value: 7.0, tolerance: {absolute: 0.1}, study: constant, key: seven}
"""


class Made:
    """Stands for the modules of a paper."""

    calls = 0
    fails = False

    def __init__(self):
        self.STUDIES = {"noise": PaperStudy(self.noise, seeds=5), "constant": PaperStudy(self.constant)}

    def noise(self, rng, *, index):
        self.calls += 1
        if self.fails and index == 3:
            raise ValueError("no luck\nat all")
        x = rng.normal()
        return StudyResult({"value": x, "shifted": np.nan, "positive": x > 0}, {"line": rng.normal(size=20)})

    def constant(self, rng, *, index):
        self.calls += 1
        return StudyResult({"seven": 7})

    def draw(self, axes, series, results):
        axes.plot(series["line"])


@pytest.fixture
def made(monkeypatch, tmp_path):
    folder = tmp_path / "claims"
    folder.mkdir()
    (folder / "999.yaml").write_text(CLAIMS, encoding="utf-8")
    module = Made()
    monkeypatch.setattr(files, "FOLDER", folder)
    monkeypatch.setattr(study, "import_module", lambda *_: module)
    return module


def reproduce(directory, resume=False, seed=0):
    with inline() as pool:
        return session.reproduce(session.select(None, None), directory, pool, resume, seed=seed)


def stored(directory):
    return {path.relative_to(directory): path.read_bytes() for path in directory.rglob("*") if path.is_file()}


def test_equal_bytes_every_time(made, tmp_path):
    for name in ("one", "two"):
        reproduce(tmp_path / name)
    assert stored(tmp_path / "one" / "pages") == stored(tmp_path / "two" / "pages")


def test_pages_tell_everything(made, tmp_path):
    found = reproduce(tmp_path / "out")
    text = (tmp_path / "out/pages/999.md").read_text(encoding="utf-8")
    text = re.sub(" +", " ", text)
    assert "| \\|x\\| (1) | setting | 7 | – | 7 | **reproduced** |" in text
    assert "| speed | derived | – | fast | – | **not computable** | Nothing is said. |" in text
    assert "1. counted" in text and "![One](figures/999-one.svg)" in text and "| (1) | $a$ | $b$ | It differs." in text
    assert "| seven | 7 ± 0.1 | 7 | yes |" in text
    assert "no finite value" in text
    index = re.sub(" +", " ", (tmp_path / "out/pages/README.md").read_text(encoding="utf-8"))
    assert "[999](999.md) | A made-up paper | 2 |" in index and "| setting | 1 | 1 | 0 |" in index
    assert set(pd.read_parquet(tmp_path / "out/values.parquet")["paper"]) == {"999"}
    rows = session.rows(found)
    assert [row["verdict"] for row in rows].count("not computable") == 1
    assert [(row["kind"], row["published"], row["from_printed_numbers"]) for row in rows[2:]] == [
        ("setting", 7, None),
        ("derived", None, "fast"),
    ]
    assert set(rows[0]) >= {
        "paper",
        "item",
        "kind",
        "quantity",
        "published",
        "corrected",
        "as_printed",
        "verdict",
        "reason",
    }


def test_wrong_equations_stand_beside_what_they_spoil(made, tmp_path):
    path = files.FOLDER / "999.yaml"
    text = path.read_text(encoding="utf-8")
    text = text.replace("corrected: seven,", 'corrected: seven, equation: "(7)",')
    path.write_text(text.replace("as_printed: shifted", 'as_printed: shifted, equation: "(8)"'), encoding="utf-8")
    reproduce(tmp_path / "out")
    page = (tmp_path / "out/pages/999.md").read_text(encoding="utf-8")
    assert "Wrong: eq. (8)." in page and "Wrong: eq. (7)" not in page


def test_pages_from_stored_results_alone(made, tmp_path):
    reproduce(tmp_path / "out")
    before = stored(tmp_path / "out/pages")
    markdown.write(session.select(None, None), tmp_path / "out/pages")
    assert stored(tmp_path / "out/pages") == before


def test_resuming_runs_only_what_is_missing(made, tmp_path):
    reproduce(tmp_path / "out")
    assert made.calls == 6
    before = stored(tmp_path / "out/pages")
    with_line(tmp_path / "out", b"999/noise/0002")
    reproduce(tmp_path / "out", resume=True)
    assert made.calls == 7 and stored(tmp_path / "out/pages") == before


@pytest.mark.parametrize(
    "damage", [b"{", b"[]", b'{"key": "999/noise/0000", "row": {}, "parameters": [1]}', b"\x00" * 50]
)
def test_a_damaged_run_is_made_again(made, tmp_path, damage):
    reproduce(tmp_path / "out")
    before = stored(tmp_path / "out/pages")
    with_line(tmp_path / "out", b"999/noise/0000", damage + b"\n")
    with pytest.warns(DamagedRunsWarning, match="--resume makes the lost ones again"):
        reproduce(tmp_path / "out", resume=True)
    assert made.calls == 7 and stored(tmp_path / "out/pages") == before


def with_line(directory, key, line=b""):
    """Put a line into the journal in the place of a run's."""
    path = directory / RUNS
    path.write_bytes(b"".join(line if key in one else one for one in path.read_bytes().splitlines(keepends=True)))


def test_two_processes_cannot_compute_in_one_directory(made, tmp_path):
    reproduce(tmp_path / "out")
    with (
        Store.resume(tmp_path / "out", runner.KIND),
        pytest.raises(BadInput, match="another run is writing here"),
    ):
        reproduce(tmp_path / "out", resume=True)


def test_a_failed_run_is_told_and_repeated(made, tmp_path):
    made.fails = True
    ((_, found),) = reproduce(tmp_path / "out")
    assert found.failures == {"noise": "ValueError: no luck at all"}
    assert found.values["noise"]["value"].n == 4
    made.fails = False
    ((_, found),) = reproduce(tmp_path / "out", resume=True)
    assert found.failures == {} and found.values["noise"]["value"].n == 5


def test_directories_that_are_refused(made, tmp_path, monkeypatch):
    (tmp_path / "other").mkdir()
    (tmp_path / "other/notes.txt").write_text("mine")
    for resume in (False, True):
        with pytest.raises(BadInput, match="not empty"):
            reproduce(tmp_path / "other", resume)
    reproduce(tmp_path / "out")
    with pytest.raises(BadInput, match="--resume"):
        reproduce(tmp_path / "out")
    monkeypatch.setattr(runner, "code_version", lambda: "another")
    with pytest.raises(BadInput, match="version differs"):
        reproduce(tmp_path / "out", resume=True)


def test_another_seed_draws_other_numbers(made, tmp_path):
    medians = []
    for seed in (0, 7):
        ((_, found),) = reproduce(tmp_path / str(seed), seed=seed)
        medians.append(found.values["noise"]["value"].median)
    assert medians[0] != medians[1]
    with pytest.raises(BadInput, match="cannot be resumed: seed differs"):
        reproduce(tmp_path / "7", resume=True)


def test_damaged_results(made, tmp_path):
    reproduce(tmp_path / "out")
    path = tmp_path / "out/pages/results/999.json"
    path.write_text("{}")
    with pytest.raises(BadInput, match="holds no results"):
        results.read("999", path.parents[1])


def test_random_numbers_belong_to_paper_study_and_index():
    first = study.stream("000", "a", 0).normal()
    assert study.stream("000", "a", 0).normal() == first
    names = (("001", "a", 0), ("000", "b", 0), ("000", "a", 1), ("000", "a", 0, 1))
    others = [study.stream(*name).normal() for name in names]
    assert first not in others


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["900"], "unknown paper '900'"),
        (["003", "--table", "9"], "paper 003 has no table 9"),
        (["--table", "5"], "--table needs a paper"),
        (["003", "--resume"], "--resume needs the directory"),
    ],
)
def test_bad_input_is_one_line_and_status_2(arguments, told, capsys):
    assert cli.status_of(["reproduce", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == "" and told in err and err.count("\n") == 1


@pytest.mark.nightly
def test_one_table_as_json(capsys):
    """The command itself, on a table that needs no fit."""
    assert cli.status_of(["reproduce", "003", "--table", "3", "--json", "--jobs", "1"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert {row["item"] for row in rows} == {"Table 3"}
    gain = next(row for row in rows if row["quantity"] == "observer gain l_4")
    assert gain["published"] == 364500 and gain["corrected"]["median"] == 364500 and gain["verdict"] == "reproduced"
