"""A study of very many runs, worked out from the measured cost of one: time, memory, storage, what breaks first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ...bench.pool import MOST_TOGETHER, TOGETHER_S
from ..numbers import number
from .rows import Row

RUNS, CORES = 1e8, 1000
MEMORY_BYTES, DISK_BYTES = 64e9, 10e12
"""What one machine of the example has."""
SAMPLES = 1000.0
START_SHARE = 0.01
"""Share of a part's time that its start may take."""
HOUR_S = 3600.0


def study(run: Mapping[str, float], runs: float, cores: int) -> dict[str, float]:
    """Figures of so many equal runs on so many cores.

    Parameters
    ----------
    run : the measured cost of a run: cpu_s in all, parent_cpu_s of it in the process that hands out and stores,
        start_cpu_s of a suite, stored_bytes and parent_bytes (memory of that process) of a run.

    Returns
    -------
    worker_s of a run in its worker; hours that all cores compute where nothing holds them up; cores_fed: cores that one
    process can hand runs to; parent_hours, parent_bytes that it takes to hand out, plan and store all runs;
    stored_bytes of all results; runs_together in a call, calls_per_s of all cores; runs_a_part: runs of a part whose
    start takes `START_SHARE` of its time on one core; part_hours of a study of such parts.
    """
    worker_s, parent_s = run["cpu_s"] - run["parent_cpu_s"], run["parent_cpu_s"]
    together = max(1.0, min(float(MOST_TOGETHER), TOGETHER_S / worker_s))
    return {
        "worker_s": worker_s,
        "hours": runs * worker_s / cores / HOUR_S,
        "cores_fed": worker_s / parent_s,
        "parent_hours": runs * parent_s / HOUR_S,
        "parent_bytes": runs * max(run["parent_bytes"], 0.0),
        "stored_bytes": runs * run["stored_bytes"],
        "runs_together": together,
        "calls_per_s": cores / (together * worker_s),
        "runs_a_part": run["start_cpu_s"] / START_SHARE / run["cpu_s"],
        "part_hours": runs * run["cpu_s"] * (1.0 + START_SHARE) / cores / HOUR_S,
    }


def demands(found: Mapping[str, float], cores: int, memory_bytes: float, disk_bytes: float) -> list[tuple[str, float]]:
    """What one command would need for a `study`, in units of what there is, the scarcest first."""
    needs = {
        "the process that hands out and stores": cores / found["cores_fed"],
        "its memory": found["parent_bytes"] / memory_bytes,
        "the disk": found["stored_bytes"] / disk_bytes,
    }
    return sorted(needs.items(), key=lambda item: -item[1])


def page(tiny: Row, rows: Sequence[Row]) -> str:
    """The page as Markdown, from the row of a tiny run and the costs against samples."""
    assert tiny.run is not None, "the row of a tiny run has its measured parts"
    own = study(tiny.run, RUNS, CORES)
    lines = ["# A study of 10^8 runs on 1000 cores", ""]
    for part in (_cost(own, tiny.run, tiny), _first(own), _parts(own, tiny.run), _methods(tiny.run, rows)):
        lines += part
    return "\n".join(lines)


def _cost(own: Mapping[str, float], run: Mapping[str, float], tiny: Row) -> Iterator[str]:
    yield f"""\
What does a study of 10^8 runs take, and what breaks first? The figures on this page are computed from one measured
row of `reports/timing` (`{tiny.what}`:
{tiny.remark}), so they are those of the machine and the code named there. A run is as small as a run can be here: one
fit of `ls-forward` with its record, its scores and its row in the results.

| of one run | measured |
|---|---|
| CPU time in a worker | {_ms(own["worker_s"])} |
| CPU time in the process that hands out and stores | {_ms(run["parent_cpu_s"])} |
| memory of that process | {_size(max(run["parent_bytes"], 0.0))} |
| results on disk | {_size(run["stored_bytes"])} |
| start of a suite, once | {number(run["start_cpu_s"])} CPU s |

| of 10^8 runs on {CORES} cores | computed |
|---|---|
| computing, if nothing holds the cores up | {number(own["hours"])} h |
| results on disk | {_size(own["stored_bytes"])} |
| calls that the cores ask for | {number(own["calls_per_s"])} a second ({number(own["runs_together"])} runs a call) |
| one process that hands out and stores | {number(own["parent_hours"])} h, {_size(own["parent_bytes"])} of memory |
"""


def _first(own: Mapping[str, float]) -> Iterator[str]:
    needs = demands(own, CORES, MEMORY_BYTES, DISK_BYTES)
    yield from ("## What breaks first", "")
    yield f"""\
One command has one process that plans the runs, hands them out and appends the results. In units of what there is (a
machine with {_size(MEMORY_BYTES)} of memory and {_size(DISK_BYTES)} of disk) the study needs:

| | times what there is |
|---|---|
{chr(10).join(f"| {name} | {number(share)} |" for name, share in needs)}

The first line breaks first. One process keeps {number(own["cores_fed"])} cores busy with runs as small as these; longer
runs feed more cores in proportion. It plans all runs before it starts the first one and keeps the finished ones, so its
memory grows with the runs.
"""


def _parts(own: Mapping[str, float], run: Mapping[str, float]) -> Iterator[str]:
    yield from ("## How to cut it", "")
    parts = RUNS / own["runs_a_part"]
    memory = own["runs_a_part"] * max(run["parent_bytes"], 0.0)
    yield f"""\
Cut the study into suites, by seed or vessel, each of which runs on one core with a process of its own (`--jobs 1`) and
writes a directory of its own. The start of a suite takes {START_SHARE:.0%} of its time when it has
{number(own["runs_a_part"])} runs: {number(parts)} parts in all, {number(parts / CORES)} a core. The whole takes
{number(own["part_hours"])} h, and the rows of a part take {_size(memory)} of memory. A job of a queue should take
minutes: let each work through several parts, one after the other. A part that is ended early goes on with `--resume`.
Every part has a table `results.parquet`; read them together with pandas.

A job array (`--array slurm --jobs {CORES}`) stores runs in the folders of its jobs, but the command takes all rows over
into one directory: the process above is still there, and its limits hold.
"""


def _methods(run: Mapping[str, float], rows: Sequence[Row]) -> Iterator[str]:
    yield from ("## With longer fits", "")
    yield f"The fit alone, with {SAMPLES:g} samples a record, by the rows `cost against samples`:"
    yield from (
        "",
        "| method | CPU time of a fit | 10^8 fits on 1000 cores | cores that one process feeds |",
        "|---|---|---|---|",
    )
    for row in rows:
        name = row.what.rpartition(": ")[2]
        times = {size: seconds for size, seconds in row.points} if row.axis == "samples" else {}
        seconds = times.get(SAMPLES)
        if seconds:
            hours, fed = RUNS * seconds / CORES / 3600.0, seconds / run["parent_cpu_s"]
            yield f"| `{name}` | {_ms(seconds)} | {number(hours)} h | {number(max(fed, 1.0))} |"
    yield ""


def _ms(seconds: float) -> str:
    return f"{number(1e3 * seconds)} ms"


def _size(size: float) -> str:
    for unit, factor in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            return f"{number(size / factor)} {unit}"
    return f"{number(size)} bytes"
