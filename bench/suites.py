"""Suites as data: YAML files that say what is run.

A suite file has a `title`, a `kind` (a folder of `kinds/`; default `identification`) and a list of `entries`.  What an
entry holds, and which further keys the file has, is said by the kind's module `suite`.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from ..models.errors import BadInput
from ..models.suggestions import suggestion
from ..models.yaml_file import checked, read_yaml
from .kinds import IDENTIFICATION, suite_models
from .kinds.base import Suite

FOLDER = Path(__file__).parent / "suites"


def suite_names() -> list[str]:
    """Names of the suites that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.yaml"))


def load_suite(name: str) -> Suite:
    """A shipped suite by its name, or a suite file by its path.

    Raises `BadInput` where there is no such suite or the file does not follow the models of its kind.
    """
    from_file = name.endswith((".yaml", ".yml"))
    known = suite_names()
    if not (Path(name).is_file() if from_file else name in known):
        hint = suggestion(name, known, f"known: {', '.join(known)}, or the path of a .yaml file")
        raise BadInput(f"unknown suite {name!r}", hint=hint)
    path = Path(name) if from_file else FOLDER / f"{name}.yaml"
    content = read_yaml(path, "a suite, which has a title and entries")
    entries = content.pop("entries", None)
    if not isinstance(entries, list) or not entries:
        raise BadInput("has no list of entries", file=path)
    kind = content.get("kind", IDENTIFICATION)
    head_model, entry_model = suite_models(kind, path)
    rows = tuple(checked(entry_model, entry, f"{path}: entry {i}") for i, entry in enumerate(entries, start=1))
    head = checked(head_model, content, path)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
    return Suite(path.stem, digest, kind, head, rows, path.parent)


# ---- What method texts of a suite file or of a stored run reach for: nothing of it is loaded unasked.
# A file that the user names on the command line or in Python is the user's own. A suite file and the folder of a
# run may come from elsewhere, and what they name counts as foreign: Python files, classes by their import path,
# and storages of tuning studies, which are written to.

Trust = bool | Callable[[str], bool]
"""Whether foreign code may run, or a function that answers a question in words."""
_FOREIGN = re.compile(r"\.py:|\bsklearn:[^,]*\.|\bstorage\s*=")
"""A Python file, a class by its import path, a storage of studies."""


def foreign(texts: Iterable[str]) -> list[str]:
    """Those of the texts that load code or write files by a name of their own."""
    return [text for text in dict.fromkeys(texts) if _FOREIGN.search(text)]


def check_trust(texts: Iterable[str], source: object, trust: Trust) -> None:
    """Refuse foreign code that `source` names, unless it is trusted; BadInput names it."""
    found = foreign(texts)
    if not found:
        return
    named = f"{', '.join(found[:3])}{' and others' if len(found) > 3 else ''}"
    if trust is True or (callable(trust) and trust(f"{source} names code to run: {named}. Run it?")):
        return
    hint = "read it, then allow it with --trust (Python: trust=True)"
    raise BadInput(f"names code to run, which is not trusted: {named}", file=source, hint=hint)
