"""A study of very many runs worked out from the measured cost of one run: time, memory, storage, what breaks first."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...bench.pool import MOST_TOGETHER, TOGETHER_S

HOUR_S = 3600.0
START_SHARE = 0.01
"""Share of a part's time that its start may take."""


@dataclass(frozen=True)
class Study:
    """So many equal runs on so many cores.

    Parameters
    ----------
    run : the measured cost of a run: cpu_s in all, parent_cpu_s of it in the process that hands out and stores,
        start_cpu_s of a suite, stored_bytes and parent_bytes (memory of that process) of a run.
    """

    run: Mapping[str, float]
    runs: float
    cores: int

    @property
    def worker_s(self) -> float:
        """CPU time of a run in its worker, s."""
        return self.run["cpu_s"] - self.run["parent_cpu_s"]

    @property
    def hours(self) -> float:
        """Hours that all cores compute, where nothing holds them up."""
        return self.runs * self.worker_s / self.cores / HOUR_S

    @property
    def cores_fed(self) -> float:
        """Cores that one process can hand runs to, and store the results of."""
        return self.worker_s / self.run["parent_cpu_s"]

    @property
    def parent_hours(self) -> float:
        """Hours that one process takes to hand out and store all runs."""
        return self.runs * self.run["parent_cpu_s"] / HOUR_S

    @property
    def parent_bytes(self) -> float:
        """Memory of one process that plans and stores all runs."""
        return self.runs * max(self.run["parent_bytes"], 0.0)

    @property
    def stored_bytes(self) -> float:
        """Size of all results on disk."""
        return self.runs * self.run["stored_bytes"]

    @property
    def runs_together(self) -> float:
        """Runs of a call that is handed to a worker."""
        return max(1.0, min(float(MOST_TOGETHER), TOGETHER_S / self.worker_s))

    @property
    def calls_per_s(self) -> float:
        """Calls that all cores ask for in a second."""
        return self.cores / (self.runs_together * self.worker_s)

    @property
    def runs_a_part(self) -> float:
        """Runs of a part whose start takes `START_SHARE` of its time on one core."""
        return self.run["start_cpu_s"] / START_SHARE / self.run["cpu_s"]

    @property
    def part_hours(self) -> float:
        """Hours of a study of such parts, each on a core of its own with a process that stores them."""
        return self.runs * self.run["cpu_s"] * (1.0 + START_SHARE) / self.cores / HOUR_S

    def demands(self, memory_bytes: float, disk_bytes: float) -> list[tuple[str, float]]:
        """What one command would need in units of what there is, the scarcest first."""
        found = {
            "the process that hands out and stores": self.cores / self.cores_fed,
            "its memory": self.parent_bytes / memory_bytes,
            "the disk": self.stored_bytes / disk_bytes,
        }
        return sorted(found.items(), key=lambda item: -item[1])
