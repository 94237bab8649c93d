"""Results of a paper: the spread of every value, stored as `results/NNN.json` in the folder of the pages."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import TypeAdapter

from ..models.data_file import load
from ..models.errors import BadInput
from ..models.folders import make_folder, write_atomic
from ..models.plain import plain
from .claims.claim import Claim, Paper, Reference
from .runner import Run, is_of, result_of
from .verdicts import NOTHING, Judged, Spread, judge, summarise

FOLDER = "results"


@dataclass(frozen=True)
class Results:
    """Of one paper.

    values : study -> key -> spread;  failures : study -> why a run of it has no values;  figures : id -> SHA-256 of
    the file that was drawn from the same runs.
    """

    paper: str
    values: Mapping[str, Mapping[str, Spread]]
    failures: Mapping[str, str] = field(default_factory=dict)
    figures: Mapping[str, str] = field(default_factory=dict)

    def judged(self, paper: Paper) -> list[Judged]:
        """Every claim of the paper with its verdict, in order."""
        told = {search.study: search.told for search in paper.searches}
        return [self._judged(claim, told.get(claim.search, "")) for claim in paper.claims]

    def found(self, reference: Reference) -> Spread:
        """Our value of the quantity of an independent computation."""
        return self.values.get(reference.study, {}).get(reference.key, NOTHING)

    def _judged(self, claim: Claim, over: str) -> Judged:
        values, searched = self.values.get(claim.study, {}), self.values.get(claim.search, {})
        failure = self.failures.get(claim.study, "")
        told = f"The computation failed: {failure}" if failure and not values else ""
        return judge(claim, values, told, searched, over)


def of_runs(paper: Paper, runs: Sequence[Run]) -> Results:
    """Spreads of the paper's finished runs."""
    values, failures = {}, {}
    for study in paper.studies:
        own = [run for run in runs if is_of(run, paper.paper, study)]
        errors = [run["row"]["error"] for run in own if run["row"]["error"]]
        given = [result_of(run).values for run in own if not run["row"]["error"]]
        values[study] = summarise(given, paper.logarithmic(study))
        if errors:
            failures[study] = errors[0]
    return Results(paper.paper, values, failures)


def write(results: Results, directory: Path) -> Path:
    """Store the results of a paper in the directory of the pages."""
    path = make_folder(directory / FOLDER, within=directory) / f"{results.paper}.json"
    write_atomic(path, json.dumps(plain(results), indent=1, allow_nan=False, sort_keys=True).encode() + b"\n")
    return path


def read(paper: str, directory: Path) -> Results:
    """The stored results of a paper; raises `BadInput` where there are none, or the file is damaged."""
    path = directory / FOLDER / f"{paper}.json"
    try:
        return TypeAdapter(Results).validate_python(load(path))
    except (OSError, ValueError) as error:
        raise BadInput(f"holds no results of a reproduction ({error})", file=path) from None
