"""Figures of free runs against measured channels, for every result that holds traces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..models.errors import BadInput

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..diagnosis.trace import Trace


def trace_of(traces: Sequence[Trace], record: str | None, what: str) -> Trace:
    """The trace of a record; None: the first held-out one, else the first.

    what : what the traces belong to, for the message.

    Raises
    ------
    BadInput : there is no such record.
    """
    held_out = [trace for trace in traces if trace.role == "held_out"]
    own = [trace for trace in traces if trace.record == record] if record else [*held_out, *traces]
    if not own:
        hint = f"it has {', '.join(trace.record for trace in traces) or 'none'}"
        raise BadInput(f"the {what} has no such record", file=record, hint=hint)
    return own[0]


def trace_figure(trace: Trace, runs: Mapping[str, Mapping[str, np.ndarray]], title: str) -> Figure:
    """Channels of a trace over time; runs : label -> column -> (T,), the measured channels among them."""
    from ..datasets.display import Curve, continuous, time_figure

    panels = {
        name: [Curve(label, trace.time, continuous(name, run[name])) for label, run in runs.items() if name in run]
        for name in trace.measured
    }
    return time_figure(panels, f"{title}: {trace.record} ({trace.role.replace('_', ' ')})")
