"""Reading a record whatever its time stamps and values are, and what was wrong with them.

`read_record` refuses a file that cannot be used as it stands.  A check is to say all that is wrong with it: here rows
without a time are left out, rows are put in the order of their times, of rows with the same time the first is kept,
and infinite values are gaps.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..models.errors import BadInput
from .columns import to_canonical
from .io import read_table
from .record import Record, is_side
from .sidecar import read_sidecar, sidecar_path
from .time_faults import refuse_time_fault


@dataclass(frozen=True)
class Repairs:
    """Rows of a file that were left out or moved: without a time, with a time that stood there already, with a time
    earlier than the row before; infinite values by column."""

    rows: int
    timeless: int = 0
    repeated: int = 0
    backwards: int = 0
    infinite: tuple[tuple[str, int], ...] = ()


def read_leniently(path: str | os.PathLike[str], positive_rudder: str | None = None) -> tuple[Record, Repairs]:
    """Read a record file and correct what keeps it from being a record.

    Parameters
    ----------
    path, positive_rudder : as in `read_record`.

    Raises
    ------
    BadInput : the file cannot be read as a table with known columns, fewer than two rows have a time, or the times
        cannot be those of one run (milliseconds as seconds, a clock that was set).
    """
    path = Path(path)
    if positive_rudder is not None and not is_side(positive_rudder):
        raise BadInput(f"positive rudder {positive_rudder!r}", file=path, hint="give 'port' or 'starboard'")
    columns = to_canonical(read_table(path))
    meta, _ = read_sidecar(sidecar_path(path))
    time = columns.pop("time_s")
    own = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[own])
    ordered = own[np.argsort(time[own], kind="stable")]
    kept = ordered[np.concatenate([[True], np.diff(time[ordered]) > 0.0])] if ordered.size else ordered
    if kept.size < 2:
        raise BadInput("fewer than two rows have a time of their own", file=path, column="time_s")
    infinite = tuple((name, int(np.isinf(v).sum())) for name, v in columns.items() if np.isinf(v).any())
    refuse_time_fault(time[kept], path)
    channels = {name: np.where(np.isinf(v), np.nan, v)[kept] for name, v in columns.items()}
    repairs = Repairs(time.size, time.size - own.size, ordered.size - kept.size, int(np.sum(steps < 0.0)), infinite)
    meta = replace(meta, positive_rudder=positive_rudder or meta.positive_rudder)
    return Record(time[kept], channels, name=path.stem, meta=meta), repairs
