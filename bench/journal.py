"""The journal of a run, `runs.jsonl`: one JSON line per finished run, which ends with a digest of the rest of it.

It is only ever appended to.  An incomplete last line is dropped when the journal is opened again; a damaged line
between, also one of which a single digit was changed, is passed over, with a warning, and its run made again.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..models.data_file import json_of
from ..models.errors import BadInput
from ..models.folders import open_to_append, read_regular
from ..models.plain import EXACT_BELOW, plain
from .kinds.base import Tables

RUNS = "runs.jsonl"
_SEAL = re.compile(rb', "digest": "([0-9a-f]{16})"\}$')


class DamagedRunsWarning(UserWarning):
    """Lines of a journal are not stored runs; the others are used."""


def sealed(value: Mapping[str, Any]) -> bytes:
    """A JSON object as one line that ends with a digest of the rest."""
    text = json.dumps(plain(value), allow_nan=False, ensure_ascii=False).encode()
    return b'%s, "digest": "%s"}\n' % (text[:-1], _digest(text))


def unsealed(line: bytes) -> bytes | None:
    """The object of a line without its digest; None where they differ.  Lines of earlier versions have no digest."""
    seal = _SEAL.search(line)
    if seal is None:
        return line
    text = line[: seal.start()] + b"}"
    return text if _digest(text) == seal[1] else None


def _digest(text: bytes) -> bytes:
    return hashlib.sha256(text).hexdigest()[:16].encode()


def read_runs(path: Path, form: Tables | None = None) -> list[dict[str, Any]]:
    """Stored runs, the last one of each key.

    form : of the tables that the runs' rows must fit.

    A torn last line is left out, and any other line that is not a stored run, with a `DamagedRunsWarning`.
    """
    return _used(read_regular(path), path, form)[0]


def open_journal(path: Path, form: Tables) -> tuple[int, list[dict[str, Any]]]:
    """The journal, open for this process alone behind its last whole line, and its runs as `read_runs` gives them.

    Raises
    ------
    BadInput : it is no regular file of this user, or another process writes it.
    """
    file = open_to_append(path)
    try:
        lock(file, path)
        runs, whole = _used(read_regular(path), path, form)
        os.ftruncate(file, whole)
    except BaseException:
        os.close(file)
        raise
    return file, runs


def lock(file: int, path: Path) -> None:
    """Take the lock of an open file or folder; BadInput where another process has it.  path : for the message."""
    try:
        import fcntl
    except ImportError:  # no advisory locks on this platform
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise BadInput("another run is writing here", file=path.parent) from None


def _used(data: bytes, path: Path, form: Tables | None) -> tuple[list[dict[str, Any]], int]:
    """Runs, the last one of each key, and the number of bytes that hold whole lines; a warning names damaged lines."""
    whole = data.rfind(b"\n") + 1
    found: dict[str, dict[str, Any]] = {}
    damaged: list[int] = []
    for number, line in enumerate(data[:whole].split(b"\n"), start=1):
        run = _run(line, path, number, form) if line.strip() else {}
        if run is None:
            damaged.append(number)
        elif run:
            found[run["key"]] = run
    if damaged:
        rows = f"row{'s' if len(damaged) > 1 else ''} {', '.join(map(str, damaged[:5]))}"
        more = f" and {len(damaged) - 5} others" if len(damaged) > 5 else ""
        hint = "the other runs are used; --resume makes the lost ones again"
        warnings.warn(f"{path}: {rows}{more}: not a stored run; {hint}", DamagedRunsWarning, stacklevel=3)
    return list(found.values()), whole


def _run(line: bytes, path: Path, number: int, form: Tables | None) -> dict[str, Any] | None:
    """The run of a line; None where it is damaged."""
    try:
        run = None if (text := unsealed(line)) is None else json_of(text, path, number)
    except BadInput:
        return None
    if not (isinstance(run, dict) and isinstance(run.get("key"), str) and isinstance(run.get("row"), dict)):
        return None
    rows = run.get("parameters")
    if not (isinstance(rows, list) and all(isinstance(row, dict) for row in rows)):
        return None
    whole = form is None or (
        _fits(run["row"], form.wide, form.keys)
        and all(_fits(run["row"] | row, form.long, (*form.keys, *form.long_keys)) for row in rows)
    )
    return run if whole else None


def _fits(row: Mapping[str, Any], columns: Mapping[str, str], keys: Iterable[str]) -> bool:
    """Whether a row has all its keys, and values of its columns' types."""
    types: dict[str, tuple[type, ...]] = {"string": (str,), "int": (int,), "bool": (bool,), "float": (int, float)}
    known = all(row.get(name) is None or type(row[name]) in types[kind] for name, kind in columns.items())
    stored = all(_storable(row.get(name), kind) for name, kind in columns.items())
    return known and stored and all(row.get(name) is not None for name in keys)


def _storable(value: Any, kind: str) -> bool:
    """Whether a column of Parquet holds a whole number exactly."""
    return type(value) is not int or abs(value) < (EXACT_BELOW if kind == "float" else 2**63)
