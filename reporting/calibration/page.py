"""The page of a calibration: what moved, step by step, what remains, measured against simulated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnosis.charts import AFTER, BEFORE, MEASURED
from ..diagnosis.panels import panel
from ..equations import equations
from ..templating import render
from . import text as words

if TYPE_CHECKING:
    from ...diagnosis.calibration.result import Calibration


def html(found: Calibration) -> str:
    """The page, self-contained."""
    traces = sorted(found.traces, key=lambda trace: trace.role != "held_out")
    return render(
        "calibration.html.j2",
        found=found,
        words=words,
        moved=words.moved_table(found),
        steps=words.steps_table(found),
        models=words.models_table(found),
        ingredients=words.ingredients_table(found),
        shares=words.shares_table(found),
        remaining=words.remaining_table(found),
        runs=words.runs_table(found),
        equations=equations(found.extended, found.model) if found.moved else None,
        panels=[panel(trace, after=bool(found.moved)) for trace in traces],
        colours={"measured": MEASURED, "before": BEFORE, "after": AFTER},
    )
