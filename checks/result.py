"""What `check` says of records: findings of the file and of the sensors, and what could not be checked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..models.plain import plain
from ..models.result import FileResult, above

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = 1
NORMAL_90 = 1.6448536269514722
"""Half width of a 90 % interval in standard deviations."""


@dataclass(frozen=True)
class Size:
    """One number of a cause with its interval, SI; `record` names the record it belongs to, None for all."""

    parameter: str
    value: float
    low: float
    high: float
    unit: str
    record: str | None = None


@dataclass(frozen=True)
class CheckFinding:
    """One thing that is wrong with records or sensors.

    stage : 'file' (integrity of the data), 'sensors' (channels compared with each other) or 'free runs' (of a model
    along the records).  records : those it concerns.  sizes : with 90 % intervals, over all records and by record.
    material : whether the size matters; else it is detectable only.  z : of the estimate, p_equal : probability that
    records have the same size (None: one record, or nothing to compare).
    corrected : the records can be corrected for it, and a diagnosis does.  standing : they cannot, and while it stands
    nothing that a model says of the hull can be trusted.  blanked : samples that a correction leaves out.
    biases : a fit to the records as they are would be wrong by it.
    """

    cause: str
    stage: str
    records: tuple[str, ...]
    channels: tuple[str, ...]
    sizes: tuple[Size, ...]
    evidence: str
    tied_with: tuple[str, ...] = ()
    separate_by: str | None = None
    material: bool = True
    z: float | None = None
    p_equal: float | None = None
    corrected: bool = False
    standing: bool = False
    blanked: int = 0
    biases: bool = False


@dataclass(frozen=True, repr=False)
class Check(FileResult):
    """The outcome of `check`: what is wrong with files and sensors, with sizes, and what could not be checked.

    `findings` that matter have `material` true; the others are detectable, but too small to matter.
    """

    room, files, pictured = "check", ("check.json", "check.html"), "sizes of the findings"

    records: tuple[str, ...]
    findings: tuple[CheckFinding, ...]
    not_checked: tuple[str, ...]
    """What could not be checked and why, a sentence each."""
    level: float = 0.90

    def to_json(self) -> dict[str, Any]:
        """The document of schema version 1 (check.json), plain numbers only."""
        return {
            "schema": SCHEMA,
            "records": list(self.records),
            "level": self.level,
            "findings": plain(self.findings),
            "not_checked": list(self.not_checked),
        }

    def plot(self) -> Figure:
        """Draw the sizes of the findings with their intervals, over all records and in each.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.

        Raises
        ------
        BadInput : no finding has a size.
        """
        return above("reporting.check").figure_of(self)

    def __repr__(self) -> str:
        causes = ", ".join(dict.fromkeys(f.cause for f in self.findings if f.material))
        return (
            f"<Check of {len(self.records)} record{'s' if len(self.records) != 1 else ''}: {causes or 'no findings'}>"
        )
