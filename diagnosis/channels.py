"""The sensors' stage of a diagnosis: what channels show of each other, before any hull model is asked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..checks.check import compared, distinct
from ..checks.findings import of_sizes
from ..models.instruments import combined
from .causes.registry import causes
from .report.findings import of_sensor

if TYPE_CHECKING:
    from ..checks.base import Check
    from ..checks.comparison.chains import Chain
    from ..checks.comparison.selection import Sizes
    from ..datasets.record import Record
    from .result import Finding


@dataclass(frozen=True)
class Shown:
    """What channels show of their sensors: findings, the numbers that were removed as instruments, and for each cause
    that was tested the statistic (z squared) of its evidence by itself."""

    findings: tuple[Finding, ...] = ()
    instruments: dict[str, float] = field(default_factory=dict)
    statistics: dict[Check, float] = field(default_factory=dict)

    def then(self, later: Shown) -> Shown:
        """This and what the corrected records show."""
        instruments = combined(self.instruments, later.instruments)
        return Shown((*self.findings, *later.findings), instruments, self.statistics | later.statistics)


@dataclass(frozen=True)
class Sensors:
    """Records with the sensors' errors removed, and what was shown of these."""

    train: list[Record]
    held_out: list[Record]
    shown: Shown = field(default_factory=Shown)


def sensors_of(
    train: Sequence[Record],
    held_out: Sequence[Record],
    only: Collection[Check] | None = None,
    along: Sequence[Chain] | None = None,
    derived: Mapping[str, set[str]] | None = None,
) -> Sensors:
    """Compare channels along the chains (None: all), and correct the records one after the other.

    derived : record name -> columns that are made from each other: they are not compared.
    Training records are corrected by sizes of their own where these differ, held-out ones by the mean; delays
    too small to matter are corrected and not told.
    """
    ids = {c.id: c for c in causes().values() if only is None or c in only}
    done = Sensors(distinct(train), list(held_out))
    for found, corrected in compared(done.train, derived or {}, [], ids, along):
        if found.absurd is not None:
            break
        told = tuple(of_sensor(f, ids) for f in of_sizes(found) if f.material)
        evidence: dict[Check, float] = {}
        for option, z in found.tested:
            own = ids[option.cause.id]
            evidence[own] = max(z**2, evidence.get(own, 0.0))
        done = Sensors(
            corrected,
            [found.without(r, own=False) for r in done.held_out],
            done.shown.then(Shown(told, _instruments([s for s in found.found if s.material]), evidence)),
        )
    return done


def _instruments(sizes: Sequence[Sizes]) -> dict[str, float]:
    """Mean sizes as instruments of a model."""
    effects = (pair for s in sizes for pair in zip(s.option.effects, s.means, strict=True))
    return {slot: mean.value for effect, mean in effects for slot in effect.instruments}
