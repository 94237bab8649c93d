"""Errors of free runs of pieces of the records, and their linearisation in any numbers of the bank.

All perturbed runs are lanes of one simulation (`models.lanes`): a column is the difference of two runs over the step of
its number.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...datasets.instruments import REVOLUTIONS, gear_of
from ...datasets.signals import sensor_sd
from ...estimation.records.gaps import SHORTEST
from ...estimation.records.series import MEASURED
from ...estimation.selection.selection import mean_squares
from ...models.coefficient_groups import names_of
from ...models.errors import CannotFit
from ...models.instruments import SENSORS, bent, similar, straightened
from ...models.lanes import open_loops
from ...models.model import CHANNELS
from ...models.outputs import thrust_of
from ...models.regimes import values_of
from ...models.simulate import DIFFERENCE
from .linearisation import Linearisation
from .motion import motion_of
from .units import (
    CORRELATION,
    FEWEST,
    FLOOR,
    NEUTRAL_ANGLE_SD,
    OF_PIECES,
    THRUST,
    Lane,
    Rudder,
    coarsely_integrated,
    scales,
    start_sd,
    started_states,
    without_begin,
)
from .waves import waves_along

if TYPE_CHECKING:
    from ...estimation.selection.minimiser import Fitted, Point
    from ...estimation.selection.number import Number
    from ...estimation.selection.quadratic import Quadratic
    from ...models.model import Model
    from ...models.regimes import Regime
    from .bank import Bank, Place
    from .motion import Motion, Series
    from .units import Unit
    from .waves import Waves

LIMIT = 3e3
"""Error, in floors, beyond which a run counts as lost; larger ones count as this."""
NOISE, NOISE_ERROR = 1.1, 6.0
"""Factor on the sensors' squared noise, and two relative standard errors of that as it is estimated from n samples,
times sqrt(n): the median of third differences, which depend on each other."""
SENSOR = {symbol: short for short, (column, _) in SENSORS.items() for symbol in MEASURED if column == CHANNELS[symbol]}
"""State -> short name of the sensor that shows it."""
SMOOTH = 0.3
"""Ship lengths that the measured motion is smoothed over where a force follows it."""
INPUTS, SHOWN = ("steering", "flow", "term", "window"), ("sensor", "drift")
"""Kinds of numbers that change the inputs of a run, and what instruments show of it."""
LAGGED, LAG = "lead_state", "lead_T2"
"""State of a rudder behind a lag, and the time of the lag: it starts where the record before the piece leads it."""
ABOUT = 3
"""Linearisations that are kept, those that were used last: many fits begin at one point."""
ALL: slice = slice(None)
"""All units."""
OUTSIDE, PUSH = 7, 1
"""Inputs of the environment variant behind the model's own, and of the variant of a response model that is pushed."""


@dataclass(eq=False)
class _Numbers:
    """Numbers that are not zero, sorted by what they move: kind of place -> name -> value."""

    places: Mapping[str, Place]
    kinds: dict[str, dict[str, float]] = field(default_factory=dict)

    @cached_property
    def instruments(self) -> dict[str, float]:
        """Instruments of the sensors that are not ideal."""
        sensors = self.kinds.get("sensor", {})
        return similar({entry: x for name, x in sensors.items() for entry in self.places[name].entries})

    @cached_property
    def driven_as(self) -> tuple[float, bool, tuple[tuple[str, float], ...]]:
        """What runs that are simulated together have in common: clock, whether in regimes, numbers of the windage."""
        clock = 1.0 + self.instruments.get("clock_rate", 0.0)
        return clock, "regime" in self.kinds, tuple(self.kinds.get("windage", {}).items())

    def items(self, kinds: Sequence[str]) -> tuple[tuple[str, float], ...]:
        """Names and values of some kinds."""
        return tuple(item for kind in kinds for item in self.kinds.get(kind, {}).items())


class _Run(NamedTuple):
    """A lane with its numbers sorted."""

    unit: int
    numbers: _Numbers
    own: np.ndarray

    def of(self, kind: str) -> Mapping[str, float]:
        """Numbers of one kind."""
        return self.numbers.kinds.get(kind, {})


class Driven(NamedTuple):
    """Lanes of one time step: states (B, M + 1, n), inputs (B, M + 1, nu), numbers of the model (B, m)."""

    states: np.ndarray
    inputs: np.ndarray
    theta: np.ndarray


class FreeRuns:
    """The problem of a fit or a selection (`estimation.selection.minimiser.UnitErrors`): units are pieces of records,
    or whole ones, which have a neutral rudder angle of their own, too.

    Eq. 1 of docs/mathematics/calibration.md.

    Channels are the states that the records measure, and the propeller's thrust where one measures it and the model
    says it.

    length_s : time of one ship length, s.  waves : motion in waves along all records, and along each.

    Raises
    ------
    CannotFit : no state is measured often enough.
    """

    def __init__(
        self,
        bank: Bank,
        units_: Sequence[Unit],
        length_s: float,
        whole: bool = False,
        waves: tuple[Waves, ...] = (),
    ) -> None:
        self.bank, self.length_s, self.whole, self.waves = bank, length_s, whole, waves
        self.units, self.places = list(units_), bank.places
        self.model = replace(coarsely_integrated(bank.model, self.units, length_s), windage=bank.windage_with({}))
        values = np.array([np.isfinite(u.measured(MEASURED)).sum(axis=0) for u in self.units])
        self.symbols = [s for s, n in zip(MEASURED, values.mean(axis=0), strict=True) if n >= SHORTEST]
        if not self.symbols:
            raise CannotFit(f"no state is measured at {SHORTEST} times in a piece")
        self.thrust = thrust_of(bank.model.family) if any(u.thrust is not None for u in self.units) else None
        self._columns = [bank.model.states.index(s) for s in self.symbols]
        self.floor = self._floors()
        self.floor[: len(self.symbols)] *= 1.0 if whole else OF_PIECES
        self.limit = LIMIT * self.floor
        self._own_places = [bank.model.states.index(s) for s in started_states(bank.model)]
        starts = start_sd(bank.model, length_s, self.symbols)
        for own in waves[:1]:
            starts = np.hypot(starts, [own.of_states.get(s, 0.0) for s in started_states(bank.model)])
        self.own_sd = np.array([NEUTRAL_ANGLE_SD, *starts]) if whole else starts
        self.measured = [self._measured(u) for u in self.units]
        self.counts = np.array([np.isfinite(m).sum(axis=0) for m in self.measured], float)
        spans = [u.stretch.series.dt * len(u.grid_s) for u in self.units]
        self.weight = np.array([
            min(1.0, span / (CORRELATION * length_s) / max(n, 1.0))
            for span, n in zip(spans, self.counts.max(axis=1), strict=True)
        ])  # fmt: skip
        self.rudders = {u.number: Rudder(u.record) for u in self.units}
        self._gears = {u.number: gear_of(u.record, bank.model) for u in self.units}
        self._terms: dict[tuple[int, str], np.ndarray] = {}
        self._series: dict[tuple[int, str], np.ndarray] = {}
        self._about: list[Linearisation] = []

    @property
    def channels(self) -> list[str]:
        """Columns of records that count."""
        return [*(CHANNELS[s] for s in self.symbols), *([] if self.thrust is None else [THRUST])]

    def _floors(self) -> np.ndarray:
        """Errors (C,) of whole records that count as none."""
        unit, thrust = scales(self.bank.model, self.length_s), [u.thrust for u in self.units if u.thrust is not None]
        own = [FLOOR[s] * unit[s] for s in self.symbols]
        mean = np.mean([np.nanmean(np.abs(one)) for one in thrust]) if thrust else 0.0
        return np.array(own if self.thrust is None else [*own, FLOOR[THRUST] * mean])

    def _measured(self, unit: Unit) -> np.ndarray:
        """Samples (N, C) of the channels in a unit, nan where there are none."""
        states = unit.measured(self.symbols)
        if self.thrust is None:
            return states
        return np.column_stack([states, np.full(len(states), np.nan) if unit.thrust is None else unit.thrust])

    def require_turns(self) -> None:
        """Refuse records without a manoeuvre.

        Raises
        ------
        CannotFit : the ship does not turn.
        """
        turning = [c for c, s in enumerate(self.symbols) if s in ("r", "psi")]
        if not np.any(self.motion[turning] > self._floors()[turning]):
            raise CannotFit("the ship does not turn: the records hold no manoeuvre")

    def with_numbers(self, places: Mapping[str, Place], series: Mapping[str, Series]) -> FreeRuns:
        """The same runs with further numbers: what they move, and forces along a motion."""
        runs = copy(self)
        runs.bank = replace(self.bank, places={**self.places, **places}, series={**self.bank.series, **series})
        runs.places = runs.bank.places
        runs._terms, runs._series = (
            {key: x for key, x in known.items() if key[1] not in places} for known in (self._terms, self._series)
        )
        return runs

    def sharper(self, share: float) -> FreeRuns:
        """The same runs with a share of the errors of states that count as none."""
        runs = copy(self)
        runs.floor = self.floor * np.where(self.known, 1.0, share)
        return runs

    def in_waves(self) -> FreeRuns:
        """The same runs with the motion in waves that they show, which their starts are uncertain by."""
        waves = waves_along(self, self._errors_at_rest)
        return FreeRuns(self.bank, self.units, self.length_s, self.whole, waves) if waves else self

    @property
    def smooth_s(self) -> float:
        """Time that motion is smoothed over, s: quicker is what a hull does not do by itself, as in waves."""
        return max([SMOOTH * self.length_s, *(w.period_s for w in self.waves)])

    def without(self, ids: Collection[str]) -> FreeRuns:
        """The same runs without candidates (`Candidate.of`) of the bank."""
        runs = copy(self)
        runs.bank = self.bank.without(ids)
        return runs

    def without_begin(self, late_s: float) -> FreeRuns:
        """The runs without the first `late_s` s of each record; the same where that leaves too few pieces."""
        units = without_begin(self.units, late_s)
        return self.along(units) if len(units) >= FEWEST else self

    def along(self, units: Sequence[Unit]) -> FreeRuns:
        """The free runs of other units."""
        return FreeRuns(self.bank, units, self.length_s, self.whole, self.waves)

    @property
    def known(self) -> np.ndarray:
        """Channels (C,) whose errors have the size of the floor: measured thrust."""
        return np.array([column == THRUST for column in self.channels])

    @cached_property
    def noise(self) -> np.ndarray:
        """Mean squared noise (C,) of the sensors in the units; none is known of thrust."""
        records = [u.stretch.record for u in self.units]
        sds = [[sensor_sd(r.column(CHANNELS[s])) for r in records if r.has(CHANNELS[s])] for s in self.symbols]
        known = np.array([np.mean(np.square(own)) if own else 0.0 for own in sds])
        return np.pad(known, (0, len(self.floor) - len(known)))

    @cached_property
    def _errors_at_rest(self) -> list[np.ndarray]:
        """Errors (C, N) of each unit by the base model without numbers and own effects."""
        lanes = [Lane(k, {}, own) for k, own in enumerate(self.no_own)]
        return [errors[:, 0] for errors in self.errors(lanes)]

    @cached_property
    def quick(self) -> np.ndarray:
        """Sums of squared errors (K, C) of runs that are quicker than what a hull does by itself: of noise of the
        sensors, and of motion in waves.

        Eq. 13 of docs/mathematics/pieces.md.
        """
        sums = np.zeros_like(self.counts)
        for k, error in enumerate(self._errors_at_rest):
            known = self._by_channel[k][1][:, 0]
            width = max(1, int(self.smooth_s / self.units[k].stretch.series.dt) | 1)
            share = np.maximum(uniform_filter1d(known, width, axis=1, mode="constant"), 1e-9)
            slow = uniform_filter1d(error, width, axis=1, mode="constant") / share
            sums[k] = np.sum(error**2 - known * slow**2, axis=1) * ~self.known
        return sums

    def irregular(self, units: Sequence[int] | slice = ALL) -> np.ndarray:
        """Mean squared error (C,) of the runs of some units that no number takes off."""
        return np.maximum(self.noise, self.quick[units].sum(axis=0) / np.maximum(self.counts[units].sum(axis=0), 1.0))

    def no_matter(self, units: Sequence[int] | slice = ALL) -> np.ndarray:
        """Squared errors (C,) of some units that are irregular, as they are estimated, and of what counts as none, eq.
        13 of docs/mathematics/pieces.md."""
        return self._noise_factor * self.irregular(units) + self.floor**2

    @cached_property
    def _noise_factor(self) -> np.ndarray:
        """Factor (C,) on what is irregular, by the samples that tell it."""
        records = {u.number: u.record for u in self.units}.values()
        columns = [CHANNELS[s] for s in self.symbols]
        samples = [sum(np.count_nonzero(np.isfinite(r.column(c))) for r in records if r.has(c)) for c in columns]
        error = NOISE_ERROR / np.sqrt(np.maximum(np.array(samples, float), 1.0))
        return NOISE + np.pad(error, (0, len(self.floor) - len(error)))

    def excess(self, fitted: Fitted) -> np.ndarray:
        """Mean squared errors (C,) of left-out units beyond what is no matter, as shares of the motion squared."""
        return self.beyond(mean_squares(self, fitted.left_out))

    def beyond(self, means: np.ndarray, units: Sequence[int] | slice = ALL) -> np.ndarray:
        """Mean squared errors (C,) of some units beyond what is no matter there, as shares of the motion squared."""
        return np.maximum(means - self.no_matter(units), 0.0) / self.motion**2

    def worst(self, fitted: Fitted) -> float:
        """Largest error of left-out units beyond what is no matter, as a share of the motion."""
        return float(np.sqrt(np.max(self.excess(fitted))))

    def share_taken(self, before: Fitted, after: Fitted) -> float:
        """Share of the excess that a fit takes off, the sum over channels; eq. 13 of docs/mathematics/pieces.md."""
        old, new = (float(np.sum(self.excess(fitted))) for fitted in (before, after))
        return float(np.clip((old - new) / max(old, 1e-12), 0.0, 1.0))

    @property
    def record_names(self) -> dict[int, str]:
        """Number of a record -> its name."""
        return {u.number: u.record.name for u in self.units}

    @property
    def no_own(self) -> np.ndarray:
        """Own effects (K, m) of units that have none."""
        return np.zeros((len(self.units), self.own_sd.size))

    @cached_property
    def motion(self) -> np.ndarray:
        """Root mean square (C,) of each channel about its mean in a unit, of thrust itself, SI."""
        sums = (np.nansum(m, axis=0) * ~self.known for m in self.measured)
        means = [total / np.maximum(n, 1.0) for total, n in zip(sums, self.counts, strict=True)]
        squares = [np.nansum((m - mean) ** 2, axis=0) for m, mean in zip(self.measured, means, strict=True)]
        return np.sqrt(np.sum(squares, axis=0) / np.maximum(self.counts.sum(axis=0), 1.0))

    # ---- the problem
    def squares(self, values: Sequence[Mapping[str, float]], own: np.ndarray) -> np.ndarray:
        """Sums of squared errors (K, C)."""
        lanes = [Lane(k, v, o) for k, (v, o) in enumerate(zip(values, own, strict=True))]
        return np.array([np.sum(e[:, 0] ** 2, axis=1) for e in self.errors(lanes)])

    def quadratic(self, values: Mapping[str, float], own: np.ndarray, numbers: Sequence[Number]) -> Quadratic:
        """Linearisation about a point, eq. 1 of docs/mathematics/pieces.md."""
        about = next((one for one in self._about if one.is_at(values, own)), None) or Linearisation(self, values, own)
        self._about[:] = [about, *(one for one in self._about if one is not about)][:ABOUT]
        return about.quadratic(self, numbers)

    # ---- runs
    def errors(self, lanes: Sequence[Lane]) -> list[np.ndarray]:
        """Measured less shown states (C, B, N) of the lanes of each unit, 0 where nothing is measured.

        lanes : those of a unit follow each other.
        """
        by_unit: dict[int, list[_Run]] = {}
        for lane in self._sorted(lanes):
            by_unit.setdefault(lane.unit, []).append(lane)
        by_step: dict[float, list[int]] = {}
        for k in by_unit:
            by_step.setdefault(round(self.units[k].stretch.series.dt, 9), []).append(k)
        out: dict[int, np.ndarray] = {}
        for units_ in by_step.values():
            driven, first = self._driven([lane for k in units_ for lane in by_unit[k]]), 0
            channels = self._channels_of(driven)
            for k in units_:
                last = first + len(by_unit[k])
                out[k] = self._errors(by_unit[k], channels[:, first:last])
                first = last
        return [out[k] for k in by_unit]

    def _driven(self, lanes: Sequence[_Run]) -> Driven:
        """Lanes of one time step; shorter ones go on with their last input."""
        inputs = _equally_long(self._once(self._inputs, INPUTS, lanes))
        thetas = {own: self._theta(own.kinds.get("model", {})) for own in {lane.numbers for lane in lanes}}
        theta = np.array([thetas[lane.numbers] for lane in lanes])
        kinds = (*SHOWN, "model") if LAGGED in self.model.states else SHOWN
        start = np.array(self._once(self._start, kinds, lanes))
        effects = np.array([lane.own for lane in lanes])
        if self.whole:
            inputs[:, :, 0] += effects[:, :1]
        start[:, self._own_places] += effects[:, int(self.whole) :]
        gain = self.model.kernels.RATE_GAIN
        if gain is not None:  # the smoothed yaw acceleration stands in the place of the hidden state
            start[:, 0] -= theta[:, gain] * inputs[:, 0, 0]
        dt = self.units[lanes[0].unit].stretch.series.dt
        states, together = np.empty((*inputs.shape[:2], start.shape[1])), dict[tuple, list[int]]()
        for i, lane in enumerate(lanes):
            together.setdefault(lane.numbers.driven_as, []).append(i)
            if (scale := lane.numbers.instruments.get("ship_scale")) and self._turns_recorded(lane.unit):
                inputs[i, :, self.model.inputs.index("n")] *= np.sqrt(1.0 + scale)
        with np.errstate(all="ignore"):
            for (clock, regimes, windage), own in together.items():
                within = zip(*(self._inside(lanes[i], theta[i]) for i in own), strict=True) if regimes else ()
                model = self._in_wind(dict(windage))
                states[own] = open_loops(model, theta[own], inputs[own], dt / clock, start[own], *within)
        return Driven(states, inputs, theta)

    def _in_wind(self, windage: Mapping[str, float]) -> Model:
        """The model with numbers of its windage."""
        return replace(self.model, windage=self.bank.windage_with(windage)) if windage else self.model

    def _turns_recorded(self, unit: int) -> bool:
        """Whether the revolutions along a unit are an input of the model, and are recorded."""
        return "n" in self.model.inputs and self.units[unit].record.has(REVOLUTIONS)

    def _once(self, of: Callable[[_Run], np.ndarray], kinds: Sequence[str], lanes: Sequence[_Run]) -> list[np.ndarray]:
        """What lanes have by their unit and their numbers of some kinds, worked out once for those that are alike."""
        alike: dict[tuple[object, ...], int] = {}
        of_set = {own: alike.setdefault(own.items(kinds), len(alike)) for own in {lane.numbers for lane in lanes}}
        known: dict[tuple[int, int], np.ndarray] = {}
        keys = [(lane.unit, of_set[lane.numbers]) for lane in lanes]
        for key, lane in zip(keys, lanes, strict=True):
            if key not in known:
                known[key] = of(lane)
        return [known[key] for key in keys]

    def _sorted(self, lanes: Sequence[Lane]) -> list[_Run]:
        """Lanes with their numbers by kind, those of the same values sorted once."""
        by_set: dict[int, _Numbers] = {}
        for values in {id(lane.values): lane.values for lane in lanes}.values():
            kinds = by_set.setdefault(id(values), _Numbers(self.places)).kinds
            for name, x in values.items():
                if x:
                    kinds.setdefault(self.places[name].kind, {})[name] = x
        return [_Run(lane.unit, by_set[id(lane.values)], lane.own) for lane in lanes]

    def _theta(self, changes: Mapping[str, float]) -> np.ndarray:
        """Numbers (m,) of the model with changes by name."""
        theta = self.model.theta.copy()
        for name, value in changes.items():
            theta[self.places[name].column] += value
        return theta

    def _inside(self, lane: _Run, theta: np.ndarray) -> tuple[np.ndarray, Regime]:
        """The model's numbers in the regime of a lane, and the regime by the time of the unit."""
        ((name, x),) = lane.of("regime").items()
        place, unit, inside = self.places[name], self.units[lane.unit], theta.copy()
        for column, change in place.inside:
            inside[column] += x * change
        where = place.regime
        assert where is not None
        if where.variable == "time":
            where = replace(where, threshold=where.threshold - (unit.grid_s[0] - unit.record.time_s[0]))
        return inside, where

    def driven(self, lane: Lane) -> Driven:
        """States, inputs and numbers of one run."""
        return self._driven(self._sorted([lane]))

    def model_at(self, values: Mapping[str, float]) -> Model:
        """The model with numbers of its windage."""
        return self._in_wind({n: x for n, x in values.items() if x and self.places[n].kind == "windage"})

    def states_of(self, point: Point) -> list[np.ndarray]:
        """States (M + 1, n) of the run of every unit at a point."""
        return [self.driven(Lane(k, point.values, own)).states[0] for k, own in enumerate(point.own)]

    def _start(self, lane: _Run) -> np.ndarray:
        """The state (n,) that a lane starts from: the smoothed one, without what its sensors add to it."""
        unit = self.units[lane.unit]
        start, own, drifts = unit.start.copy(), lane.numbers.instruments, self._drifts(lane)
        if LAGGED in self.model.states:
            late = lane.of("model").get(LAG, 0.0)
            start[self.model.states.index(LAGGED)] = self._lagged(unit.number, late, unit.grid_s[0])
        for c, first, slope in drifts:
            start[self._columns[c]] -= first + slope * (unit.grid_s[0] - unit.record.time_s[0])
        for c, symbol in zip(self._columns, self.symbols, strict=True):
            short = SENSOR[symbol]
            if late := own.get(f"{short}_delay"):
                self._start_later(unit, start, symbol, late)
            start[c] = straightened(start[c] - own.get(f"{short}_bias", 0.0), *_gain(own, short))
        if "r" not in self.symbols:  # from the heading, in recorded time
            start[self.bank.model.states.index("r")] *= 1.0 + own.get("clock_rate", 0.0)
        if "axis_misalignment" in own:
            places = [self.bank.model.states.index(s) for s in ("u", "v")]
            start[places] = _turned(*start[places], -own["axis_misalignment"])
        if "point_ahead" in own:
            sway, rate = (self.bank.model.states.index(s) for s in ("v", "r"))
            start[sway] -= own["point_ahead"] * start[rate]
        return start

    @lru_cache(maxsize=4096)  # noqa: B019 (lives as long as one diagnosis)
    def _lagged(self, number: int, change_s: float, at_s: float) -> float:
        """The rudder behind a lag at a time of a record; change_s : of the lag, from that of the model."""
        return self.rudders[number].lagged(float(self.model.theta[names_of(self.model).index(LAG)]) + change_s, at_s)

    def _start_later(self, unit: Unit, start: np.ndarray, symbol: str, late: float) -> None:
        """Change a start (n,) to what a channel shows `late` s later; the yaw rate, too, that a late heading tells."""
        states, grid_s = self.bank.model.states, unit.grid_s - unit.grid_s[0]
        for name in (symbol, *(("r",) if symbol == "psi" and "r" not in self.symbols else ())):
            column = states.index(name)
            if column in unit.stretch.known:
                start[column] = np.interp(late, grid_s, unit.stretch.known[column])

    def _drifts(self, lane: _Run) -> list[tuple[int, float, float]]:
        """Channels whose sensors drift in a lane, with their errors at the start of the record and growth in a
        second."""
        number = self.units[lane.unit].number
        own = [(self.places[n], x) for n, x in lane.of("drift").items()]
        return [
            (self.symbols.index(p.entries[0]), *((x, 0.0) if p.column else (0.0, x)))
            for p, x in own
            if p.record in (None, number)
        ]

    def _inputs(self, lane: _Run) -> np.ndarray:
        """Inputs (M + 1, nu) of a lane, with those of the environment where it or the record has some."""
        unit = self.units[lane.unit]
        inputs, nu = unit.stretch.series.inputs.copy(), len(self.model.inputs)
        linkage = dict(self._gears[unit.number])
        moved = [(self.places[n], n, x) for kind in INPUTS for n, x in lane.of(kind).items()]
        for place, name, x in moved:
            if place.record not in (None, unit.number):
                continue
            if place.kind == "steering":
                entry = place.entries[0]
                linkage[entry] = 1.0 / x if place.inverse else linkage.get(entry, 0.0) + x
                linkage |= dict(place.fixed)
                continue
            inputs = self.with_environment(inputs)
            inputs[:, nu + place.column] += x * (1.0 if place.kind == "flow" else self.force_along(lane.unit, name))
        if linkage:
            inputs[:, 0] += self._change(lane.unit, tuple(sorted(linkage.items())))
        return inputs

    def with_environment(self, inputs: np.ndarray) -> np.ndarray:
        """Inputs (M + 1, nu) with the environment's columns."""
        if inputs.shape[1] > len(self.model.inputs):
            return inputs
        return np.hstack([inputs, np.zeros((len(inputs), OUTSIDE if self.model.is_3dof else PUSH))])

    @lru_cache(maxsize=4096)  # noqa: B019 (lives as long as one diagnosis)
    def _change(self, k: int, linkage: tuple[tuple[str, float], ...]) -> np.ndarray:
        return self.rudders[self.units[k].number].change(dict(linkage), self.units[k].grid_s)

    @cached_property
    def motions(self) -> dict[int, Motion]:
        """Number of a record -> its measured motion."""
        return {n: motion_of(self.model, r.record, self.smooth_s) for n, r in self.rudders.items()}

    def share_along(self, k: int, name: str, run: Driven) -> np.ndarray:
        """What a number of one has of its influence (M + 1,) along a run of a unit: a force, or the indicator of a
        regime."""
        where = self.places[name].regime
        if where is None:
            return self.force_along(k, name)
        unit, own = self.units[k], dict(zip(self.model.states, run.states[0].T, strict=True))
        values = values_of(own, run.inputs[0, :, 0], unit.grid_s - unit.record.time_s[0])
        return where.inside(values[where.variable])

    def force_along(self, k: int, name: str) -> np.ndarray:
        """Force (M + 1,) on the grid of a unit for a number of one."""
        if (k, name) not in self._terms:
            self._terms[k, name] = self._term_of(k, name)
        return self._terms[k, name]

    def _term_of(self, k: int, name: str) -> np.ndarray:
        unit, place = self.units[k], self.places[name]
        if place.kind == "window":
            number, count = map(int, place.entries)
            share = (unit.grid_s - unit.grid_s[0]) / (unit.grid_s[-1] - unit.grid_s[0])
            return (np.minimum(share * count, count - 1).astype(int) == number).astype(float)
        motion = self.motions[unit.number]
        if (unit.number, name) not in self._series:
            self._series[unit.number, name] = self.bank.series[name](motion)
        return np.interp(unit.grid_s, motion.time_s, self._series[unit.number, name])

    def _channels_of(self, driven: Driven) -> np.ndarray:
        """Channels (C, B, M + 1) of lanes, as ideal sensors show them."""
        states = driven.states.transpose(2, 0, 1)[self._columns]
        if self.thrust is None:
            return states
        inputs = driven.inputs[:, :, : len(self.model.inputs)]
        with np.errstate(all="ignore"):
            return np.concatenate([states, self.thrust(driven.states, inputs, driven.theta[:, None])[None]])

    def _errors(self, lanes: Sequence[_Run], channels: np.ndarray) -> np.ndarray:
        """Errors (C, B, N) of the lanes of one unit; channels (C, B, M + 1) : of ideal sensors."""
        k = lanes[0].unit
        series = self.units[k].stretch.series
        channels = channels[:, :, : len(series.inputs)]
        alike: dict[tuple[tuple[str, float], ...], list[int]] = {}
        for place, lane in enumerate(lanes):
            alike.setdefault(lane.numbers.items(SHOWN), []).append(place)
        for places in (places for numbers, places in alike.items() if numbers):
            channels[:, places] = self._shown(lanes[places[0]], channels[:, places], series.dt)
        measured, known = self._by_channel[k]
        error = measured - np.moveaxis(series.observe(np.moveaxis(channels, 2, 0)), 0, 2)
        limit = self.limit[:, None, None]
        return np.fmax(np.fmin(error, limit), -limit) * known  # a run that is lost has the limit in the place of nan

    def errors_by(self, k: int, states: np.ndarray, thrust: np.ndarray) -> np.ndarray:
        """Changes (C, q, N) of the errors of a unit whose sensors are ideal by small changes of states (M + 1, n, q),
        and of the thrust (M + 1, q)."""
        series = self.units[k].stretch.series
        own = [] if self.thrust is None else [thrust[:, None]]
        channels = np.concatenate([states[:, self._columns], *own], axis=1)[: len(series.inputs)]
        return -series.observe(channels).transpose(1, 2, 0) * self._by_channel[k][1]

    def thrust_slopes(self, driven: Driven) -> np.ndarray:
        """Slopes (M + 1, n) of a run's thrust by the states; none where it is no channel."""
        states, inputs, theta = driven.states[0], driven.inputs[0, :, : len(self.model.inputs)], driven.theta[0]
        if self.thrust is None:
            return np.zeros_like(states)
        steps = DIFFERENCE * np.diag(1.0 + np.max(np.abs(states), axis=0))
        moved = [self.thrust(states + step, inputs, theta[None]) for step in steps]
        return (np.column_stack(moved) - self.thrust(states, inputs, theta[None])[:, None]) / np.diag(steps)

    @cached_property
    def _by_channel(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Samples of each unit, 0 where there are none, and 1.0 where there are some, both (C, 1, N)."""
        each = [m.T[:, None] for m in self.measured]
        return [(np.nan_to_num(m), np.isfinite(m).astype(float)) for m in each]

    def _shown(self, lane: _Run, states: np.ndarray, dt: float) -> np.ndarray:
        """What the instruments of a lane show of states (C, B, M)."""
        own, place = lane.numbers.instruments, {s: c for c, s in enumerate(self.symbols)}
        if "point_ahead" in own:
            states[place["v"]] += own["point_ahead"] * states[place["r"]]
        for symbol, c in place.items():
            if f"{SENSOR[symbol]}_delay" in own:
                states[c] = _later(states[c], own[f"{SENSOR[symbol]}_delay"] / dt)
        if "axis_misalignment" in own:
            states[place["u"]], states[place["v"]] = _turned(
                states[place["u"]], states[place["v"]], own["axis_misalignment"]
            )
        for symbol, c in place.items():
            states[c] = bent(states[c], *_gain(own, SENSOR[symbol])) + own.get(f"{SENSOR[symbol]}_bias", 0.0)
        unit = self.units[lane.unit]
        for c, first, slope in self._drifts(lane):
            states[c] += first + slope * (unit.grid_s[: states.shape[2]] - unit.record.time_s[0])
        return states


def _equally_long(inputs: Sequence[np.ndarray]) -> np.ndarray:
    """Inputs (B, M, nu) of lanes (M_b, nu_b), zero where one has fewer, and the last one where it is shorter."""
    each = {id(u): u for u in inputs}
    longest, width = max(len(u) for u in each.values()), max(u.shape[1] for u in each.values())
    block = np.zeros((len(each), longest, width))
    for row, u in zip(block, each.values(), strict=True):
        row[: len(u), : u.shape[1]], row[len(u) :, : u.shape[1]] = u, u[-1]
    place = {key: i for i, key in enumerate(each)}
    return block[[place[id(u)] for u in inputs]]


def _gain(instruments: Mapping[str, float], short: str) -> tuple[float, float]:
    """Gain of a sensor, and its growth with the channel."""
    return 1.0 + instruments.get(f"{short}_scale", 0.0), instruments.get(f"{short}_curve", 0.0)


def _turned(u: np.ndarray, v: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocities in axes at an angle."""
    return u * np.cos(angle) + v * np.sin(angle), v * np.cos(angle) - u * np.sin(angle)


def _later(values: np.ndarray, points: float) -> np.ndarray:
    """Values (..., M) of so many points before, between the points by straight lines; the first or last one beyond."""
    last = values.shape[-1] - 1
    at = np.clip(np.arange(last + 1) - points, 0.0, last)
    low = np.minimum(at.astype(int), max(last - 1, 0))
    share = at - low
    return values[..., low] * (1.0 - share) + values[..., np.minimum(low + 1, last)] * share
