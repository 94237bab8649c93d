"""Stored results stand for runs with the same content, so that a new method or seed costs only its own runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..models.errors import BadInput
from .journal import RUNS, read_runs
from .kinds.base import Kind, Spec
from .store import Store, read_manifest, stored_kind
from .traces import traces_by_row


def check_folders(folders: Sequence[Path], kind: Kind) -> None:
    """Raise `BadInput` for a folder that holds no results, or those of another kind of suite."""
    for folder in folders:
        if stored_kind(read_manifest(folder)) is not kind:
            raise BadInput("holds results of another kind of suite", file=folder)


def take(specs: Sequence[Spec], store: Store, folders: Sequence[Path]) -> int:
    """Append the results that folders hold for runs which `store` lacks, and return how many there were.

    Failed runs are not taken.
    """
    before = len(store.finished)
    for folder in folders:
        for run in _taken(_wanted(specs, store), folder, store):
            store.append(run)
    return len(store.finished) - before


def _wanted(specs: Sequence[Spec], store: Store) -> dict[str, Spec]:
    """The runs that are missing, by their content."""
    missing = [spec for spec in specs if spec.key not in store.finished]
    return {content: spec for spec in missing if (content := store.kind.content(spec)) is not None}


def _taken(wanted: Mapping[str, Spec], folder: Path, store: Store) -> list[dict[str, Any]]:
    """Runs of a folder under the keys and names that this suite gives them."""
    form, found = store.kind.tables, []
    traces = traces_by_row(folder)
    for run in read_runs(folder / RUNS, form):
        spec = wanted.get(str(run.get("content")))
        if spec is not None and run["row"]["status"] != "failed":
            trace = traces(run["row"], form.keys)
            own = {**run, "key": spec.key, "row": run["row"] | spec.row_key()}
            found.append(own | ({"trace": trace} if trace else {}))
    return found
