"""The report of a run directory, by the kind of its suite."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape
from importlib import import_module
from pathlib import Path
from typing import Any

from ..bench.kinds import DIAGNOSIS, IDENTIFICATION
from ..bench.store import read_manifest, read_tables, stored_kind
from ..models.argument_types import typed
from ..models.folders import check_each, write_atomic
from .tables import csv as as_csv
from .tables import from_frame

PAGES = {IDENTIFICATION: ".leaderboard.page", DIAGNOSIS: ".diagnosis_suite.page"}
"""Kind of suite -> the module that writes its report."""
RUNS_CSV = "runs.csv"


@dataclass(frozen=True)
class Report:
    """What `write_report` wrote: Markdown text, files, whether all planned runs are in it, overall standings.

    `overview` is what a terminal shows of it: how the runs ended and one table.
    """

    markdown: str
    overview: str
    paths: tuple[Path, ...]
    complete: bool
    standings: tuple[dict[str, Any], ...]

    def _repr_html_(self) -> str:
        files = "".join(f"<li>{escape(str(path))}</li>" for path in self.paths)
        return f"<pre>{escape(self.overview)}</pre><ul>{files}</ul>"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for `--json`."""
        files = [str(path) for path in self.paths]
        return {"complete": self.complete, "files": files, "leaderboard": list(self.standings)}


@typed
def write_report(directory: str | Path, *, csv: bool = False) -> Report:
    """Report a run directory by the kind of its suite; raises what the report of that kind does.

    Parameters
    ----------
    csv : write the stored tables as CSV too: runs.csv, a row a run, and parameters.csv (suites of kind
        diagnosis: diagnosis_sizes.csv), a row a run and parameter.
    """
    directory = Path(directory)
    kind = read_manifest(directory).get("kind", IDENTIFICATION)
    written = import_module(PAGES[kind], __package__).write_report(directory)
    return replace(written, paths=(*written.paths, *_write_rows(directory))) if csv else written


def _write_rows(directory: Path) -> tuple[Path, ...]:
    """The two stored tables as CSV."""
    names = (RUNS_CSV, Path(stored_kind(read_manifest(directory)).tables.long_file).with_suffix(".csv").name)
    frames = read_tables(directory)
    return write_files(directory, {name: as_csv(from_frame(frame)) for name, frame in zip(names, frames, strict=True)})


def write_files(directory: Path, files: Mapping[str, str | bytes]) -> tuple[Path, ...]:
    """Write texts or bytes under their names into a directory; the paths."""
    check_each(directory, (), ())
    for name, content in files.items():
        write_atomic(directory / name, content.encode() if isinstance(content, str) else content)
    return tuple(directory / name for name in files)


def reservations(manifest: Mapping[str, Any], runs: int) -> str:
    """The warnings that stand first while runs are missing, or where some were merged; else an empty text."""
    planned = manifest["planned"]
    text = f"INCOMPLETE: {runs} of {planned} runs are finished. " if runs < planned else ""
    added, recomputed = (sum(one[name] for one in manifest.get("merged", ())) for name in ("added", "recomputed"))
    if added:
        text += f"MERGED: {added} runs come from elsewhere, {added - recomputed} of them were not computed again. "
    return text


def environment_rows(manifest: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What a run was made with, as pairs of name and text."""
    packages = ", ".join(f"{name} {version}" for name, version in (manifest.get("packages") or {}).items() if version)
    chosen = {name: value for name, value in (manifest.get("selection") or {}).items() if value}
    selection = [f"{name} {' '.join(value) if isinstance(value, list) else value}" for name, value in chosen.items()]
    return [
        ("version", str(manifest["version"])),
        ("selection", ", ".join(selection)),
        ("seeds", f"{manifest.get('seeds')}; held-out records {manifest.get('held_out_seed')}"),
        ("threads per worker", str(manifest.get("threads_per_worker"))),
        ("Python", f"{manifest.get('python')} ({manifest.get('platform')})"),
        ("processor", f"{manifest.get('cpu')}, {manifest.get('cpus')} usable"),
        ("packages", packages),
        *(("merged", _merged(one)) for one in manifest.get("merged", ())),
    ]


def _merged(one: Mapping[str, Any]) -> str:
    missing = one.get("not_computable", ())
    return (
        f"{one['added']} runs of journal {one['journal']}: {one['recomputed']} were computed again and agree (sample "
        f"of seed {one['seed']}), {one['added'] - one['recomputed']} were not verified; times are of the other machine"
        + (f"; {len(missing)} of the sample cannot be computed here: {'; '.join(missing[:3])}" if missing else "")
    )
