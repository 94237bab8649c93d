"""One loader for YAML and JSON: plain data within limits, everything else is one line."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from helmbench.models.data_file import MOST_DEPTH, MOST_YAML_BYTES, json_of, load, yaml_of
from helmbench.models.errors import BadInput

BOMB = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 9)
)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("{day: 2026-01-31, time: 12:30, octal: 010, hex: 0x10}", ["2026-01-31", "12:30", "010", "0x10"]),
        ("{a: 1e-3, b: 1.0e-3, c: -2, d: .inf, e: -.INF}", [0.001, 0.001, -2, math.inf, -math.inf]),
        ("{a: null, b: ~, c: , d: yes, e: 'yes'}", [None, None, None, True, "yes"]),
        ("{a: &x {k: 1}, b: {<<: *x, l: 2}}", [{"k": 1}, {"k": 1, "l": 2}]),
    ],
)
def test_yaml_is_read_as_its_version_1_2_says(text, value):
    assert list(yaml_of(text.encode(), "a.yaml")[0].values()) == value


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: 1\nb: [", "row 2: not YAML ("),
        ("a: 1\na: 2", "row 2: the key 'a' stands twice"),
        ("a: &x [*x]", "row 1: an alias stands within what it stands for"),
        (BOMB, "more than 200000 keys and values"),
        ("[" * 5000, "nested deeper than 40 levels"),
        ("".join(f"a{i}: &a{i} [*a{i - 1}]\n" if i else "a0: &a0 [x]\n" for i in range(200)), "nested deeper"),
        (f"n: 1{'0' * 400}", "row 1: a number of 401 digits"),
        ("n: 1e999", "row 1: the number 1e999 is too large"),
        ("? [1, 2]\n: 3", "row 1: a key must be a text or a number"),
        ("a: !!binary aGVsbG8=", "the tag tag:yaml.org,2002:binary is not one of plain data"),
        ("a: !!python/object/apply:os.system [id]", "python/object/apply:os.system is not one of plain data"),
        ("a: !!int 12:30", "row 1: '12:30' is not a whole number"),
        ("a: !!bool maybe", "a value does not suit its tag"),
        ('a: "\\e[31m"', "row 1: a text with the character U+001B"),
        ('a: "\\ud800"', "row 1: a text with the character U+D800"),
        ("--- 1\n--- 2", "row 2: not YAML ("),
        ("# " * MOST_YAML_BYTES, "is larger than 96 KiB"),
    ],
)
def test_yaml_that_is_not_plain_data_is_refused(text, said, tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        load(path)
    assert said in str(caught.value) and str(caught.value).startswith(str(path)) and len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"a": 1,\n', "row 2: not JSON ("),
        ('{"a": 1, "a": 2}', "the key 'a' stands twice"),
        ("[" * 100_000, "nested deeper than 40 levels"),
        ("[" * (MOST_DEPTH + 1) + "]" * (MOST_DEPTH + 1), "nested deeper than 40 levels"),
        (f"[{'9' * 5000}]", "a number of 5000 digits"),
        ("[1e999]", "the number 1e999 is too large"),
        ("[NaN]", "NaN is not a number of JSON"),
        ('["\\ud800"]', "a text with the character U+D800"),
        ('{"\\u001b": 1}', "a text with the character U+001B"),
        (json.dumps([0] * 200_001), "more than 200000 keys and values"),
    ],
)
def test_json_that_is_not_plain_data_is_refused(text, said, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        load(path)
    assert said in str(caught.value) and str(caught.value).startswith(str(path)) and len(str(caught.value)) < 300


LETTERS = st.characters(categories=("L", "N", "P", "S"))
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**17), 10**17) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(LETTERS, max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(LETTERS, max_size=8), inner, max_size=4),
    max_leaves=12,
)  # fmt: skip


@given(VALUES)
def test_plain_data_comes_back_from_json_and_from_yaml(value):
    text = json.dumps(value, ensure_ascii=False).encode()
    assert json_of(text, "a.json") == value
    assert yaml_of(text, "a.yaml")[0] == value  # JSON in one line is YAML


@given(st.binary(max_size=200))
def test_any_bytes_end_in_a_value_or_in_one_line(tmp_path_factory, data):
    folder = tmp_path_factory.mktemp("any", numbered=True)
    for name in ("a.json", "a.yaml"):
        (folder / name).write_bytes(data)
        try:
            load(folder / name)
        except BadInput as refused:
            assert str(refused).startswith(str(folder / name)) and str(refused).isprintable()


@pytest.mark.parametrize("place", ["/dev/zero", "/dev/null", "."])
def test_what_is_no_file_is_not_read(place):
    with pytest.raises(BadInput, match=r"is not a file of data|cannot be read"):
        load(place)


def test_a_name_that_is_no_text_is_refused_in_printable_letters(tmp_path):
    (tmp_path / "a\udcff.yaml").write_text("a: 1")
    with pytest.raises(BadInput, match="the name of the file is not UTF-8 text") as caught:
        load(tmp_path / "a\udcff.yaml")
    assert str(caught.value).isprintable()
