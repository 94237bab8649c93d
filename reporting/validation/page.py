"""What a validation says: how far ahead to trust a model, errors of free runs and ahead, manoeuvring indices."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..page import FAIR, GOOD, Note, Section, Verdict, items, overlays, result_page
from ..runs import of_validation
from .tables import free_table, horizon_table, index_table, left_out_table, record_table, trusted_lines

if TYPE_CHECKING:
    from ...estimation.validation.result import Validation
    from ..page import Page

TITLES = ("Measured and simulated", "Errors of free runs", "Errors ahead", "Manoeuvring indices")
RUNS = (
    "Each model is simulated with the recorded rudder and revolutions from the state that the record itself, smoothed, "
    "has at its first sample, without random forces, and anew behind a long gap. Errors are those of the recorded "
    "channels, over all records; R² = 1 − SSE/SST, about each run's mean; together: mean over heading, yaw rate, surge "
    "and sway. Behind a divergence the last value before it stands. In the charts a run is cut off where it is far "
    "from the measured values."
)
AHEAD = (
    "Root mean square errors of predictions some time ahead, from up to 200 smoothed states of each run, behind the "
    "model's instruments."
)
INDICES = (
    "As IMO MSC.137(76) defines them. The simulated ship sails the same manoeuvre from the first execute on: it gets "
    "counter rudder when its own heading has changed by as much as the recorded one had, and the rudder moves as "
    "recorded."
)
NO_INDICES = "The records hold neither a zigzag nor a turning circle from which indices can be read."


def page(validation: Validation) -> Page:
    """The page of a validation."""
    trusted = [f"{line}." for line in trusted_lines(validation)]
    diverged = [f"{run.model} along {run.record}: {run.told}" for run in validation.runs if run.told]
    first, *others = trusted or ["No time ahead was tried: the records are too short."]
    overview, each = overlays(of_validation(validation))
    good = not diverged and any(time > 0.0 for time in validation.trusted_s.values())
    return result_page(
        f"Validation of {', '.join(validation.models)}",
        f"on {count(validation)}; nothing was fitted",
        Verdict(GOOD if good else FAIR, first, (*others, *diverged)),
        seen=[overview],
        changed=[free_table(validation), left_out_table(validation)],
        remains=[horizon_table(validation), Note(f"Times ahead: {validation.horizon_basis}.")],
        following=[index_table(validation) if validation.indices else NO_INDICES],
        details=[
            Section("Errors by record", (record_table(validation),)),
            each,
            Section("How to read it", (items([RUNS, AHEAD, INDICES]),)),
        ],
        doubts=validation.doubts,
        titles=TITLES,
    )


def count(validation: Validation) -> str:
    """`3 records`, or the name of the only one."""
    names = [record.name for record in validation.records]
    return names[0] if len(names) == 1 else f"{len(names)} records"
