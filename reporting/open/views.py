"""Results of a check, an identification and a diagnosis as plain values for the page of `helmbench open`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.columns import in_order
from ...datasets.display import continuous, shown_name, shown_unit
from ..check import tables as of_check
from ..check import text as check_words
from ..craft import text as craft
from ..diagnosis import tables as of_diagnosis
from ..diagnosis import words
from ..equations import equations
from ..identification import tables as of_identification
from ..identification import text as identification_words
from ..validation.tables import free_table
from .curves import numbers, stride, times

if TYPE_CHECKING:
    from ...checks.result import CheckResult
    from ...diagnosis.craft.result import CraftDiagnosis
    from ...diagnosis.result import Diagnosis, Finding
    from ...diagnosis.trace import Trace
    from ...estimation.judgement.assessment import Assessment
    from ...estimation.validation.result import Validation
    from ..tables import Table

GOOD, FAIR, BAD = "good", "fair", "bad"
TONES = {
    "adequate": GOOD,
    "explains": GOOD,
    "named": FAIR,
    "tied": FAIR,
    "partly_named": FAIR,
    "described": FAIR,
    "inconclusive": FAIR,
    "approximates": FAIR,
    "unexplained": BAD,
    "fails": BAD,
    "input_does_not_act": BAD,
    "input_follows_output": BAD,
}
"""Verdict -> how the page sets it off."""
POSITIONS = ("north_m", "east_m")
RUNS = {"measured": "measured", "before": "simulated", "after": "extended model"}


def check_view(found: CheckResult) -> dict[str, Any]:
    """Findings in the records themselves."""
    material = [f for f in found.findings if f.material]
    named = f": {', '.join(dict.fromkeys(map(of_check.name, material)))}" if material else ""
    said = f"{check_words.headline(found)}{named}."
    causes = [
        {"title": of_check.name(f), "sizes": of_check.whole_sizes(f), "said": words.sentence(f.evidence),
         "next": words.sentence(f.separate_by or "")}
        for f in material
    ]  # fmt: skip
    if not found.findings and found.not_checked:
        said = "No finding in what could be checked. What could not is named below."
    elif not found.findings:
        said = f"No finding. {check_words.NOTHING.partition(': ')[2].capitalize()}."
    tables = [_table(of_check.findings(found)), _table(of_check.by_record(found))]
    return _view(FAIR if material else GOOD, said, list(found.not_checked), causes=causes, tables=tables)


def identification_view(found: Assessment) -> dict[str, Any]:
    """Whether to believe an estimate, its free runs and its parameters."""
    sides = [("train", found.train)] + ([("held_out", found.held_out)] if found.held_out else [])
    tables = [
        _table(free_table(found.judged), "Free runs"),
        _table(of_identification.assessed_table(found), "Parameters"),
        _table(of_identification.residual_table(found), "Residuals"),
        *([_table(of_identification.comparison_table(found.comparison), "Models that were compared")]
          if found.comparison else []),
    ]  # fmt: skip
    return _view(
        TONES[found.verdict],
        identification_words.headline(found),
        identification_words.statement(found),
        next=identification_words.next_lines(found),
        tables=tables,
        traces=[trace for role, side in sides for trace in _validation_traces(side, role)],
    )


def craft_view(found: CraftDiagnosis) -> dict[str, Any]:
    """What steers a craft without a model, what simpler models lack, and how far ahead the built one can be trusted."""
    tested = "held_out" in {role for _, role in found.records}
    model = equations(found.model, found.model)
    first, *told = craft.statement(found)
    tables = [
        _table(craft.numbers_table(found), "Numbers of the model"),
        _table(craft.steps_table(found), "What simpler models lack"),
        _table(craft.laws_table(found), "What steers the craft"),
        _table(craft.band_table(found), "How far heading can be trusted"),
        _table(craft.angles_table(found), "Neutral angle of every training record"),
    ]
    return _view(
        TONES[found.verdict],
        first,
        [*told, *found.doubts],
        label=craft.headline(found),
        next=[found.next_runs] if found.next_runs else [],
        equations=[{"html": line.html, "new": False} for line in (*model.relations, *model.dynamics)],
        tables=tables,
        traces=list(_validation_traces(found.ahead, "held_out" if tested else "train")),
    )


def diagnosis_view(found: Diagnosis) -> dict[str, Any]:
    """Verdict, causes, what to sail next, extended model, gain, and the runs before and after."""
    extended = found.extended is not found.model and bool(found.causes)
    model = equations(found.extended, found.model) if extended else None
    first, _, rest = words.verdict(found).partition(". ")
    told = [rest, words.sentence(found.reason), *found.doubts]
    tables = [
        *([_table(of_diagnosis.added_table(model, of_diagnosis.instrument_rows(found)), "New parameters")]
          if model else []),
        _table(of_diagnosis.gain_table(found), "Free-run errors on held-out records"),
        _table(of_diagnosis.where_table(found), "Where the errors arise"),
        _table(of_diagnosis.bank_table(found, testable_only=True), "The causes that were tested"),
    ]  # fmt: skip
    lines = [*model.relations, *model.dynamics] if model else []
    return _view(
        TONES[found.verdict],
        first if first.endswith(".") else f"{first}.",
        [text for text in told if text],
        label=words.cause(found.verdict),
        causes=[_cause(f) for f in found.causes],
        next=[found.next_manoeuvre] if found.next_manoeuvre else [],
        equations=[{"html": line.html, "new": line.new} for line in lines],
        tables=tables,
        traces=[_trace(trace, extended) for trace in found.traces],
    )


def _view(tone: str, sentence: str, told: list[str], **more: Any) -> dict[str, Any]:
    empty: dict[str, Any] = {"label": "", "causes": [], "next": [], "equations": [], "tables": [], "traces": []}
    view: dict[str, Any] = {**empty, **more, "tone": tone, "sentence": sentence, "told": told}
    return view | {"tables": [table for table in view["tables"] if table["rows"]]}


def _cause(finding: Finding) -> dict[str, str]:
    return {
        "title": words.tie(finding),
        "sizes": "; ".join(map(words.size, finding.sizes)),
        "said": words.sentence(finding.evidence),
        "next": words.sentence(words.separation(finding) or ""),
    }


def _table(table: Table, title: str = "") -> dict[str, Any]:
    """A table as texts, with what each cell is sorted by."""
    rows = [[{"text": cell.text, "key": cell.key} for cell in row] for row in table.rows]
    return {"title": title or table.title, "columns": list(table.columns), "numeric": list(table.numeric), "rows": rows}


# ---- runs along a record


def _trace(trace: Trace, after: bool) -> dict[str, Any]:
    runs = {"measured": trace.measured, "before": trace.before} | ({"after": trace.after} if after else {})
    return _runs_view(trace.record, trace.role, trace.time, trace.rudder, {RUNS[k]: v for k, v in runs.items()})


def _validation_traces(side: Validation, role: str) -> Iterable[dict[str, Any]]:
    for record in side.records:
        runs = {run.model: run.predicted for run in side.runs if run.record == record.name}
        yield _runs_view(record.name, role, record.time_s, record.rudder, {"measured": record.channels} | runs)


def _runs_view(
    record: str, role: str, time: np.ndarray, rudder: np.ndarray, runs: Mapping[str, Mapping[str, np.ndarray]]
) -> dict[str, Any]:
    """Measured channels and simulated runs of a record: curves with residuals, and tracks."""
    kept = stride(time.size)
    measured = runs["measured"]
    simulated = {label: run for label, run in runs.items() if label != "measured"}
    names = [name for name in in_order(measured) if any(name in run for run in simulated.values())]
    panels = [_panel(name, kept, measured[name], simulated) for name in names if name not in POSITIONS]
    tracks = [
        {"label": label, "north": numbers(run["north_m"][kept]), "east": numbers(run["east_m"][kept])}
        for label, run in runs.items()
        if set(POSITIONS) <= run.keys() and set(POSITIONS) <= measured.keys()
    ]
    return {"record": record, "role": role.replace("_", " "), "time": times(time[kept]),
            "rudder": numbers(np.degrees(rudder[kept])), "panels": panels, "tracks": tracks}  # fmt: skip


def _panel(
    name: str, kept: np.ndarray, measured: np.ndarray, simulated: Mapping[str, Mapping[str, np.ndarray]]
) -> dict[str, Any]:
    unit, factor = shown_unit(name)
    own = factor * continuous(name, measured)
    curves = [{"label": "measured", "values": numbers(own[kept])}]
    residuals = []
    for label, run in ((label, run) for label, run in simulated.items() if name in run):
        values = factor * continuous(name, run[name])
        values = values + _turns(own - values) if name == "heading_rad" else values
        values = np.where(np.abs(values) < 1e6, values, np.nan)
        curves.append({"label": label, "values": numbers(values[kept])})
        residuals.append({"label": label, "values": numbers((own - values)[kept])})
    return {"channel": name, "label": shown_name(name), "unit": unit, "curves": curves, "residuals": residuals}


def _turns(gap: np.ndarray) -> float:
    """Full turns, deg, between two headings (N,) where both begin."""
    known = gap[np.isfinite(gap)]
    return float(360.0 * np.round(known[0] / 360.0)) if known.size else 0.0
