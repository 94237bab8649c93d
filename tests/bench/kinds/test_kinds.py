"""Kinds of suites: found by their folder, and each keeps the interface by which the runner knows it."""

from pathlib import Path

import pytest

from helmbench.bench import kinds as folder
from helmbench.bench.kinds import kind_names, kind_of, suite_models
from helmbench.bench.kinds.base import TIMES, Kind
from helmbench.bench.suites import load_suite, suite_names
from helmbench.models.errors import BadInput
from helmbench.models.yaml_file import FileContent


def test_every_folder_is_a_kind_of_its_name():
    folders = {path.parent.name for path in Path(folder.__file__).parent.glob("*/__init__.py")}
    assert set(kind_names()) == folders
    assert all(isinstance(kind_of(name), Kind) and kind_of(name).name == name for name in folders)


def test_an_unknown_kind_names_the_file_and_the_known_ones():
    with pytest.raises(BadInput, match=r"mine\.yaml: unknown kind 'speed'; known: diagnosis, identification"):
        kind_of("speed", "mine.yaml")


@pytest.mark.parametrize("name", kind_names())
def test_both_tables_hold_their_keys_and_the_wide_one_ends_with_the_cost(name):
    tables = kind_of(name).tables
    assert list(tables.wide)[: len(tables.keys)] == list(tables.long)[: len(tables.keys)] == list(tables.keys)
    assert set(tables.long_keys) <= set(tables.long) - set(tables.keys)
    assert list(tables.wide)[-len(TIMES) :] == list(TIMES)
    assert {*tables.wide.values(), *tables.long.values()} <= {"string", "int", "float", "bool"}
    assert {"status", "error"} <= set(tables.wide)


@pytest.mark.parametrize("name", kind_names())
def test_a_failure_is_told_by_columns_of_its_row(name):
    kind = kind_of(name)
    assert set(kind.failure_columns) <= set(kind.tables.wide)
    row = dict.fromkeys(kind.tables.wide, "x") | {"error": "no luck"}
    assert kind.describe(row).endswith(": no luck") and "\n" not in kind.describe(row)


@pytest.mark.parametrize("name", kind_names())
def test_models_of_suite_files_refuse_unknown_keys(name):
    for model in suite_models(name):
        assert issubclass(model, FileContent) and model.model_config["extra"] == "forbid"


def test_every_kind_has_a_suite_that_ships():
    assert {load_suite(name).kind for name in suite_names()} == set(kind_names())
