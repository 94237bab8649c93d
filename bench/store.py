"""Results store: one JSON line per finished run while a suite runs, two Parquet tables when it is complete.

Which tables and columns there are depends on the kind of suite (`kinds.base.Tables`).

`runs.jsonl` is only ever appended to, one `write` per finished run, so that a killed process loses nothing that was
finished; an incomplete last line is dropped when the store is opened again, a damaged line between is passed over, with
a warning, and its run made again.  `environment.json` says what was run, and with what.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.data_file import json_of, load
from ..models.errors import BadInput
from ..models.plain import EXACT_BELOW, plain
from .kinds import IDENTIFICATION, kind_names, kind_of
from .kinds.base import Kind, Tables
from .traces import TRACES, trace_line

if TYPE_CHECKING:
    import pandas as pd

RUNS, MANIFEST = "runs.jsonl", "environment.json"
TIMING = "timing.json"
"""Output of `pytest --benchmark-json`, shown by the report where it lies in the directory."""


class DamagedRunsWarning(UserWarning):
    """Lines of a journal are not stored runs; the others are used."""


def stored_kind(manifest: Mapping[str, Any]) -> Kind:
    """The kind of suite of a run directory, by its manifest."""
    return kind_of(manifest.get("kind", IDENTIFICATION))


class Store:
    """The directory of one suite run, open for this process alone until it is closed.

    Use `Store.create` for a new run and `Store.resume` for a started one; both raise `BadInput` where the directory
    does not allow it, before anything is written.
    """

    def __init__(self, directory: Path, manifest: Mapping[str, Any]) -> None:
        self.directory, self.manifest = directory, dict(manifest)
        self.kind = stored_kind(manifest)
        self._file: int | None = _open_for_append(directory / RUNS)
        for torn in _leftovers(directory):
            torn.unlink(missing_ok=True)
        self._runs = {run["key"]: run for run in read_runs(directory / RUNS, self.kind.tables)[0]}

    @classmethod
    def create(cls, directory: str | Path, manifest: Mapping[str, Any]) -> Store:
        """A store in a new or empty directory."""
        directory = Path(directory)
        check_vacant(directory)
        directory.mkdir(parents=True, exist_ok=True)
        with locked(directory):
            check_vacant(directory)
            write_atomic(directory / MANIFEST, _json(manifest, indent=1).encode() + b"\n")
            return cls(directory, manifest)

    @classmethod
    def resume(cls, directory: str | Path) -> Store:
        """The store of a started run; a last line that a kill tore is cut off."""
        directory = Path(directory)
        return cls(directory, read_manifest(directory))

    @property
    def finished(self) -> frozenset[str]:
        """Keys of the runs that are stored."""
        return frozenset(self._runs)

    @property
    def runs(self) -> list[dict[str, Any]]:
        """The stored runs in the order of their result rows."""
        return sorted(self._runs.values(), key=lambda run: _order(run["row"], self.kind.tables.keys))

    def append(self, run: Mapping[str, Any]) -> None:
        """Keep one finished run, `{"key", "row", "parameters"}`, at once; its `trace`, if any, in a file of its own."""
        if self._file is None:
            raise ValueError("the store is closed")
        run = dict(run)
        if trace := run.pop("trace", None):
            with (self.directory / TRACES).open("ab") as file:
                file.write(trace_line(run["row"], self.kind.tables.keys, trace))
        line = _json(run)
        _write_all(self._file, line.encode() + b"\n")
        self._runs[run["key"]] = json.loads(line)

    def close(self) -> None:
        """Flush the appended runs to the disk."""
        if self._file is not None:
            os.fsync(self._file)
            os.close(self._file)
            self._file = None

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def enlarge(self, planned: int) -> None:
        """Let the manifest plan at least so many runs, after results were added from elsewhere."""
        if planned > self.manifest["planned"]:
            self.manifest["planned"] = planned
            write_atomic(self.directory / MANIFEST, _json(self.manifest, indent=1).encode() + b"\n")

    def write_tables(self) -> None:
        """Write the Parquet tables, each by one atomic replacement."""
        for name, (columns, rows) in tables(self._runs.values(), self.kind.tables).items():
            write_atomic(self.directory / name, _parquet(columns, rows))


def check_vacant(directory: Path, manifest: str = MANIFEST) -> None:
    """Refuse a path that is no directory, or one that holds anything; a started run has a manifest."""
    if directory.exists() and not directory.is_dir():
        raise BadInput("is not a directory", file=directory, hint="give a new directory with -o")
    if directory.is_dir() and set(directory.iterdir()) - set(_leftovers(directory)):
        hint = "continue it with --resume or give a new directory with -o" if (directory / manifest).exists() else None
        raise BadInput("directory is not empty", file=directory, hint=hint or "give a new directory with -o")


def read_manifest(directory: Path) -> dict[str, Any]:
    """`environment.json` of a run directory."""
    from ..models.yaml_file import checked
    from .manifest_file import ManifestFile

    path = directory / MANIFEST
    if not path.is_file():
        raise BadInput("holds no benchmark run", file=directory, hint=f"{MANIFEST} is missing")
    manifest = load(path)
    if not isinstance(manifest, dict) or not {"suite", "version", "planned"} <= manifest.keys():
        raise BadInput("is not the manifest of a benchmark run", file=path)
    if checked(ManifestFile, manifest, path).kind not in kind_names():
        raise BadInput(f"unknown kind {manifest['kind']!r}", file=path, hint=f"known: {', '.join(kind_names())}")
    return manifest


def read_runs(path: Path, form: Tables | None = None) -> tuple[list[dict[str, Any]], int]:
    """Stored runs, the last one of each key, and the number of bytes that hold whole lines.

    form : of the tables that the runs' rows must fit.

    A torn last line is left out, and any other line that is not a stored run, with a `DamagedRunsWarning`.
    """
    data = path.read_bytes() if path.exists() else b""
    found, damaged, whole = _whole_runs(data, path, form)
    if damaged:
        rows = f"row{'s' if len(damaged) > 1 else ''} {', '.join(map(str, damaged[:5]))}"
        more = f" and {len(damaged) - 5} others" if len(damaged) > 5 else ""
        hint = "the other runs are used; --resume makes the lost ones again"
        warnings.warn(f"{path}: {rows}{more}: not a stored run; {hint}", DamagedRunsWarning, stacklevel=2)
    return list(found.values()), whole


def new_runs(path: Path, begin: int, form: Tables) -> tuple[list[dict[str, Any]], int]:
    """Runs that another process has stored behind the byte `begin`, and the byte behind the last whole line."""
    try:
        with path.open("rb") as file:
            file.seek(begin)
            data = file.read()
    except FileNotFoundError:
        return [], begin
    found, _, whole = _whole_runs(data, path, form)
    return list(found.values()), begin + whole


def _whole_runs(data: bytes, path: Path, form: Tables | None) -> tuple[dict[str, dict[str, Any]], list[int], int]:
    """Runs by their keys, numbers of damaged lines, and the number of bytes that hold whole lines."""
    whole = data.rfind(b"\n") + 1
    found: dict[str, dict[str, Any]] = {}
    damaged: list[int] = []
    for number, line in enumerate(data[:whole].split(b"\n"), start=1):
        run = _run(line, path, number, form) if line.strip() else {}
        if run is None:
            damaged.append(number)
        elif run:
            found[run["key"]] = run
    return found, damaged, whole


def tables(
    runs: Iterable[Mapping[str, Any]], form: Tables
) -> dict[str, tuple[Mapping[str, str], list[dict[str, Any]]]]:
    """Both tables as `file name -> (column kinds, sorted rows)`."""
    runs = list(runs)
    wide = [run["row"] for run in runs]
    long = [run["row"] | row for run in runs for row in run["parameters"]]
    return {
        form.wide_file: (form.wide, _sorted(wide, form.wide, form.keys)),
        form.long_file: (form.long, _sorted(long, form.long, (*form.keys, *form.long_keys))),
    }


def read_tables(directory: str | Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The two tables of a run directory as pandas frames, complete or not.

    The Parquet tables are read where they exist, else the finished runs of `runs.jsonl`.
    """
    import pandas as pd

    directory = Path(directory)
    form = stored_kind(read_manifest(directory)).tables
    wide, long = directory / form.wide_file, directory / form.long_file
    if wide.exists() and long.exists():
        try:
            return pd.read_parquet(wide), pd.read_parquet(long)
        except (OSError, ValueError) as error:
            raise BadInput(f"cannot be read ({error})", file=wide) from None
    return frames(read_runs(directory / RUNS, form)[0], form)


def frames(runs: Iterable[Mapping[str, Any]], form: Tables):
    """Both tables of runs as two pandas frames with the columns and types of the stored tables."""
    wide, long = (_table(columns, rows).to_pandas() for columns, rows in tables(runs, form).values())
    return wide, long


def _leftovers(directory: Path) -> list[Path]:
    """Files that `write_atomic` was writing when its process was killed."""
    return list(directory.glob(".*.tmp"))


def write_atomic(path: Path, data: bytes) -> None:
    """Write a file whole or not at all."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        temporary.write_bytes(data)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _run(line: bytes, path: Path, number: int, form: Tables | None) -> dict[str, Any] | None:
    """The run of a line; None where it is damaged."""
    try:
        run = json_of(line, path, number)
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


@contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Hold a directory for this process alone; `BadInput` where another process holds it."""
    try:
        file = os.open(directory, os.O_RDONLY)
    except PermissionError:  # a platform on which a directory cannot be opened
        yield
        return
    try:
        _lock(file, directory / RUNS)
        yield
    finally:
        os.close(file)


def is_held(path: Path) -> bool:
    """Whether a process is writing a journal."""
    try:
        file = os.open(path, os.O_RDWR)
    except FileNotFoundError:
        return False
    try:
        _lock(file, path)
    except BadInput:
        return True
    finally:
        os.close(file)
    return False


def _open_for_append(path: Path) -> int:
    """Open the log for this process alone, behind its last whole line."""
    file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o644)
    try:
        _lock(file, path)
        os.ftruncate(file, read_runs(path)[1])
    except BaseException:
        os.close(file)
        raise
    return file


def _lock(file: int, path: Path) -> None:
    try:
        import fcntl
    except ImportError:  # no advisory locks on this platform
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        raise BadInput("another run is writing here", file=path.parent) from None


def _write_all(file: int, data: bytes) -> None:
    while data:
        data = data[os.write(file, data) :]


def _json(value: Any, indent: int | None = None) -> str:
    return json.dumps(plain(value), indent=indent, allow_nan=False, ensure_ascii=False)


def _sorted(rows: Iterable[Mapping[str, Any]], columns: Mapping[str, str], keys: Iterable[str]) -> list[dict[str, Any]]:
    keys = list(keys)
    return sorted(({name: row.get(name) for name in columns} for row in rows), key=lambda row: _order(row, keys))


def _order(row: Mapping[str, Any], keys: Iterable[str]) -> list[Any]:
    return [row[key] for key in keys]


def _table(columns: Mapping[str, str], rows: list[dict[str, Any]]):
    import pyarrow as pa

    types = {"string": pa.string(), "int": pa.int64(), "bool": pa.bool_(), "float": pa.float64()}
    schema = pa.schema([(name, types[kind]) for name, kind in columns.items()])
    return pa.Table.from_pylist(rows, schema=schema)


def _parquet(columns: Mapping[str, str], rows: list[dict[str, Any]]) -> bytes:
    import pyarrow as pa
    import pyarrow.parquet as pq

    sink = pa.BufferOutputStream()
    pq.write_table(_table(columns, rows), sink)
    return sink.getvalue().to_pybytes()
