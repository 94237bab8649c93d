"""Diagnosers as entrants: an exam's folder in, a submission out."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...checks.result import Size
from ...datasets.io import write_record
from ...datasets.record import Record
from ...diagnosis.options import Options
from ...diagnosis.registry import find
from ...diagnosis.result import Diagnosis, Finding
from ...models.coefficient_groups import stated_groups
from ...models.errors import BadInput, CannotFit, EnvironmentFault, FitFailed
from ...models.plain import plain
from ..execution import one_line, quiet
from ..kinds.diagnosis.judge import named
from ..store import check_vacant
from .exam_file import GROUP
from .folder import Exam
from .key import SCHEMA
from .motion import SCORED, Motion, opening, predicted_or_none
from .submission import FILE, SaidRegime


def answer(
    folder: Path, maker: str, place: Path, watch: Callable[[str], object] = lambda stage: None
) -> dict[str, str]:
    """Answer an exam with a diagnoser; writes `submission.json` and the predicted motion into the folder `place`.

    maker : what `diagnosis.registry.find` takes.

    Returns
    -------
    World -> why the diagnoser failed there; such a world is left out of the submission.

    Raises
    ------
    BadInput : the folder holds no exam or was changed, there is no such diagnoser, or `place` is in use.
    """
    exam = Exam(folder)
    exam.check()
    diagnoser = find(maker)()
    check_vacant(place)
    answers: dict[str, Any] = {}
    runs: dict[str, Record] = {}
    failed: dict[str, str] = {}
    for world, files in exam.worlds.items():
        watch(world)
        model, train = exam.model(world), exam.records(world, files.train)
        held_out = exam.records(world, files.held_out)
        options = Options(coefficient_sd=0.0 if files.base_numbers == "exact" else None)
        try:
            with quiet():
                found = diagnoser.diagnose(model, train, held_out, options)
                motion = motion_of(found, held_out)
        except (EnvironmentFault, BadInput):
            raise
        except (CannotFit, FitFailed, ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
            failed[world] = one_line(error)
            continue
        own = {name: f"{world}-{name}.csv" for name in motion}
        answers[world] = said(found, exam.causes) | {"motion": own}
        for record in held_out:
            if record.name in motion:
                runs[own[record.name]] = record.with_channels(**motion[record.name])
    content = {
        "schema_version": SCHEMA, "exam": exam.id, "entrant": diagnoser.name, "about": diagnoser.title,
        "worlds": answers,
    }  # fmt: skip
    write(place, content, runs)
    return failed


def write(place: Path, content: dict[str, Any], runs: dict[str, Record]) -> None:
    """Write a submission, its file last; runs : name of a file -> held-out record with its predicted motion."""
    place.mkdir(exist_ok=True)
    for name, record in runs.items():
        write_record(record, place / name)
    text = json.dumps(plain(content), indent=1, allow_nan=False) + "\n"
    (place / FILE).write_text(text, "utf-8")


def motion_of(found: Diagnosis, held_out: list[Record]) -> dict[str, Motion]:
    """Predicted motion of held-out records: the free runs of the diagnosis, else of its extended model."""
    own = {trace.record: trace.after for trace in found.traces if trace.role == "held_out"}
    model = predicted_or_none(found.extended, held_out)
    out = {}
    for record in held_out:
        runs = (_finite(record, motion.get(record.name, {})) for motion in (own, model))
        best = next((run for run in runs if any(c in run for c in SCORED)), None)
        if best:
            out[record.name] = best
    return out


def _finite(record: Record, motion: Motion) -> dict[str, np.ndarray]:
    """Channels of a run that are finite behind the opening, the record's own values before it."""
    start, found = opening(record), {}
    for channel, values in motion.items():
        if channel in record.channels and values.size == record.n and np.isfinite(values[start:]).all():
            found[channel] = np.where(np.arange(record.n) < start, record.column(channel), values)
    return found


def said(found: Diagnosis, causes: dict[str, Any]) -> dict[str, Any]:
    """An answer from a diagnosis; groups of the base model's numbers are named one by one."""
    out: list[dict[str, Any]] = []
    for finding in found.causes:
        if finding.cause in causes:
            out.append(_named(finding, finding.cause, [t for t in finding.tied_with if t in causes]))
            continue
        groups = {one.id for one in stated_groups(found.model)}
        for names in named(replace(found, causes=(finding,))):
            known = [*sorted(GROUP + name for name in names & groups), *sorted(names & set(causes) - groups)]
            if known:
                out.append(_named(finding, known[0], known[1:]))
    unnamed = found.verdict in ("unexplained", "described") or bool(found.causes)
    return {"named": out, "unexplained": unnamed and not out}


def _named(finding: Finding, cause: str, tied: list[str]) -> dict[str, Any]:
    out: dict[str, Any] = {"cause": cause, "tied_with": tied, "sizes": [_size(s) for s in finding.sizes]}
    out["sizes"] = [size for size in out["sizes"] if size is not None] if cause == finding.cause else []
    if isinstance(finding.details.get("coefficient"), str):
        out["coefficient"] = finding.details["coefficient"]
    regime = finding.details.get("regime")
    if isinstance(regime, dict):
        with suppress(ValueError):
            out["regime"] = SaidRegime(
                variable=regime["variable"], side=regime["side"], threshold=regime.get("threshold") or 0.0
            ).model_dump()
    return out


def _size(size: Size) -> dict[str, Any] | None:
    if not np.isfinite(size.value):
        return None
    out: dict[str, Any] = {"parameter": size.parameter, "value": size.value, "record": size.record}
    if np.isfinite([size.low, size.high]).all() and size.low <= size.value <= size.high:
        out |= {"low": size.low, "high": size.high}
    return out
