"""Record: the time series of one run, in SI units and radians, with metadata and gaps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from html import escape
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from ..models.argument_types import shown
from ..models.display import html_table
from ..models.errors import BadInput
from ..models.extras import extras_told
from .columns import CANONICAL, RUDDERS, TWIN, check_header, in_order, to_canonical
from .display import channel_row, continuous, time_figure
from .geometry import unwrapped
from .time_faults import refuse_time_fault

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Side = Literal["port", "starboard"]
SIDES: tuple[Side, Side] = ("port", "starboard")
LEFT_OUT = "left_out"
"""Key of a record's further metadata: column of its file that is no measurement -> why."""


def is_side(value: object) -> TypeGuard[Side]:
    """Whether `value` is 'port' or 'starboard'."""
    return value in SIDES


@dataclass(frozen=True)
class RecordMeta:
    """What is known about a record besides its samples; None where nothing is said.

    `positive_rudder` is the side the ship turns to under a positive rudder ('port' or 'starboard'); None means
    the vessel's own sign. `extra` holds whatever else the sidecar file says and is not to be changed in place; below
    `LEFT_OUT` the columns of the file that are no measurements, each with the reason.

    Raises
    ------
    BadInput : `positive_rudder` is neither a side nor None.
    """

    vessel: str | None = None
    reference_point: str | None = None
    source: str | None = None
    licence: str | None = None
    positive_rudder: Side | None = None
    manoeuvre: str | None = None
    notes: str | None = None
    extra: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.positive_rudder is not None and not is_side(self.positive_rudder):
            raise BadInput(f"positive_rudder is {self.positive_rudder!r}", hint="give 'port' or 'starboard'")


@dataclass(frozen=True, eq=False, repr=False)
class Record:
    """One run: times and channels of equal length.

    Parameters
    ----------
    time_s : (N,) finite, strictly increasing, s; the steps need not be equal. N >= 1.
    channels : canonical name (see `CANONICAL`) -> (N,) samples in SI units and radians, nan = gap. Heading may wrap.
    name : what messages and results call the record (a file's stem).
    meta : vessel, source, rudder sign and the like.

    The arrays are copied unless they are read-only already, and are read-only afterwards; a changed record is a new
    one (`between`, `slice`, `with_channels`, `turned`, `dataclasses.replace`).

    Raises
    ------
    BadInput : unknown channel, unequal lengths, time not finite or not strictly increasing.
    """

    time_s: np.ndarray
    channels: Mapping[str, np.ndarray]
    name: str = "record"
    meta: RecordMeta = field(default_factory=RecordMeta)

    def __post_init__(self) -> None:
        time = _frozen(self.time_s)
        channels = {name: _frozen(values) for name, values in self.channels.items()}
        if time.ndim != 1 or not time.size:
            raise BadInput("a record needs at least one sample, times of shape (N,)", file=self.name, column="time_s")
        if not np.isfinite(time).all():
            raise BadInput("time is not finite everywhere", file=self.name, column="time_s")
        late = np.flatnonzero(np.diff(time) <= 0.0)
        if late.size:
            index = int(late[0])
            raise BadInput(
                f"time does not increase from sample {index} ({time[index]:g} s) to the next ({time[index + 1]:g} s)",
                file=self.name,
                column="time_s",
            )
        for name, values in channels.items():
            if name not in CANONICAL or name == "time_s":
                hint = f"known are {', '.join(list(CANONICAL)[1:])}"
                raise BadInput("unknown channel", file=self.name, column=name, hint=hint)
            if values.shape != (time.size,):
                raise BadInput(f"shape {values.shape} where time has {time.size} samples", file=self.name, column=name)
        object.__setattr__(self, "time_s", time)
        object.__setattr__(self, "channels", MappingProxyType(channels))

    def __reduce__(self):
        return Record, (self.time_s, dict(self.channels), self.name, self.meta)

    @classmethod
    def from_dataframe(cls, frame: pd.DataFrame, name: str = "record", meta: RecordMeta | None = None) -> Record:
        """A record from a pandas table with one row a sample.

        Parameters
        ----------
        frame : columns as in the header of a record file, other units included (`heading_deg`, `surge_kn`, ...); nan
            marks gaps.  The time is the column `time_s` or `time_ms`, or else an index of moments or durations
            (DatetimeIndex, TimedeltaIndex), counted from its first; any other index is not used.
        name : what messages call the record.
        meta : vessel, source, rudder sign and the like.

        Raises
        ------
        BadInput : an unknown, repeated or missing column, a column that does not hold numbers, an infinite value, or a
            time that is not finite, does not increase or cannot be that of one run (milliseconds as seconds, a jump).
        """
        frame = _with_time(frame)
        names = [str(column) for column in frame.columns]
        check_header(names, name)
        columns = {column: _numbers(frame.iloc[:, place], column, name) for place, column in enumerate(names)}
        channels = to_canonical(columns)
        record = cls(channels.pop("time_s"), channels, name, meta or RecordMeta())
        refuse_time_fault(record.time_s, name)
        return record

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The record as a pandas table: a row a sample, `time_s` and the channels as columns, gaps as nan."""
        import pandas as pd

        return pd.DataFrame({name: self.column(name) for name in in_order(["time_s", *self.channels])})

    def plot(self, channels: Sequence[str] | None = None) -> Figure:
        """Draw the channels over time, one below the other; angles in degrees.

        Parameters
        ----------
        channels : names of channels to draw; None: all.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.

        Raises
        ------
        BadInput : the record has no such channel, or none at all.
        """
        names = in_order(self.channels) if channels is None else list(channels)
        if not names:
            raise BadInput("no channel to draw", file=self.name, hint=f"it has {', '.join(self.channels) or 'none'}")
        panels = {name: [("", self.time_s, continuous(name, self.column(name)))] for name in names}
        return time_figure(panels, self.name)

    def __repr__(self) -> str:
        channels = ", ".join(in_order(self.channels)) or "no channels"
        return f"<Record {self.name!r}: {self._extent()}; {channels}>"

    def _repr_html_(self) -> str:
        from ..models.figure import picture

        rows = [channel_row(name, self.column(name)) for name in in_order(self.channels)]
        table = html_table(("channel", "unit", "smallest", "mean", "largest", "gaps"), rows)
        side = self.meta.positive_rudder
        facts = [self.meta.vessel, self.meta.manoeuvre, self.meta.source, f"positive rudder to {side}" if side else ""]
        told = "; ".join(escape(fact) for fact in facts if fact)
        title = f"<p><b>{escape(self.name)}</b>: {escape(self._extent())}{'<br>' + told if told else ''}</p>"
        return title + table + picture(self.plot, f"channels of {self.name} over time")

    def _extent(self) -> str:
        steps = f" every {self.dt:g} s" if self.uniform() else f", median step {self.dt:g} s"
        return f"{self.n} samples, {self.time_s[0]:g} to {self.time_s[-1]:g} s{steps if self.n > 1 else ''}"

    def __len__(self) -> int:
        return self.time_s.size

    @property
    def left_out(self) -> dict[str, str]:
        """Column of the record's file that is no measurement -> why, as `read_record` has them."""
        columns = self.meta.extra.get(LEFT_OUT)
        return {str(c): str(why) for c, why in columns.items()} if isinstance(columns, Mapping) else {}

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.time_s.size

    @property
    def dt(self) -> float:
        """Median time step, s (nan for a single sample)."""
        return self._dt

    @cached_property
    def _dt(self) -> float:
        return float(np.median(np.diff(self.time_s))) if self.n > 1 else float("nan")

    @cached_property
    def _unevenness(self) -> float:
        """Largest difference of a step from the median one, s; for two samples or more."""
        return float(np.abs(np.diff(self.time_s) - self.dt).max())

    def uniform(self, tolerance: float = 1e-3) -> bool:
        """Whether every time step is the median step to within `tolerance` of it."""
        return self.n < 2 or self._unevenness <= tolerance * self.dt

    def has(self, *names: str) -> bool:
        """Whether the record holds all the columns named (`time_s` counts)."""
        return all(name == "time_s" or name in self.channels for name in names)

    def column(self, name: str) -> np.ndarray:
        """Samples (N,) of a channel or of `time_s`; BadInput names the record if it has no such column."""
        if name == "time_s":
            return self.time_s
        if name not in self.channels:
            raise BadInput("no such column", file=self.name, column=name, hint=f"it has {', '.join(self.channels)}")
        return self.channels[name]

    def rudder(self) -> np.ndarray:
        """Rudder angle (N,), rad: the measured one, or else the command; BadInput if there is neither."""
        if not any(map(self.has, RUDDERS)):
            needed = f"{' or '.join(RUDDERS)}, or both {' and '.join(TWIN)}"
            hint = f"what the ship answers to is needed here: {needed}; 'helmbench check' needs none"
            raise BadInput("no rudder in this record", file=self.name, column=RUDDERS[0], hint=hint)
        return self.column("rudder_rad" if self.has("rudder_rad") else RUDDERS[1])

    def heading_unwrapped(self) -> np.ndarray:
        """Heading (N,), rad, without jumps of a full turn; gaps stay nan and are bridged by the shorter way round.

        The array is read-only, as those of the columns are.
        """
        return self._heading_unwrapped

    def continuous(self, name: str) -> np.ndarray:
        """Samples (N,) of a channel, as `column`; the heading as `heading_unwrapped`."""
        return self.heading_unwrapped() if name == "heading_rad" else self.column(name)

    @cached_property
    def _heading_unwrapped(self) -> np.ndarray:
        return _frozen(unwrapped(self.column("heading_rad")))

    def between(self, start_s: float | None = None, stop_s: float | None = None) -> Record:
        """The samples with start_s <= time <= stop_s as a record; None leaves that end open.

        Raises
        ------
        BadInput : no sample lies between the two times.
        """
        first = 0 if start_s is None else int(np.searchsorted(self.time_s, start_s, side="left"))
        stop = self.n if stop_s is None else int(np.searchsorted(self.time_s, stop_s, side="right"))
        if first >= stop:
            hint = f"the record runs from {self.time_s[0]:g} to {self.time_s[-1]:g} s"
            raise BadInput(f"no sample between {start_s} and {stop_s} s", file=self.name, hint=hint)
        return self.slice(first, stop)

    def slice(self, start: int | None, stop: int | None) -> Record:
        """Samples start:stop (indices as in Python, not times) as a record; BadInput if none are left."""
        cut = slice(start, stop)
        if cut.indices(self.n) == (0, self.n, 1):
            return self
        channels = {name: values[cut] for name, values in self.channels.items()}
        return replace(self, time_s=self.time_s[cut], channels=channels)

    def thinned(self, every: int) -> Record:
        """Every `every`-th sample from the first, as a slower logger would have kept."""
        if every == 1:
            return self
        cut = slice(None, None, every)
        channels = {name: values[cut] for name, values in self.channels.items()}
        return replace(self, time_s=self.time_s[cut], channels=channels)

    def with_channels(self, **channels: ArrayLike | None) -> Record:
        """The record with channels (N,) added or replaced; None leaves a channel out."""
        merged = {**self.channels, **channels}
        return beside(self, channels={name: values for name, values in merged.items() if values is not None})

    def turned(self, to: str) -> Record:
        """The record with the rudder's sign such that positive steers to `to`.

        Rudder and rudder command change sign where the metadata say the other side; where they say nothing, or where
        the command is that of two propellers, the samples stay as they are. BadInput if `to` is not a side.
        """
        if self.meta.positive_rudder == to:
            return self
        meta = replace(self.meta, positive_rudder=to)
        if self.meta.positive_rudder is None or self.has(*TWIN):
            return beside(self, meta=meta)
        flipped = {name: 0.0 - self.channels[name] for name in RUDDERS if name in self.channels}
        return beside(self, channels={**self.channels, **flipped}, meta=meta)

    def equals(self, other: Record) -> bool:
        """Whether both have equal times, channels (gaps in the same places), names and metadata."""
        return (
            (self.name, self.meta) == (other.name, other.meta)
            and self.channels.keys() == other.channels.keys()
            and np.array_equal(self.time_s, other.time_s)
            and all(np.array_equal(self.channels[k], other.channels[k], equal_nan=True) for k in self.channels)
        )


def beside(record: Record, **changed: Any) -> Record:
    """A record at the same times with other `channels`, `meta` or `name`: what is known of the times is not computed
    again."""
    other = replace(record, **changed)
    known = {"_dt": record.dt, **vars(record)}
    vars(other).update({name: known[name] for name in ("_dt", "_unevenness") if name in known})
    return other


def _frozen(values: ArrayLike) -> np.ndarray:
    """`values` as a read-only float64 array; copied unless it is one already."""
    array = np.asarray(values, dtype=np.float64)
    if array.flags.writeable or not array.flags.c_contiguous:
        array = np.array(array, order="C")
        array.flags.writeable = False
    return array


@extras_told()
def _with_time(frame: pd.DataFrame) -> pd.DataFrame:
    """A pandas table with its index as the column `time_s`, where it has no time and the index is one."""
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise BadInput(f"frame is {shown(frame)}", hint="give a pandas DataFrame")
    index = frame.index
    if {"time_s", "time_ms"} & {*map(str, frame.columns)} or not isinstance(
        index, pd.DatetimeIndex | pd.TimedeltaIndex
    ):
        return frame
    return frame.assign(time_s=(index - index[0]) / pd.Timedelta(seconds=1) if len(index) else [])


def _numbers(column: Any, name: str, record: str) -> np.ndarray:
    """A column of a pandas table as (N,) float64; BadInput where it holds anything but finite numbers and nan."""
    if column.dtype.kind in "mM":
        hint = "give seconds: (t - t.iloc[0]).dt.total_seconds()"
        raise BadInput(f"type {column.dtype} where numbers should be", file=record, column=name, hint=hint)
    try:
        values = np.asarray(column.to_numpy(dtype=np.float64, na_value=np.nan))
    except (TypeError, ValueError):
        raise BadInput(f"type {column.dtype} where numbers should be", file=record, column=name) from None
    infinite = np.isinf(values)
    if infinite.any():
        row = int(infinite.argmax()) + 1
        raise BadInput("infinite value", file=record, row=row, column=name, hint="use nan for a gap")
    return values
