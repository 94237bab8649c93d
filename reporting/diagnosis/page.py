"""The page of a diagnosis in five steps: measured against simulated, where the errors arise, the causes, the extended
model's equations, before and after on held-out records."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..equations import equations
from ..numbers import p_value
from ..templating import render
from ..validation.tables import horizon_table, trusted_lines
from . import words
from .charts import AFTER, BEFORE, MEASURED
from .figures import curve_chart
from .panels import panel
from .tables import added_table, bank_table, gain_table, instrument_rows, not_testable_table, where_table

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis
    from ...diagnosis.trace import Trace


def html(found: Diagnosis) -> str:
    """The page, self-contained."""
    extended = found.extended is not found.model and found.extends
    model = equations(found.extended, found.model) if extended else None
    return render(
        "diagnosis.html.j2",
        found=found,
        words=words,
        p_value=p_value,
        verdict=words.verdict(found),
        panels=[panel(trace, after=False) for trace in _shown_first(found)],
        held_out=[panel(trace, after=extended) for trace in found.traces if trace.role != "train"],
        where=where_table(found),
        bank=bank_table(found, testable_only=True),
        not_testable=not_testable_table(found),
        equations=model,
        added=added_table(model, instrument_rows(found)) if model else None,
        gain=gain_table(found),
        horizons=None if found.ahead is None else horizon_table(found.ahead),
        trusted=[] if found.ahead is None else trusted_lines(found.ahead),
        remaining=[(force, words.remaining(force), curve_chart(force)) for force in found.remaining],
        facts=words.facts(found),
        colours={"measured": MEASURED, "before": BEFORE, "after": AFTER},
    )


def _shown_first(found: Diagnosis) -> list[Trace]:
    """The records that show what is wrong: those of training, or else all."""
    return [trace for trace in found.traces if trace.role == "train"] or list(found.traces)
