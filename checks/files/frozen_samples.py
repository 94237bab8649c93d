"""Check `frozen_samples`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base import FileCheck
from ..fault import SENSED, Fault, exact
from ..integrity.runs import COARSE, frozen_runs, held_rows

if TYPE_CHECKING:
    from ...datasets.record import Record


class FrozenSamples(FileCheck):
    """A channel repeats its last value while the ship moves on: the sensor or the link to it stood still."""

    id = "frozen_samples"
    rank = 20
    unit = "s"
    separate_by = "the sensor's own time stamps"

    def find(self, record: Record) -> list[Fault]:
        return [
            f
            for name in SENSED
            if record.has(name)
            for f in (self._frozen(record, name), self._held(record, name))
            if f
        ]

    def _frozen(self, record: Record, name: str) -> Fault | None:
        runs, time = frozen_runs(record.column(name)), record.time_s
        if not runs:
            return None
        worst = max(runs, key=lambda r: time[r.stop - 1] - time[r.start])
        length = float(time[worst.stop - 1] - time[worst.start])
        stretches = "1 stretch" if len(runs) == 1 else f"{len(runs)} stretches"
        said = f"{name} repeats one value in {stretches}, the longest from {time[worst.start]:.6g} s for {length:.4g} s"
        return Fault(
            said,
            (name,),
            (exact("longest", length, "s"),),
            material=any(r.jump > COARSE for r in runs),
            blanks=tuple((name, r.start + 1, r.stop) for r in runs),
        )

    def _held(self, record: Record, name: str) -> Fault | None:
        rows = held_rows(record.column(name))
        if rows == 1:
            return None
        said = f"{name} changes only every {rows} rows: it is sampled more slowly than the record"
        return Fault(said, (name,), (exact("period", rows * record.dt, "s"),), material=False)
