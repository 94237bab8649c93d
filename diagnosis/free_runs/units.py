"""What is left out: pieces of records of some eight ship lengths, or whole records, each with a start of its own; and
what counts as none and is expected of it: steps, floors of errors, spreads of its own effects."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.instruments import felt_rudder
from ...datasets.signals import bridged, lagged
from ...estimation.records.gaps import SHORTEST, clock_of, stretches
from ...estimation.records.series import MEASURED
from ...estimation.run.stretch import Stretch
from ...models.errors import CannotFit
from ...models.model import CHANNELS
from ...models.time_scale import time_scale_s

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

THRUST = "propeller_thrust_N"
CORRELATION = 1.7
"""Correlation time of the residuals of free runs, in ship lengths sailed (10 s for a 7 m model at 1.18 m/s)."""
STEP, INTEGRATION_STEP, SAFE = 0.035, 0.05, 0.5
"""Time step, in ship lengths sailed, that records are thinned to, and the largest of the integration: RK4 with it errs
by under 1e-5 of the yaw rate and the speeds of every vessel here; and the share that a step is of one that some unit's
runs need, as their numbers move in a fit."""
NEUTRAL_ANGLE_SD = np.deg2rad(0.3)
"""Standard deviation of a record's neutral rudder angle about the common one, rad."""
START_SD = {"u": 2.5e-3, "v": 2.5e-3, "r": 3e-3, "psi": 2e-3}
"""Standard deviation of a record's initial state about the estimated one: shares of speed, of speed / length, rad."""
UNMEASURED_SD = 0.03
"""That of velocities that no record measures, and whose start is the model's: share of speed."""
FLOOR = {"u": 2.5e-3, "v": 2.5e-3, "r": 5e-3, "psi": np.deg2rad(0.5), THRUST: 0.05}
"""Error of a whole record below which a channel counts as perfect: shares of speed, of speed / length, rad, share of
the mean thrust."""
OF_PIECES = 0.3
"""Share of FLOOR that counts as perfect in pieces, which are shorter."""
REFERENCE_S = 160.0 / (15.0 * 1852.0 / 3600.0)
"""L/U of a ship of 160 m at 15 kn, s."""
LENGTHS = 8.0
"""Ship lengths sailed in a piece."""
SMOOTHED = 12
"""Samples that measured thrust is averaged over."""
MOSTLY = 0.8
"""Share of its samples that a channel has where it is not sampled more slowly than the record."""
FEWEST, WANTED, MOST = 3, 8, 24
"""Pieces of all records together: without so many nothing is left out; shorter ones are cut until there are so many;
and (but for one a record) the most."""


def length_s(model: Model, records: Sequence[Record]) -> float:
    """Time of one ship length, s; of a model without a time scale that of a ship, by the records' duration."""
    try:
        return time_scale_s(model)
    except CannotFit:
        return REFERENCE_S * clock_of(model, records)


@dataclass(frozen=True)
class Unit:
    """A piece of a record, or a whole one, that is left out.

    number : of its record.  stretch : the model and the piece, thinned.  record : the whole record.  start : state (n,)
    that its run starts from.
    """

    number: int
    stretch: Stretch
    record: Record
    start: np.ndarray

    @property
    def grid_s(self) -> np.ndarray:
        """Times (M + 1,) of the grid, s."""
        return self.stretch.grid_s

    def measured(self, symbols: Sequence[str]) -> np.ndarray:
        """Samples (N, C) of some states, nan where there are none."""
        series, states = self.stretch.series, self.stretch.model.states
        own = {states[c]: series.outputs[:, i] for i, c in enumerate(series.columns.tolist())}
        gap = np.full(len(series.index), np.nan)
        return np.column_stack([own.get(s, gap) for s in symbols])

    @cached_property
    def thrust(self) -> np.ndarray | None:
        """Thrust (N,) of the propeller at the samples, the mean over SMOOTHED of them, N; None where none is
        measured."""
        if not self.record.has(THRUST):
            return None
        values, piece = self.record.column(THRUST), self.stretch.record
        known, window = np.isfinite(values), np.ones(max(1, round(SMOOTHED * piece.dt / self.record.dt)))
        count = np.convolve(known.astype(float), window, "same")
        total = np.convolve(np.where(known, values, 0.0), window, "same")
        mean = np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)
        return np.interp(piece.time_s, self.record.time_s, mean)


class Lane(NamedTuple):
    """One run: number of its unit, values of the numbers by name, own effects (m,) of the unit."""

    unit: int
    values: Mapping[str, float]
    own: np.ndarray


@dataclass(frozen=True)
class Rudder:
    """The rudder of a whole record: what is recorded, and what acts behind a linkage."""

    record: Record

    @cached_property
    def _recorded(self) -> np.ndarray:
        return bridged(self.record.rudder(), self.record.time_s)

    def lagged(self, lag_s: float, at_s: float) -> float:
        """The angle behind a first-order lag at a time, from the record's start on."""
        time_s = self.record.time_s
        step_s = float(np.median(np.diff(time_s)))
        even = np.arange(time_s[0], at_s + step_s, step_s)
        values = lagged(np.interp(even, time_s, self._recorded), lag_s, step_s)
        return float(np.interp(at_s, even, values))

    def change(self, linkage: Mapping[str, float], grid_s: np.ndarray) -> np.ndarray:
        """Acting less recorded angle (M,) at some times."""
        acting = felt_rudder(self.record.time_s, self._recorded, linkage)
        return np.interp(grid_s, self.record.time_s, acting - self._recorded)


def units_of(model: Model, records: Sequence[Record], length: float) -> list[Unit]:
    """The pieces of records behind the model's instruments, in its sign of the rudder.

    length : time of one ship length, s.

    Raises
    ------
    CannotFit : no record has a stretch without long gaps, there are too few pieces, or none measures a state of the
        model.
    """
    stretches_ = [(i, a, b) for i, r in enumerate(records) for a, b in stretches(r, clock_of(model, records))]
    seconds = [float(records[i].time_s[b - 1] - records[i].time_s[a]) for i, a, b in stretches_]
    if not stretches_:
        raise CannotFit(f"no {SHORTEST} samples in turn with a rudder angle")
    piece = max(LENGTHS * length, sum(seconds) / MOST)
    counts = [max(1, int(s / piece)) for s in seconds]
    if sum(counts) < WANTED:
        each = -(-WANTED // len(stretches_))
        counts = [max(1, min(each, (b - a) // SHORTEST)) for _, a, b in stretches_]
    units = []
    for (i, a, b), count, span in zip(stretches_, counts, seconds, strict=True):
        edges = _where_known(model, records[i], np.linspace(a, b, count + 1).astype(int))
        ends = [(first, last) for first, last in pairwise(edges) if last - first >= SHORTEST]
        step = min(length, span / count / LENGTHS)  # short pieces keep as many samples as others
        pieces = [coarse(records[i].slice(first, last), step) for first, last in ends]
        start_s = float(records[i].time_s[0])
        own = [Stretch.of(model, piece, start_s=start_s) for piece in pieces if piece.n >= SHORTEST]
        starts = _starts(model, coarse(records[i].slice(a, b), step), own)
        units += [Unit(i, stretch, records[i], start) for stretch, start in zip(own, starts, strict=True)]
    if len(units) < FEWEST:
        raise CannotFit(f"fewer than {FEWEST} pieces of {SHORTEST} samples")
    return units


def _where_known(model: Model, record: Record, edges: np.ndarray) -> list[int]:
    """First samples of pieces, those in gaps of a channel moved to their end: nothing tells the state there."""
    columns = [CHANNELS[s] for s in MEASURED if s in model.states and record.has(CHANNELS[s])]
    known = [x for name in columns if np.mean(x := np.isfinite(record.column(name))) > MOSTLY]
    places = np.flatnonzero(np.all(known, axis=0)) if known else np.arange(record.n)
    after = np.searchsorted(places, edges[1:-1])
    inner = [int(places[k]) if k < places.size else int(edge) for k, edge in zip(after, edges[1:-1], strict=True)]
    return [int(edges[0]), *inner, int(edges[-1])]


def whole_unit(model: Model, record: Record, length: float, begin_s: float = 0.0) -> Unit:
    """A record as one unit, or a part of one that begins so many s after its start."""
    stretch = Stretch.of(model, coarse(record, length), start_s=float(record.time_s[0]) - begin_s)
    return Unit(0, stretch, record, stretch.state_at(0))


def without_begin(units: Sequence[Unit], late_s: float) -> list[Unit]:
    """The pieces without the first `late_s` s of each record: behind a delay nothing tells what acts there."""
    out = []
    for unit in units:
        piece, model = unit.stretch.record, unit.stretch.model
        first = int(np.searchsorted(piece.time_s, unit.record.time_s[0] + late_s))
        if first == 0:
            out.append(unit)
        elif piece.n - first >= SHORTEST:
            stretch = Stretch.of(model, piece.slice(first, None), start_s=float(unit.record.time_s[0]))
            start = stretch.state_at(0)
            hidden = [i for i, name in enumerate(model.states) if name in ("u", "v") and i not in stretch.known]
            start[hidden] = unit.start[hidden]
            out.append(replace(unit, stretch=stretch, start=start))
    return out


def _starts(model: Model, record: Record, pieces: Sequence[Stretch]) -> list[np.ndarray]:
    """States (n,) that runs of pieces of a stretch start from: smoothed, and a speed and a sway that the record does
    not tell as the model has them there when it follows the whole stretch."""
    states = [piece.state_at(0) for piece in pieces]
    velocities = [i for i, name in enumerate(model.states) if name in ("u", "v")]
    if all({*velocities} <= {*piece.known} for piece in pieces):
        return states
    whole = Stretch.of(model, record)
    hidden = [i for i in velocities if i not in whole.known]
    for state, piece in zip(states[1:], pieces[1:], strict=True):
        for column in hidden:
            state[column] = np.interp(piece.grid_s[0], whole.grid_s, whole.states_along[:, column])
    return states


# ---- scales
def scales(model: Model, length_s: float) -> dict[str, float]:
    """State -> the unit of START_SD and FLOOR, SI; length_s : time of one ship length, s."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return {"u": speed, "v": speed, "r": 1.0 / length_s, "psi": 1.0}


def started_states(model: Model) -> tuple[str, ...]:
    """States whose initial value belongs to a record."""
    return tuple(s for s in START_SD if s in model.states)


def start_sd(model: Model, length_s: float, measured: Collection[str]) -> np.ndarray:
    """(S,) prior standard deviations of the initial values of `started_states`, SI; measured : states that are."""
    unit = scales(model, length_s)
    sd = {s: UNMEASURED_SD if s in ("u", "v") and s not in measured else share for s, share in START_SD.items()}
    return np.array([sd[s] * unit[s] for s in started_states(model)])


def coarse(record: Record, length_s: float) -> Record:
    """The record thinned to STEP."""
    return record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))


def coarsely_integrated(model: Model, units: Sequence[Unit], length_s: float) -> Model:
    """The model with integration steps of INTEGRATION_STEP where its own are shorter, and with shorter ones where its
    runs along some unit need them."""
    own = min(unit.stretch.model.max_step_s for unit in units)
    coarse = max(model.max_step_s, INTEGRATION_STEP * length_s)
    return replace(model, max_step_s=coarse if own >= model.max_step_s else min(coarse, SAFE * own))
