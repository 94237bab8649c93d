"""The page of a check."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..templating import render
from .tables import by_record, findings
from .text import NOTHING, headline

if TYPE_CHECKING:
    from ...checks.result import CheckResult

READING = (
    "No model of the ship is used. A finding of the file is read off the samples of each record. A finding of the "
    "sensors comes from channels that must agree for any ship: the heading is the integral of the yaw rate, positions "
    "are the integral of surge and sway turned by the heading. Intervals: 90 %, from the scatter of twelve blocks of "
    "each record; where sizes differ between records beyond chance, from the scatter between records (Hartung and "
    "Knapp), and the finding says so. A finding matters where its size is above a floor: half a percent of a scale, "
    "half a degree, half a sampling step or two percent of the time in which the ship changes its turn. Causes joined "
    "by 'or' leave the same traces in these records."
)


def html(found: CheckResult) -> str:
    """One self-contained HTML document."""
    return render(
        "check.html.j2",
        headline=headline(found),
        nothing=NOTHING,
        findings=findings(found),
        sizes=by_record(found),
        not_checked=found.not_checked,
        records=found.records,
        reading=READING,
    )
