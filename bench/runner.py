"""Runs what a suite plans and keeps every finished run at once; it knows kinds of suites by `kinds.base.Kind` only."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from ..models.errors import BadInput
from .environment import code_version, environment
from .execution import UNLIMITED, Limits
from .kinds import kind_of
from .kinds.base import RunSelection, Spec, Suite
from .pool import Pool
from .store import MANIFEST, Store, read_manifest


def run(
    specs: Sequence[Spec],
    store: Store,
    pool: Pool,
    watch: Callable[[dict[str, Any]], object] | None = None,
    limits: Limits = UNLIMITED,
) -> None:
    """Execute what `store` does not hold yet, keep each run as it ends, and write the tables.

    `watch` is called with every finished run, which has the digest of its `content`, see `kinds.base.Kind.content`.
    """
    todo: list[Any] = [spec for spec in specs if spec.key not in store.finished]
    for spec, result, error in pool.outcomes(partial(limits.run, store.kind.execute), todo):
        finished = result if error is None else limits.failed(spec, f"{type(error).__name__}: {error}")
        finished["content"] = store.kind.content(spec)
        store.append(finished)
        if watch is not None:
            watch(finished)
    store.write_tables()


def open_store(directory: str | Path, suite: Suite, selection: RunSelection, specs: Sequence[Spec]) -> Store:
    """A new store for these runs, described by its manifest."""
    manifest = {
        "kind": suite.kind,
        "suite": suite.name,
        "title": suite.title,
        "suite_digest": suite.digest,
        "version": code_version(),
        "selection": asdict(selection),
        "planned": len(specs),
        "plan_digest": plan_digest(specs),
        **kind_of(suite.kind).facts(specs),
        "threads_per_worker": 1,
        **environment(),
    }
    return Store.create(directory, manifest)


def resume_store(directory: str | Path, suite: Suite, specs: Sequence[Spec]) -> Store:
    """The store of a started run, refused where it was made from another suite, selection or version."""
    manifest = read_manifest(Path(directory))
    expected = {
        "suite": suite.name,
        "version": code_version(),
        "suite_digest": suite.digest,
        "plan_digest": plan_digest(specs),
    }
    refuse_other(Path(directory), manifest, expected)
    return Store.resume(directory)


def refuse_other(directory: Path, manifest: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    """BadInput where a run was started with other values than those with which it is to be resumed."""
    named = {"suite_digest": "the suite's file", "plan_digest": "the selection of methods, vessels and seeds"}
    for name, value in expected.items():
        if manifest.get(name) != value:
            raise BadInput(
                f"cannot be resumed: {named.get(name, name)} differs from the one it was started with",
                file=directory / MANIFEST,
                hint="start again in a new directory",
            )


def plan_digest(specs: Iterable[Spec]) -> str:
    """Digest of the set of runs, whatever their order."""
    return hashlib.sha256("".join(sorted(spec.key for spec in specs)).encode()).hexdigest()[:16]
