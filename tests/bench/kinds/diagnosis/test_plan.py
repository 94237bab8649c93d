"""Cases of a diagnosis suite: drawn evenly, the same for the same seed, and nothing that a ship cannot carry."""

from collections import Counter

import pytest

from helmbench.bench.faults import ANTICIPATED, TAXONOMY, UNFORESEEN, kind_of, names_of
from helmbench.bench.faults.ships import ship
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.diagnosis.plan import ORACLE, plan, stratified, with_seed
from helmbench.bench.suites import load_suite
from helmbench.cli import status_of
from helmbench.models.errors import BadInput


def suite_file(folder, text):
    path = folder / "mine.yaml"
    path.write_text(f"kind: diagnosis\nmethods: [innovations]\nentries:\n{text}")
    return load_suite(str(path))


def test_the_same_seed_plans_the_same_cases_and_another_seed_others(seed):
    suite = load_suite("diagnosis")
    first, again = (plan(suite, RunSelection("diagnosis", seed=seed)) for _ in range(2))
    assert first == again and len({spec.key for spec in first}) == len(first)
    other = plan(suite, RunSelection("diagnosis", seed=seed + 1))
    assert {spec.seed for spec in first}.isdisjoint(spec.seed for spec in other)


def test_more_rounds_only_add(seed):
    suite = load_suite("diagnosis")
    one, two = (plan(suite, RunSelection("diagnosis", seeds=n, seed=seed)) for n in (1, 2))
    assert two[: len(one)] == one and len(two) > len(one)


def test_the_default_covers_what_the_design_asks_for(seed):
    suite = load_suite("diagnosis")
    specs = [spec for spec in plan(suite, RunSelection("diagnosis", seed=seed)) if spec.method == "innovations"]
    assert 90 <= len(specs) <= 130
    injected = Counter(spec.injected for spec in specs if spec.group == "injected")
    assert set(injected) == {(cause,) for cause in names_of(TAXONOMY)} and min(injected.values()) >= 1
    kinds = {
        group: {spec.injected[0] for spec in specs if spec.group == group} for group in ("anticipated", "unforeseen")
    }
    assert kinds == {"anticipated": set(names_of(ANTICIPATED)), "unforeseen": set(names_of(UNFORESEEN))}
    clean = Counter(spec.gusts for spec in specs if spec.group == "null")
    assert clean["none"] >= 20 and clean["fast"] >= 10 and clean["slow"] >= 10
    strengths = Counter(spec.strength for spec in specs if spec.group == "injected")
    assert max(strengths.values()) - min(strengths.values()) <= 3
    assert len({spec.vessel for spec in specs if spec.group == "null"}) == 6
    assert all(kind_of(cause).carried_by(ship(spec.vessel)) for spec in specs for cause in spec.injected)


def test_others_join_the_first_round_and_the_oracle_goes_with_known_causes(seed):
    specs = plan(load_suite("diagnosis"), RunSelection("diagnosis", seeds=3, seed=seed))
    counts = Counter(spec.method for spec in specs)
    assert counts["residual-bic"] == counts["sparse-regression"] == counts["innovations"] / 3
    assert {spec.group for spec in specs if spec.method == ORACLE} == {"injected", "pair"}
    only = plan(load_suite("diagnosis"), RunSelection("diagnosis", methods=("residual-bic",), seeds=1, seed=seed))
    assert {spec.method for spec in only} == {"residual-bic", ORACLE}


def test_each_value_of_a_stratified_draw_comes_once_before_any_comes_again(rng):
    values = stratified(("a", "b", "c"), rng)
    assert [sorted(next(values) for _ in range(3)) for _ in range(4)] == [["a", "b", "c"]] * 4


def test_a_seed_is_drawn_where_none_is_given():
    assert with_seed(RunSelection("diagnosis", seed=7)).seed == 7
    assert len({with_seed(RunSelection("diagnosis")).seed for _ in range(5)}) == 5


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("  - {group: injected, inject: [rudder_sing]}\n", "rudder_sing"),
        ("  - {group: injected, inject: [current], vessels: [response-1]}\n", "can carry"),
        ("  - {group: strange, inject: [none]}\n", "strange"),
        ("  - {group: 'null', inject: [none], noise: low}\n", "noise"),
    ],
)
def test_a_bad_entry_is_refused(tmp_path, text, told):
    with pytest.raises(BadInput, match=told):
        plan(suite_file(tmp_path, text), RunSelection("mine", seed=1))


@pytest.mark.parametrize(
    ("change", "told"), [({"methods": ("guess",)}, "guess"), ({"vessels": ("titanic",)}, "titanic")]
)
def test_a_bad_selection_is_refused(change, told):
    with pytest.raises(BadInput, match=told):
        plan(load_suite("diagnosis"), RunSelection("diagnosis", seed=1, **change))


# ---- Suites of diagnosis that name no ship or no records end in one line.

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
