"""YAML data files: every fault is one line with file and key."""

import pytest

from helmbench.models.errors import BadInput
from helmbench.models.vessel import read_vessel, vessel_files
from helmbench.models.yaml_file import Count, Counts, FileContent, Flag, Positive, Shares, TextGroups, Texts, checked

HEAD = "id: ship\ntitle: t\nfamily: kt\nsource: s\npositive_rudder: port\nmax_step_s: 1\n"


class Everything(FileContent):
    texts: Texts = ("a",)
    groups: TextGroups = ()
    flag: Flag = False
    count: Count = 1
    counts: Counts = (1,)
    positive: Positive = 1.0
    shares: Shares = (1.0,)


@pytest.mark.parametrize(
    ("content", "read"),
    [
        ({"texts": "one"}, {"texts": ("one",)}),
        ({"texts": ["one", "two"]}, {"texts": ("one", "two")}),
        ({"groups": "one"}, {"groups": (("one",),)}),
        ({"groups": ["one", "two"]}, {"groups": (("one", "two"),)}),
        ({"groups": [["one"], ["two", "three"]]}, {"groups": (("one",), ("two", "three"))}),
        ({"counts": 3}, {"counts": (3,)}),
        ({"positive": 2}, {"positive": 2.0}),
        ({"shares": [0.5, 1]}, {"shares": (0.5, 1.0)}),
    ],
)
def test_one_value_or_a_list_is_read(content, read):
    assert checked(Everything, content, "a.yaml") == Everything(**read)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"text": "a"}, "a.yaml: unknown key 'text'; did you mean texts\\? known: texts, groups"),
        ({"texts": [1]}, "a.yaml: texts: needs a text or a list of texts, not \\[1\\]"),
        ({"groups": [["a"], 2]}, "a.yaml: groups: needs a text"),
        ({"flag": "yes"}, "a.yaml: flag: needs true or false, not yes"),
        ({"count": True}, "a.yaml: count: needs a whole number from 1 to 1000000, not true"),
        ({"count": 1.0}, "a.yaml: count: needs a whole number"),
        ({"positive": float("nan")}, "a.yaml: positive: needs a positive number, not nan"),
        ({"positive": "1e-3"}, "a.yaml: positive: needs a positive number, not 1e-3"),
        ({"shares": 0}, "a.yaml: shares: needs shares above 0"),
        ([1], "a.yaml: is not a mapping"),
    ],
)
def test_a_fault_is_named(content, said):
    with pytest.raises(BadInput, match=said):
        checked(Everything, content, "a.yaml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("parameters: {T1: {value: fast, unit: s, source: s}}", "parameters T1: needs value, unit and source"),
        ("parameters: {T1: {value: true, unit: s, source: s}}", "parameters T1: needs value, unit and source"),
        ("parameters: {}\nconstants: {L: 3}", "constants L: needs value, unit and source"),
        ("parameters: {}\nspeed_m_s: fast", "speed_m_s: needs a number from 0 to 200, not fast"),
        ("parameters: {}\ncolour: red", "unknown key 'colour'"),
        ("parameters: 3", "parameters: Input should be"),
    ],
)
def test_a_fault_of_a_vessel_file_is_one_line(text, said, tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(HEAD + text)
    with pytest.raises(BadInput, match=said) as caught:
        read_vessel(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_the_side_of_a_positive_rudder_is_checked(tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(HEAD.replace("port", "left") + "parameters: {}")
    with pytest.raises(BadInput, match="positive_rudder: needs port or starboard, not left"):
        read_vessel(path)


def test_a_file_under_another_name_is_refused(tmp_path):
    path = tmp_path / "boat.yaml"
    path.write_text(HEAD + "parameters: {}")
    with pytest.raises(BadInput, match="id 'ship' differs from the file's name"):
        read_vessel(path)


def test_every_vessel_of_the_package_is_read():
    assert all(read_vessel(path)["id"] == name for name, path in vessel_files().items())
