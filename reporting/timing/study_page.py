"""The page on a study of very many runs: every figure is computed from measured rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..numbers import number
from .rows import Row
from .study import START_SHARE, Study

RUNS, CORES = 1e8, 1000
MEMORY_BYTES, DISK_BYTES = 64e9, 10e12
"""What one machine of the example has."""
SAMPLES = 1000.0


def page(tiny: Row, rows: Sequence[Row]) -> str:
    """The page as Markdown, from the row of a tiny run and the costs against samples."""
    assert tiny.run is not None, "the row of a tiny run has its measured parts"
    study = Study(tiny.run, RUNS, CORES)
    lines = ["# A study of 10^8 runs on 1000 cores", ""]
    for part in (_cost(study, tiny), _first(study), _parts(study), _methods(study, rows)):
        lines += part
    return "\n".join(lines)


def _cost(study: Study, tiny: Row) -> Iterator[str]:
    yield f"""\
What does a study of 10^8 runs take, and what breaks first? The figures on this page are computed from one measured
row of `reports/timing` (`{tiny.what}`:
{tiny.remark}), so they are those of the machine and the code named there. A run is as small as a run can be here: one
fit of `ls-forward` with its record, its scores and its row in the results.

| of one run | measured |
|---|---|
| CPU time in a worker | {_ms(study.worker_s)} |
| CPU time in the process that hands out and stores | {_ms(study.run["parent_cpu_s"])} |
| memory of that process | {_size(max(study.run["parent_bytes"], 0.0))} |
| results on disk | {_size(study.run["stored_bytes"])} |
| start of a suite, once | {number(study.run["start_cpu_s"])} CPU s |

| of 10^8 runs on {CORES} cores | computed |
|---|---|
| computing, if nothing holds the cores up | {number(study.hours)} h |
| results on disk | {_size(study.stored_bytes)} |
| calls that the cores ask for | {number(study.calls_per_s)} a second ({number(study.runs_together)} runs a call) |
| one process that hands out and stores | {number(study.parent_hours)} h, {_size(study.parent_bytes)} of memory |
"""


def _first(study: Study) -> Iterator[str]:
    demands = study.demands(MEMORY_BYTES, DISK_BYTES)
    yield from ("## What breaks first", "")
    yield f"""\
One command has one process that plans the runs, hands them out and appends the results. In units of what there is (a
machine with {_size(MEMORY_BYTES)} of memory and {_size(DISK_BYTES)} of disk) the study needs:

| | times what there is |
|---|---|
{chr(10).join(f"| {name} | {number(share)} |" for name, share in demands)}

The first line breaks first. One process keeps {number(study.cores_fed)} cores busy with runs as small as these; longer
runs feed more cores in proportion. It plans all runs before it starts the first one and keeps the finished ones, so its
memory grows with the runs.
"""


def _parts(study: Study) -> Iterator[str]:
    yield from ("## How to cut it", "")
    parts = RUNS / study.runs_a_part
    memory = study.runs_a_part * max(study.run["parent_bytes"], 0.0)
    yield f"""\
Cut the study into suites, by seed or vessel, each of which runs on one core with a process of its own (`--jobs 1`) and
writes a directory of its own. The start of a suite takes {START_SHARE:.0%} of its time when it has
{number(study.runs_a_part)} runs: {number(parts)} parts in all, {number(parts / CORES)} a core. The whole takes
{number(study.part_hours)} h, and the rows of a part take {_size(memory)} of memory. A job of a queue should take
minutes: let each work through several parts, one after the other. A part that is ended early goes on with `--resume`.
Every part has a table `results.parquet`; read them together with pandas.

A job array (`--array slurm --jobs {CORES}`) stores runs in the folders of its jobs, but the command takes all rows over
into one directory: the process above is still there, and its limits hold.
"""


def _methods(study: Study, rows: Sequence[Row]) -> Iterator[str]:
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
            hours, fed = RUNS * seconds / CORES / 3600.0, seconds / study.run["parent_cpu_s"]
            yield f"| `{name}` | {_ms(seconds)} | {number(hours)} h | {number(max(fed, 1.0))} |"
    yield ""


def _ms(seconds: float) -> str:
    return f"{number(1e3 * seconds)} ms"


def _size(size: float) -> str:
    for unit, factor in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            return f"{number(size / factor)} {unit}"
    return f"{number(size)} bytes"
