"""Results from elsewhere: checked, a sample of their runs computed again, and merged into a folder.

Only runs that this installation plans itself are taken: their key is the digest of what was run.  What was not computed
again is marked: in the journal by run, in the manifest, from which reports tell it, with the seed of the sample.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..datasets import randomness
from ..models.errors import BadInput
from ..models.extras import INSTALL
from ..models.folders import read_regular
from .environment import code_version, environment
from .execution import ENDED
from .journal import RUNS, read_runs
from .kinds import kind_of
from .kinds.base import TIMES, Kind, RunKind, RunSelection, Spec, Suite
from .kinds.identification.own import is_file_name
from .store import Store, read_manifest, stored_kind
from .suites import Trust, check_trust, load_suite

TOLERANCE = 1e-3
"""Relative difference of a score up to which another machine's rounding explains it."""
ERROR_FLOOR = 1e-9
SHARE, LEAST = 0.05, 30
"""Share of the added runs that are computed again, and the least number of them; all where there are fewer."""
NAMING = ("method", "vessel", "model", "train", "noise", "disturbance", "seed")
"""Columns that name a run in a message."""
Run = Mapping[str, Any]


@dataclass(frozen=True)
class MergeCounts:
    """What was merged: runs added, runs that were there already, runs computed again and found equal.

    seed : it draws the same sample again.  not_computable : runs of the sample that cannot be computed here, with the
    reason; others were drawn for them.
    """

    added: int
    known: int
    recomputed: int
    seed: int
    not_computable: tuple[str, ...]


def merge(
    source: str | Path, target: str | Path, sample: int | None = None, seed: int | None = None, trust: Trust = False
) -> MergeCounts:
    """Check the results in `source` and add them to those in `target`, of the same suite.

    sample : number of added runs that are computed again; None: see `sample_size`.  seed : from which they are drawn;
    None: a new one, which nobody knows before.

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
    suite = _suite(ours, target, trust)
    specs = _planned(theirs, ours, suite, source, trust) | _planned(ours, ours, suite, target, trust)
    _check_runs(runs, specs, kind.tables.keys, source / RUNS)
    held = {run["key"] for run in read_runs(target / RUNS, kind.tables)}
    new = sorted((run for run in runs if run["key"] not in held), key=lambda run: run["key"])
    seed = randomness.drawn_seed() if seed is None else seed
    again, told = _sampled(kind, new, specs, sample_size(len(new)) if sample is None else sample, seed, source / RUNS)
    if new:
        _add(new, specs, again, {"seed": seed, "not_computable": told}, source, target)
    return MergeCounts(len(new), len(runs) - len(new), len(again), seed, tuple(told))


def sample_size(runs: int) -> int:
    """How many of so many added runs are computed again: 5 %, at least 30, all where there are fewer.

    Of 30, one at least is forged with a probability of 95 % where 10 % of the runs are.
    """
    return min(runs, max(LEAST, math.ceil(SHARE * runs)))


def _sampled(
    kind: Kind, new: Sequence[Run], specs: Mapping[str, Spec], sample: int, seed: int, path: Path
) -> tuple[dict[str, Run], list[str]]:
    """Runs of the sample as they were computed again, by their keys, and those that cannot be computed here."""
    again: dict[str, Run] = {}
    told: list[str] = []
    for i in np.random.default_rng(seed).permutation(len(new)).tolist():
        if len(again) >= sample:
            break
        run = new[i]
        found = _computed(kind, specs[run["key"]], run)
        if isinstance(found, str):
            told.append(f"{_named(run)}: {found}")
        else:
            _compare_runs(kind, found, run, path)
            again[run["key"]] = found
    return again, told


def _computed(kind: Kind, spec: Any, run: Run) -> Run | str:
    """A run computed again, or why that is not possible here."""
    try:
        kind.check([spec])
    except BadInput as error:
        return str(error)
    error = str(run["row"].get("error") or "")
    if run["row"]["status"] == "failed" and error.startswith(ENDED):
        return f"a limit of the other machine ended it ({error})"
    found = json.loads(json.dumps(kind.execute(spec), default=float))
    error = str(found["row"].get("error") or "")
    return error if found["row"]["status"] == "failed" and INSTALL in error else found


def _check_manifests(theirs: Mapping[str, Any], ours: Mapping[str, Any], source: Path) -> None:
    for name in ("suite", "suite_digest", "kind", "held_out_seed"):
        if theirs.get(name) != ours.get(name):
            told = f"its {name} is {theirs.get(name)!r}, that of the target {ours.get(name)!r}"
            raise BadInput(told, file=source, hint="results of the same suite are merged")
    _check_version(theirs, source)


def _check_version(manifest: Mapping[str, Any], folder: Path) -> None:
    if manifest["version"] != code_version():
        told = f"was made by version {manifest['version']}, this is {code_version()}"
        raise BadInput(told, file=folder, hint="run the suite with this version")


def _suite(manifest: Mapping[str, Any], folder: Path, trust: Trust) -> Suite:
    """The suite of the target, which is that of the source by its digest; a path that the source names is not read."""
    suite = load_suite(manifest.get("selection", {}).get("suite", manifest["suite"]))
    if suite.digest != manifest.get("suite_digest"):
        raise BadInput("its suite is not the one of this installation", file=folder)
    check_trust(suite.texts, folder, trust)
    return suite


def _planned(
    manifest: Mapping[str, Any], ours: Mapping[str, Any], suite: Suite, folder: Path, trust: Trust
) -> dict[str, Spec]:
    """Every run that a manifest's selection plans here, by its key."""
    stored = manifest.get("selection", {})
    methods, vessels = (tuple(stored.get(name) or ()) for name in ("methods", "vessels"))
    check_trust(methods, folder, trust)
    known = ours.get("selection", {}).get("vessels") or ()
    foreign = [one for one in vessels if is_file_name(one) and one not in known]
    if foreign:
        told = f"names a file that the target does not: {foreign[0]!r}"
        raise BadInput(told, file=folder, hint="it is not read, and nothing was merged")
    own = RunSelection(suite.name, methods, vessels, stored.get("seeds"), stored.get("seed"))
    return {spec.key: spec for spec in kind_of(suite.kind).plan(suite, own)}


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


def _compare_runs(kind: Kind, found: Run, run: Run, path: Path) -> None:
    """Compare scores and parameters of a run with those computed again, in every column of the tables."""
    form, who = kind.tables, _named(run)
    _compare(found["row"], run["row"], form.wide, who, path)
    key = form.long_keys[0]
    names, others = ([row.get(key) for row in one["parameters"]] for one in (found, run))
    if names != others:
        told = f"{who}: {key} is {others}, computed again {names}"
        raise BadInput(told, file=path, column=key, hint="nothing was merged")
    for mine, theirs in zip(found["parameters"], run["parameters"], strict=True):
        _compare(found["row"] | mine, run["row"] | theirs, form.long, f"{who}, {key} {mine[key]}", path)


def _compare(mine: Run, theirs: Run, columns: Iterable[str], who: str, path: Path) -> None:
    for name in columns:
        value, other = mine.get(name), theirs.get(name)
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


def _add(
    new: Sequence[Run], specs: Mapping[str, Spec], again: Mapping[str, Run], facts: Run, source: Path, target: Path
) -> None:
    """Mark and append the new runs, with the traces computed here or else theirs, and write the target's tables."""
    digest = hashlib.sha256(read_regular(source / RUNS)).hexdigest()[:16]
    entry = {"journal": digest, "added": len(new), "recomputed": len(again), **facts}
    with Store.resume(target) as store:
        store.note_merged(len(store.finished | {run["key"] for run in new}), entry)
        for run in new:
            trace = again.get(run["key"], run).get("trace")
            marked = _marked(run, specs[run["key"]], store.kind, run["key"] in again)
            store.append(marked | ({"trace": trace} if trace else {}))
        store.write_tables()


def _marked(run: Run, spec: Any, kind: RunKind, recomputed: bool) -> dict[str, Any]:
    """What is stored of a run from elsewhere; with the content by which `reuse` takes it if it was computed again."""
    row = {name: run["row"][name] for name in kind.tables.wide if name in run["row"]}
    rows = [{name: one[name] for name in kind.tables.long if name in one} for one in run["parameters"]]
    content = kind.content(spec) if recomputed else None
    return {"key": run["key"], "row": row, "parameters": rows, "content": content, "recomputed": recomputed}


# ---- Stored results of the same code stand for runs with the same content, so that another method, of a file of the
# user's own, or another seed costs only its own runs.


def check_folders(folders: Sequence[Path], kind: Kind) -> None:
    """Raise `BadInput` for a folder without results, or with those of another kind of suite, code or packages."""
    for folder in folders:
        manifest = read_manifest(folder)
        if stored_kind(manifest) is not kind:
            raise BadInput("holds results of another kind of suite", file=folder)
        _check_version(manifest, folder)
        if manifest.get("packages") != environment()["packages"]:
            raise BadInput("was made with other versions of packages", file=folder, hint="run the suite anew")


def take(specs: Sequence[Spec], store: Store, folders: Sequence[Path]) -> int:
    """Append the results that folders hold for runs which `store` lacks, and return how many there were.

    Failed runs are not taken.
    """
    before = len(store.finished)
    for folder in folders:
        missing = [spec for spec in specs if spec.key not in store.finished]
        wanted = {content: spec for spec in missing if (content := store.kind.content(spec)) is not None}
        for run in read_runs(folder / RUNS, store.kind.tables):
            spec = wanted.get(str(run.get("content")))
            if spec is not None and run["row"]["status"] != "failed":
                store.append({**run, "key": spec.key, "row": run["row"] | spec.row_key()})
    return len(store.finished) - before
