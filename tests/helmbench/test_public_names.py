"""The public names and their signatures: a change here is a change for every user."""

import inspect
from pathlib import Path

import pytest

import helmbench

SURFACE = Path(__file__).with_name("public_names.txt")
MEMBERS = (
    *(
        "Assessment",
        "Case",
        "Calibration",
        "Check",
        "Comparison",
        "CraftDiagnosis",
        "Diagnosis",
        "Estimate",
        "Health",
        "ModelFromIndices",
        "Record",
        "RecordMeta",
        "Reproduction",
    ),
    *("Import", "ImportDraft", "SimulatedRuns", "SuiteResults", "Validation"),
)
"""Classes whose methods and properties are public, too."""


def surface() -> list[str]:
    """A line a public name: functions with signatures, classes with what they offer."""
    lines = []
    for name in helmbench.__all__:
        value = getattr(helmbench, name)
        if name == "__version__":
            lines.append(name)
        elif inspect.isclass(value):
            lines += class_lines(name, value)
        else:
            lines.append(f"{name}{inspect.signature(value)}")
    return lines


def class_lines(name: str, cls: type) -> list[str]:
    """A class and, where it is one of `MEMBERS`, a line for each public method and property."""
    if name not in MEMBERS:
        return [f"class {name}"]
    members = [
        (key, inspect.getattr_static(cls, key))
        for key in sorted(dir(cls))
        if not key.startswith("_") or key == "_repr_html_"
    ]
    lines = [f"class {name}{inspect.signature(cls)}"]
    for key, value in members:
        function = getattr(value, "__func__", value)
        if inspect.isfunction(function):
            lines.append(f"    {key}{inspect.signature(function)}")
        elif isinstance(value, property):
            lines.append(f"    {key}: property")
    return lines


def test_public_names_are_frozen():
    assert surface() == SURFACE.read_text(encoding="utf-8").splitlines()


def test_every_public_name_is_documented():
    def undocumented(value):
        return not (inspect.getdoc(value) or "").strip() or str(inspect.getdoc(value)).startswith(f"{value.__name__}(")

    names = [name for name in helmbench.__all__ if name != "__version__"]
    assert [name for name in names if undocumented(getattr(helmbench, name))] == []
    methods = [getattr(getattr(helmbench, name), key) for name in MEMBERS for key in public_methods(name)]
    assert [method.__qualname__ for method in methods if undocumented(method)] == []


def public_methods(name):
    members = inspect.getmembers(getattr(helmbench, name), inspect.isroutine)
    return [key for key, _ in members if not key.startswith("_")]


@pytest.mark.parametrize("name", [name for name in helmbench.__all__ if name.startswith("list_")])
def test_lists_give_an_identifier_and_a_title(name):
    found = getattr(helmbench, name)()
    assert found and all(isinstance(key, str) and title.strip() for key, title in found.items())
