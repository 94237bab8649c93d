"""What `check` says of records: findings of the file and of the sensors, and what could not be checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ..models.plain import plain
from ..models.result import FileResult, above

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = 1
NORMAL_90 = 1.6448536269514722
"""Half width of a 90 % interval in standard deviations."""
SHOWN = 3
"""Records of which a finding says what was found in each."""


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


def sentence_of(finding: CheckFinding) -> str:
    """The evidence behind the names of its records; of several records merged it holds their names."""
    has_names = finding.evidence.startswith(f"{finding.records[0]}: ")
    return finding.evidence if has_names else f"{', '.join(finding.records)}: {finding.evidence}"


def merged(findings: Sequence[CheckFinding]) -> list[CheckFinding]:
    """Findings of the same cause in the same columns of several records as one, those that matter first."""
    groups: dict[tuple, list[CheckFinding]] = {}
    for f in findings:
        groups.setdefault((f.cause, f.channels), []).append(f)
    out = [_together(group) for group in groups.values()]
    return sorted(out, key=lambda f: not f.material)


def _together(group: Sequence[CheckFinding]) -> CheckFinding:
    first = next((f for f in group if f.material), group[0])
    said = [f.evidence for f in group] if len(group) == 1 else [f"{f.records[0]}: {f.evidence}" for f in group]
    more = f"; and {len(said) - SHOWN} more" if len(said) > SHOWN else ""
    return replace(
        first,
        records=tuple(dict.fromkeys(r for f in group for r in f.records)),
        sizes=tuple(s for f in group for s in f.sizes),
        evidence="; ".join(said[:SHOWN]) + more,
        material=any(f.material for f in group),
        corrected=any(f.corrected for f in group),
        standing=any(f.standing for f in group),
        biases=any(f.biases for f in group),
        blanked=sum(f.blanked for f in group),
    )


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
