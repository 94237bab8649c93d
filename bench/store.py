"""Results store: one JSON line per finished run while a suite runs, two Parquet tables when it is complete.

Which tables and columns there are depends on the kind of suite (`kinds.base.Tables`).

Each run is appended to the journal (`journal`) by one `write`, so that a killed process loses nothing that was
finished.  `environment.json` says what was run, and with what.
"""

from __future__ import annotations

import json
import os
from collections.abc import Generator, Iterable, Mapping
from contextlib import contextmanager
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import ConfigDict, Field

from ..models.data_file import load
from ..models.errors import BadInput
from ..models.folders import check_each, check_folder, check_regular, make_folder, write_all, write_atomic
from ..models.plain import plain
from ..models.temporary import leftovers, remove_leftovers
from ..models.yaml_file import Count, FileContent, Text, checked, needs
from .journal import RUNS, lock, open_journal, read_runs, sealed, unsealed
from .kinds import IDENTIFICATION, kind_names, kind_of
from .kinds.base import Kind, RunKind, Tables

if TYPE_CHECKING:
    import pandas as pd

MANIFEST = "environment.json"


# ---- What `environment.json` holds, as far as anything is read from it.

WholeNumber = Annotated[int, Field(strict=True, ge=0), needs("a whole number of at least 0")]


class _Selected(FileContent):
    """What of the suite was asked for; see `kinds.base.RunSelection`."""

    model_config = ConfigDict(extra="allow", frozen=True)

    suite: Text = "quick"
    methods: tuple[Text, ...] | None = None
    vessels: tuple[Text, ...] | None = None
    seeds: Count | None = None
    seed: WholeNumber | None = None


class MergedFile(FileContent):
    """Results that were merged: digest of their journal, how many runs were added, how many of them were computed again
    with which seed of the sample, and which runs of the sample could not be."""

    journal: Text
    added: WholeNumber
    recomputed: WholeNumber
    seed: WholeNumber
    not_computable: tuple[Text, ...] = ()


class ManifestFile(FileContent):
    """Keys that reports and `--resume` read; the others say with what the run was made."""

    model_config = ConfigDict(extra="allow", frozen=True)

    suite: Text
    version: Text
    planned: WholeNumber
    kind: Text = "identification"
    title: Text = ""
    selection: _Selected = _Selected()
    seeds: Text = ""
    packages: dict[str, Any] | None = None
    merged: tuple[MergedFile, ...] = ()


def stored_kind(manifest: Mapping[str, Any]) -> Kind:
    """The kind of suite of a run directory, by its manifest."""
    return kind_of(manifest.get("kind", IDENTIFICATION))


class Store:
    """The directory of one suite run, open for this process alone until it is closed.

    Use `Store.create` for a new run and `Store.resume` for a started one; both raise `BadInput` where the directory
    does not allow it, before anything is written.
    """

    def __init__(self, directory: Path, manifest: Mapping[str, Any], kind: RunKind | None = None) -> None:
        self.directory, self.manifest = directory, dict(manifest)
        self.kind = kind or stored_kind(manifest)
        form = self.kind.tables
        check_each(directory, (RUNS,), (MANIFEST, form.wide_file, form.long_file))
        self._file: int | None
        self._file, runs = open_journal(directory / RUNS, form)
        remove_leftovers(directory)
        self._runs = {run["key"]: _without_trace(run) for run in runs}

    @classmethod
    def create(cls, directory: str | Path, manifest: Mapping[str, Any], kind: RunKind | None = None) -> Store:
        """A store in a new or empty directory; kind None: that of the suite."""
        directory = Path(directory)
        check_vacant(directory)
        make_folder(directory)
        with locked(directory):
            check_vacant(directory)
            _write_manifest(directory, manifest)
            return cls(directory, manifest, kind)

    @classmethod
    def resume(cls, directory: str | Path, kind: RunKind | None = None) -> Store:
        """The store of a started run; a last line that a kill tore is cut off."""
        directory = Path(directory)
        return cls(directory, read_manifest(directory, *(() if kind is None else (kind.name,))), kind)

    @property
    def finished(self) -> frozenset[str]:
        """Keys of the runs that are stored."""
        return frozenset(self._runs)

    @property
    def runs(self) -> list[dict[str, Any]]:
        """The stored runs in the order of their result rows."""
        order = itemgetter(*self.kind.tables.keys)
        return sorted(self._runs.values(), key=lambda run: order(run["row"]))

    def append(self, run: Mapping[str, Any]) -> None:
        """Keep one finished run, `{"key", "row", "parameters"}`, at once; a `trace` of it is not held in memory."""
        if self._file is None:
            raise ValueError("the store is closed")
        line = sealed(run)
        write_all(self._file, line, self.directory / RUNS)
        self._runs[run["key"]] = _without_trace(json.loads(unsealed(line.rstrip()) or b""))

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

    def note_merged(self, planned: int, merged: Mapping[str, Any]) -> None:
        """Let the manifest plan at least so many runs, and say what of them comes from elsewhere."""
        self.manifest["planned"] = max(planned, self.manifest["planned"])
        self.manifest["merged"] = [*self.manifest.get("merged", ()), merged]
        _write_manifest(self.directory, self.manifest)

    def write_tables(self) -> None:
        """Write the Parquet tables, each by one atomic replacement."""
        for name, (columns, rows) in tables(self._runs.values(), self.kind.tables).items():
            write_atomic(self.directory / name, _parquet(columns, rows))


def _without_trace(run: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in run.items() if name != "trace"}


def check_vacant(directory: Path) -> None:
    """Refuse a path that is no directory, or one that holds anything; a started run has a manifest."""
    check_folder(directory)
    if directory.is_dir() and set(directory.iterdir()) - set(leftovers(directory)):
        hint = "continue it with --resume or give a new directory with -o" if (directory / MANIFEST).exists() else None
        raise BadInput("directory is not empty", file=directory, hint=hint or "give a new directory with -o")


def read_manifest(directory: Path, *kinds: str) -> dict[str, Any]:
    """`environment.json` of a run directory.

    kinds : of what may have been run; none: a suite of any kind.
    """
    path = directory / MANIFEST
    if not check_regular(path):
        raise BadInput("holds no benchmark run", file=directory, hint=f"{MANIFEST} is missing")
    manifest = load(path)
    if not isinstance(manifest, dict) or not {"suite", "version", "planned"} <= manifest.keys():
        raise BadInput("is not the manifest of a benchmark run", file=path)
    known = kinds or kind_names()
    if (kind := checked(ManifestFile, manifest, path).kind) not in known:
        raise BadInput(f"unknown kind {kind!r}", file=path, hint=f"known: {', '.join(known)}")
    return manifest


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
    if check_regular(wide) and check_regular(long):
        try:
            return pd.read_parquet(wide), pd.read_parquet(long)
        except (OSError, ValueError) as error:
            raise BadInput(f"cannot be read ({error})", file=wide) from None
    return frames(read_runs(directory / RUNS, form), form)


def frames(runs: Iterable[Mapping[str, Any]], form: Tables):
    """Both tables of runs as two pandas frames with the columns and types of the stored tables."""
    wide, long = (_table(columns, rows).to_pandas() for columns, rows in tables(runs, form).values())
    return wide, long


@contextmanager
def locked(directory: Path) -> Generator[None]:
    """Hold a directory for this process alone; `BadInput` where another process holds it."""
    try:
        file = os.open(directory, os.O_RDONLY)
    except PermissionError:  # a platform on which a directory cannot be opened
        yield
        return
    try:
        lock(file, directory / RUNS)
        yield
    finally:
        os.close(file)


def _write_manifest(directory: Path, manifest: Mapping[str, Any]) -> None:
    text = json.dumps(plain(manifest), indent=1, allow_nan=False, ensure_ascii=False)
    write_atomic(directory / MANIFEST, text.encode() + b"\n")


def _sorted(rows: Iterable[Mapping[str, Any]], columns: Mapping[str, str], keys: Iterable[str]) -> list[dict[str, Any]]:
    return sorted(({name: row.get(name) for name in columns} for row in rows), key=itemgetter(*keys))


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
