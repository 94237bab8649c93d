"""Nothing in the rooms is unused, as far as vulture can see."""

from pathlib import Path

from vulture.core import Vulture

ROOT = Path(__file__).resolve().parents[1]
ROOMS = (
    *("models", "datasets", "checks", "estimation", "methods", "diagnosis"),
    *("bench", "reporting", "reproduction", "helmbench", "helmbench/__init__.pyi", "tests/vulture_whitelist.py"),
)
FOUND_BY_REGISTRY = (
    *("checks/files", "checks/columns.py", "checks/sensors.py", "diagnosis/causes", "diagnosis/baselines"),
    *("bench/faults/effects", "bench/scores"),
)
"""Folders and files whose classes and functions a registry loads."""
METHODS = "methods/"
"""Folder whose classes a registry loads."""
CALLED_BY_OTHERS = (
    *(
        "check_*",
        "_repr_html_",
        "__getattr__",
        "__dir__",
        "__signature__",
    ),  # contract checks; notebooks; the interpreter
    "draw_*",  # claims files of papers, see tests/reproduction/claims
    *("_print_*", "_split_super_sub", "_hprint_*", "fdiff", "nargs", "is_real"),  # SymPy's printers and functions
    *("_cache", "load_overload", "save_overload", "cache_path", "_lineno", "_locator", "_py_file"),  # numba
    *("model_config", "shell_complete", "param"),  # pydantic; click (two)
    *("list_commands", "format_commands", "format_options"),  # click
    *("compose_node", "yaml_implicit_resolvers", "formatwarning"),  # PyYAML; warnings
)


def test_nothing_is_unused():
    vulture = Vulture(
        ignore_names=CALLED_BY_OTHERS, ignore_decorators=["@model_validator*", "@field_validator*", "@method"]
    )
    vulture.scavenge([str(ROOT / room) for room in ROOMS])
    unused = [
        f"{item.filename.relative_to(ROOT)}:{item.first_lineno} {item.typ} {item.name}"
        for item in vulture.get_unused_code(min_confidence=60)
        if not _found_by_registry(item) and not _is_key_of_a_file(item) and item.name != "USED"
    ]
    assert unused == []


def _found_by_registry(item) -> bool:
    file = item.filename.relative_to(ROOT).as_posix()
    if file.startswith(METHODS):
        return item.typ == "class"
    return item.typ in ("class", "function") and file.startswith(FOUND_BY_REGISTRY)


def _is_key_of_a_file(item) -> bool:
    """Whether it is a field of a pydantic model: a key that a data file may have."""
    return item.typ == "variable" and item.filename.name.endswith("_file.py")
