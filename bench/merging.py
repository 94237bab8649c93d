"""Results from elsewhere: checked, a sample of their runs computed again, and merged into a folder.

Only runs that this installation plans itself are taken: their key is the digest of what was run.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..models.errors import BadInput
from .environment import code_version
from .journal import RUNS, read_runs
from .kinds import kind_of
from .kinds.base import TIMES, Kind, Selection, Spec
from .store import Store, read_manifest, stored_kind
from .suites import load_suite
from .traces import traces_by_row
from .trust import Trust, check_trust

TOLERANCE = 1e-3
"""Relative difference of a score up to which another machine's rounding explains it."""
ERROR_FLOOR = 1e-9
NAMING = ("method", "vessel", "model", "train", "noise", "disturbance", "seed")
"""Columns that name a run in a message."""


@dataclass(frozen=True)
class Merged:
    """What was merged: runs added, runs that were there already, runs computed again and found equal."""

    added: int
    known: int
    recomputed: int


def merge(source: str | Path, target: str | Path, sample: int = 5, seed: int = 0, trust: Trust = False) -> Merged:
    """Check the results in `source` and add them to those in `target`, of the same suite.

    sample : number of runs that are computed again; seed : from which they are drawn.

    Raises
    ------
    BadInput : another suite or version, a run that the suite does not plan or that has a wrong row, or a score that is
        not found again.  Nothing is written then.
    """
    source, target = Path(source), Path(target)
    theirs, ours = read_manifest(source), read_manifest(target)
    _check_manifests(theirs, ours, source)
    kind = stored_kind(theirs)
    runs = read_runs(source / RUNS, kind.tables)
    if not runs:
        raise BadInput("holds no finished run", file=source / RUNS)
    specs = _planned(theirs, source, trust) | _planned(ours, target, trust)
    _check_runs(runs, specs, kind.tables.keys, source / RUNS)
    again = np.random.default_rng(seed).permutation(len(runs))[:sample]
    for i in again:
        _check_again(kind, runs[int(i)], specs[runs[int(i)]["key"]], source / RUNS)
    return _add(runs, source, target, len(again))


def _check_manifests(theirs: Mapping[str, Any], ours: Mapping[str, Any], source: Path) -> None:
    for name in ("suite", "suite_digest", "kind", "held_out_seed"):
        if theirs.get(name) != ours.get(name):
            told = f"its {name} is {theirs.get(name)!r}, that of the target {ours.get(name)!r}"
            raise BadInput(told, file=source, hint="results of the same suite are merged")
    if theirs["version"] != code_version():
        told = f"was made by version {theirs['version']}, this is {code_version()}"
        raise BadInput(told, file=source, hint="run the suite with this version")


def _planned(manifest: Mapping[str, Any], folder: Path, trust: Trust) -> dict[str, Spec]:
    """Every run that a manifest's selection plans here, by its key."""
    stored = manifest.get("selection", {})
    methods, vessels = (tuple(stored.get(name) or ()) for name in ("methods", "vessels"))
    check_trust(methods, folder, trust)
    suite = load_suite(stored.get("suite", manifest["suite"]))
    if suite.digest != manifest.get("suite_digest"):
        raise BadInput("its suite is not the one of this installation", file=folder)
    selection = Selection(stored.get("suite", "quick"), methods, vessels, stored.get("seeds"), stored.get("seed"))
    return {spec.key: spec for spec in kind_of(suite.kind).plan(suite, selection)}


def _check_runs(runs: Sequence[Mapping[str, Any]], specs: Mapping[str, Spec], keys: Sequence[str], path: Path) -> None:
    for run in runs:
        spec = specs.get(run["key"])
        if spec is None:
            told = f"{_named(run)} is not planned by its suite and selection: key {run['key']!r}"
            raise BadInput(told, file=path, column="key", hint="run the suite with this version, without other changes")
        planned = spec.row_key()
        for name in keys:
            if run["row"].get(name) != planned[name]:
                told = f"{_named(run)}: {name} is {run['row'].get(name)!r}, planned is {planned[name]!r}"
                raise BadInput(told, file=path, column=name, hint="nothing was merged")


def _named(run: Mapping[str, Any]) -> str:
    """A run in words; what its row does not hold is left out."""
    row = run["row"]
    return "run " + ", ".join(f"{name} {row[name]}" for name in NAMING if row.get(name) is not None)


def _check_again(kind: Kind, run: Mapping[str, Any], spec: Any, path: Path) -> None:
    """Compute a run again and compare its scores and its parameters."""
    found = json.loads(json.dumps(kind.execute(spec), default=float))
    _compare(found["row"], run["row"], _named(run), path)
    key = kind.tables.long_keys[0]
    names, others = ([row.get(key) for row in one["parameters"]] for one in (found, run))
    if names != others:
        told = f"{_named(run)}: {key} is {others}, computed again {names}"
        raise BadInput(told, file=path, column=key, hint="nothing was merged")
    for mine, theirs in zip(found["parameters"], run["parameters"], strict=True):
        _compare(mine, theirs, f"{_named(run)}, {key} {mine[key]}", path)


def _compare(mine: Mapping[str, Any], theirs: Mapping[str, Any], who: str, path: Path) -> None:
    for name, value in mine.items():
        other = theirs.get(name)
        if name not in TIMES and name != "error" and not _same(value, other):
            told = f"{who}: {name} is {other}, computed again it is {value}"
            raise BadInput(told, file=path, column=name, hint="nothing was merged")


def _same(value: Any, other: Any) -> bool:
    missing = [v is None or (isinstance(v, float) and not math.isfinite(v)) for v in (value, other)]
    if any(missing):
        return all(missing)
    if isinstance(value, bool | str) or isinstance(other, bool | str):
        return value == other
    return math.isclose(value, other, rel_tol=TOLERANCE, abs_tol=ERROR_FLOOR)


def _add(runs: Sequence[Mapping[str, Any]], source: Path, target: Path, recomputed: int) -> Merged:
    """Append the runs that the target does not hold, with their traces, and write its tables."""
    traces, added = traces_by_row(source), 0
    with Store.resume(target) as store:
        held = store.finished
        for run in runs:
            if run["key"] in held:
                continue
            trace = traces(run["row"], store.kind.tables.keys)
            store.append({**run, **({"trace": trace} if trace else {})})
            added += 1
        store.enlarge(len(store.finished))
        store.write_tables()
    return Merged(added, len(runs) - added, recomputed)
