"""What method texts of a suite file or of a stored run reach for: nothing of it is loaded unasked.

A file that the user names on the command line or in Python is the user's own.  A suite file and the folder of a run
may come from elsewhere, and what they name counts as foreign: Python files, classes by their import path, and storages
of tuning studies, which are written to.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from ..models.errors import BadInput

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
