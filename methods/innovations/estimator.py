"""Records and a model under the innovations filter: likelihood, derivatives, noise fit and parameter refits.

A `Setting` says everything the filter is run at: one parameter vector a record, the noise, and forces or sensor
shifts added as time series.  `Estimator` holds the records and evaluates settings; nothing in it changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.instruments import quietened, rudder_noise
from ...models import kernels as kernel_store
from ...models.extend import NEUTRAL
from ..base import CannotFit
from ..series import bridged, initial_state_of, inputs_of, samples, sensor_sd
from .layout import BETWEEN, CHANNELS, OMEGA, OUTER, RMS, ZETA

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

SYMBOLS = ("psi", "r", "u", "v", "x", "y")
QUANTUM = 1e-5
"""Force that the noise fit counts in, as a share of the force unit."""
SHORTEST_TAU_S, START_TAU_S, LONGEST_TAU_S = 1.0, 15.0, 60.0
"""Correlation times of gusts on a 160 m ship; times of smaller ones scale by `Estimator.clock`."""
DAMPINGS = (0.0, 0.1, 1.0, 10.0, 1e9)
"""Shares of the Fisher information added to its diagonal in turn until a step of the noise gains (forces of response
models are nearly collinear); at the last only the sensors move."""
CUT = 2e-3
"""Change of an innovation, in standard deviations, that a coarser step of the model's integration may make."""
SPIKE, NEAR = 6.5, 4.5
LEAST = 3e-4
"""Share of a channel's own spread that its noise is taken to have at least in the search for spikes: corners of what
no noise is on are none."""
SPIKE_ROUNDS, REACH, OFTEN, GROWTH = 12, 5, 0.01, 2.0
"""Rounds of the search for spikes, samples that a neighbour may be away, the share of spikes from which on two may
stand side by side, and how many times those of the first round may become: more are the corners of a motion."""
FLOOR = (3e-4, 3e-4, 3e-4, 3e-4, 1e-5, 1e-5)
CLIP = 4.5
"""Innovation beyond which a score counts no more (sensor outliers)."""
DEFAULT_WINDAGE = {
    **{"rho_air": 1.225, "A_F": 450.0 / 160.93**2, "A_L": 1800.0 / 160.93**2},
    **{"wind_cx": 0.7, "wind_cy": 0.8, "wind_cn": 0.1, "wind_kn": 0.0, "wind_delta": 0.0},
}
"""Wind coefficients where a vessel file has none (those declared for Mariner; areas as shares of L^2)."""


@dataclass(frozen=True)
class Data:
    """One record on the filter's channels: time (T,), recorded rudder (T,), other inputs (T, no), measured (T, 6)."""

    name: str
    time: np.ndarray
    rudder: np.ndarray
    other: np.ndarray
    measured: np.ndarray
    start: np.ndarray
    start_var: np.ndarray
    spikes: int
    near_spikes: int


@dataclass(frozen=True)
class Parameter:
    """One number that the filter's settings can move.

    slots : (index into the parameter vector, weight) pairs; a value v adds v * weight to each.
    record : the record it belongs to, None for all.
    series : instead of slots, an added force or sensor shift: axis and one array (T,) a record.
    low, high : bounds.
    scale : a small change, where derivatives start looking for their step.
    """

    name: str
    unit: str
    slots: tuple[tuple[int, float], ...] = ()
    record: int | None = None
    low: float = -np.inf
    high: float = np.inf
    scale: float = 1e-3
    series: tuple[int, tuple[np.ndarray, ...]] | None = field(default=None, compare=False)
    law: Callable[[float], np.ndarray] | None = field(default=None, compare=False)
    """Weight of each slot at a value (instead of weight times value), zero at zero."""


@dataclass(frozen=True)
class Setting:
    """Parameter vectors (R, NP), noise (6 + nf + 1,) and added series (R arrays (T, nf + 6), or none)."""

    p: np.ndarray
    noise: np.ndarray
    added: tuple[np.ndarray, ...] | None = None
    amounts: Mapping[str, float] = field(default_factory=dict)


class Innovations(NamedTuple):
    """Whitened innovations and log S / 2, (N, 6) over all records in turn; filtered states (N, nx)."""

    e: np.ndarray
    log_s: np.ndarray
    states: np.ndarray

    @property
    def log_likelihood(self) -> float:
        with np.errstate(over="ignore"):  # a diverged run counts as impossible
            value = -np.sum(self.log_s) - 0.5 * np.sum(self.e**2)
        return float(value) if np.isfinite(value) else -1e300

    def change(self, other: Innovations) -> np.ndarray:
        """Change (N, 6) to other innovations at another setting (mean part: de + e dlog S)."""
        return (other.e - self.e) + self.e * (other.log_s - self.log_s)


class Run(NamedTuple):
    """One record through the filter: whitened innovations and log S / 2 (T, 6), states (T, nx), predicted (T, 6)."""

    e: np.ndarray
    log_s: np.ndarray
    states: np.ndarray
    predicted: np.ndarray


class Trace(NamedTuple):
    """What derivatives need of a run (see `_filter.run_filter`); without rows nothing is written down."""

    transition: np.ndarray
    slopes: np.ndarray
    gains: np.ndarray
    roots: np.ndarray
    spreads: np.ndarray
    pushes: np.ndarray

    @classmethod
    def empty(cls, size: int, n: int, nx: int, nf: int, m: int) -> Trace:
        """For T samples, n states of the model, nx of the filter, nf forces and m varied entries."""
        of_states = ((size, nx, nx), (size, CHANNELS, nx), (size, CHANNELS, nx), (size, CHANNELS), (size, nf, nx))
        return cls(*map(np.zeros, (*of_states, (m, size, n))))


class Estimator:
    """The records of one diagnosis, ready for the filter.

    Parameters
    ----------
    model : with coefficients.
    records : SI records; each needs a rudder and heading or yaw rate.

    Raises
    ------
    CannotFit : if a record lacks what the model needs.
    """

    def __init__(self, model: Model, records: Sequence[Record], unit: np.ndarray | None = None) -> None:
        self.model = model
        self.kernels = kernel_store.load(model.family + kernel_store.BANK)
        self.data = [_data(record, model, self.kernels) for record in records]
        self.edges = np.concatenate([[0], np.cumsum([d.time.size for d in self.data])])
        self.names = [*self.kernels.COEFFICIENTS, *self.kernels.CONSTANTS, *OUTER]
        self.index = {name: i for i, name in enumerate(self.names)}
        quiet = [rudder_noise(d.rudder) for d in self.data]
        self.rudder_sd = max(min(quiet), 1e-7)
        self.between = BETWEEN
        self.unit = force_units(model, self.data) if unit is None else unit
        self.base = base_vector(model, self.kernels)
        if "speed_loss_state" in self.kernels.STATES:
            self._read_speed()
        self.commanded = all(not r.has("rudder_rad") for r in records)
        self.free_s: float | None = None
        self._pool = ThreadPoolExecutor(2)
        self._steps: dict = {}
        self._without_noise: dict[tuple[int, float], np.ndarray] = {}

    def _read_speed(self) -> None:
        """The surge channel of a response model: U0 (1 - loss), U0 from the first part of the records."""
        firsts = [d.measured[: max(5, d.time.size // 50), 2] for d in self.data]
        firsts = [x[np.isfinite(x)] for x in firsts]
        speed = float(np.median(np.concatenate(firsts))) if any(x.size for x in firsts) else 1.0
        self.base[self.index["scale_u"]], self.base[self.index["bias_u"]] = -speed - 1.0, speed

    @cached_property
    def layout(self) -> np.ndarray:
        """What the kernel needs to know about the model."""
        return self._laid_out(self._substeps())

    def _laid_out(self, steps: int) -> np.ndarray:
        states, inputs = self.kernels.STATES, list(self.kernels.INPUTS)
        first = inputs.index("force_x" if "force_x" in inputs else "force")
        env = inputs.index("current_north") if "current_north" in inputs else -1
        size = len(self.names) - len(OUTER)
        seen = [state_seen(s, states) for s in SYMBOLS]
        places = [-1 if s is None else states.index(s) for s in seen]
        idle = [not used and symbol in ("x", "y") for used, symbol in zip(self.channels, SYMBOLS, strict=True)]
        places = [-2 - i if i >= 0 and out else i for i, out in zip(places, idle, strict=True)]
        return np.array([len(states), size, len(inputs), first, env, steps, *places], dtype=np.int64)

    def _substeps(self) -> int:
        """RK4 steps a sample is cut into: twice as many until the base model's innovations hardly change."""
        dt = float(np.median(np.diff(self.data[0].time)))
        most = int(np.ceil(dt / (4.0 * self.model.max_step_s) - 1e-9))
        if most <= 1:
            return 1
        steps, coarse = 1, self._cut_into(1)
        while steps < most:
            fine = self._cut_into(2 * steps)
            if np.all(np.abs(fine - coarse) < CUT * (1.0 + np.abs(fine))):
                return steps
            coarse, steps = fine, 2 * steps
        return most

    def _cut_into(self, steps: int) -> np.ndarray:
        """Innovations of the base model with so many steps a sample."""
        other = copy(self)
        other.__dict__["layout"] = self._laid_out(steps)
        return np.concatenate([other._run(other.start(), i).e for i in range(len(self.data))])

    @cached_property
    def floors(self) -> np.ndarray:
        """(6,) smallest sensor sd that is believed: FLOOR of each channel's own spread (interpolated records are
        smoother than any sensor, and no model is better than that); that of headings ends at the whole compass."""
        out = np.full(CHANNELS, 1e-9)
        for c in np.flatnonzero(self.channels):
            spread = max(float(np.nanstd(d.measured[:, c])) for d in self.data if np.isfinite(d.measured[:, c]).any())
            out[c] = max(FLOOR[c] * min(spread, np.pi / np.sqrt(3.0) if c == 0 else np.inf), 1e-9)
        return out

    @cached_property
    def channels(self) -> np.ndarray:
        """(6,) whether any record measures the channel and the model has the state."""
        known = np.array([state_seen(s, self.kernels.STATES) is not None for s in SYMBOLS])
        return known & np.any([np.isfinite(d.measured).any(axis=0) for d in self.data], axis=0)

    def first(self, share: float) -> Estimator:
        """The same with only the first part of every record."""
        early = copy(self)
        cut = [max(8, int(share * d.time.size)) for d in self.data]
        series = ("time", "rudder", "other", "measured")
        early.data = [replace(d, **{n: getattr(d, n)[:k] for n in series}) for d, k in zip(self.data, cut, strict=True)]
        early.edges = np.concatenate([[0], np.cumsum(cut)])
        early._steps = {}
        return early

    def apart(self) -> Estimator:
        """The same with its own memory of the parameters' steps: what runs beside others does not depend on them."""
        own = copy(self)
        own._steps = dict(self._steps)
        return own

    def with_corners(self, share: float) -> Estimator:
        """The same, with another share of the rudder's second difference in doubt at its corners (0: none)."""
        other = copy(self)
        other.between, other._steps = share, {}
        return other

    def simulating(self, seconds: float) -> Estimator:
        """The same, but run freely after the first seconds: innovations are then output errors over sensor noise."""
        free = copy(self)
        free.free_s, free._steps = seconds, {}
        return free

    @property
    def clock(self) -> float:
        """Time scale against a 160 m ship: sqrt(L/160 m), or the records' duration over 600 s (at most 1)."""
        length = self.model.particulars.get("L")
        if length is not None:
            return float(np.sqrt(length / 160.0))
        return float(min(np.median([d.time[-1] for d in self.data]) / 600.0, 1.0))

    @property
    def n_forces(self) -> int:
        return self.unit.size

    @property
    def n_values(self) -> int:
        """Measured values that the filter uses."""
        return int(sum(np.isfinite(d.measured[:, self.channels]).sum() for d in self.data))

    def start(self) -> Setting:
        """The base model with sensor noise read off the records and no process noise."""
        sd = np.zeros(CHANNELS)
        for c in range(CHANNELS):
            found = [sensor_sd(d.measured[:, c]) for d in self.data if np.isfinite(d.measured[:, c]).any()]
            sd[c] = max(float(np.median(found)), self.floors[c]) if found else 1.0
        noise = np.concatenate([sd, np.zeros(self.n_forces), [START_TAU_S * self.clock]])
        return Setting(np.tile(self.base, (len(self.data), 1)), noise)

    # ---- running the filter
    def evaluate(self, s: Setting, records: Sequence[int] | None = None) -> Innovations:
        """Innovations at a setting, of all records or some (then in their order)."""
        chosen = range(len(self.data)) if records is None else records
        return self._joined(self._pool.map(lambda i: self._run(s, i), chosen))

    def _joined(self, runs: Iterable[Run]) -> Innovations:
        """Innovations of several records in turn, without the states of waves."""
        parts, n = list(runs), len(self.kernels.STATES) + self.n_forces
        e, log_s = (np.concatenate([getattr(part, name) for part in parts]) for name in ("e", "log_s"))
        return Innovations(e, log_s, np.concatenate([part.states[:, :n] for part in parts]))

    def _run(self, s: Setting, i: int, free: int | None = None) -> Run:
        """Record i through the filter, freely from sample `free` on."""
        return self._filter(s, i, free, Trace.empty(0, 0, 0, 0, 0), ())

    def _traced(self, s: Setting, i: int, varied: Sequence[int] = ()) -> tuple[Run, Trace]:
        """Record i through the filter with all that derivatives need of the run."""
        trace = Trace.empty(
            self.data[i].time.size, len(self.kernels.STATES), self._size(s, i), self.n_forces, len(varied)
        )
        return self._filter(s, i, None, trace, varied), trace

    def _size(self, s: Setting, i: int) -> int:
        """States of the filter: the model's, the forces, and those of waves."""
        waves = s.p[i, len(self.names) - len(OUTER) + RMS] > 0.0
        return len(self.kernels.STATES) + self.n_forces + (2 if waves else 0)

    def _filter(self, s: Setting, i: int, free: int | None, trace: Trace, varied: Sequence[int]) -> Run:
        from ._filter import run_filter  # numba

        d = self.data[i]
        size, nf, which = d.time.size, self.n_forces, np.array(varied, np.int64)
        run = Run(*(np.empty((size, m)) for m in (CHANNELS, CHANNELS, self._size(s, i), CHANNELS)))
        added = np.zeros((size, nf + CHANNELS)) if s.added is None else s.added[i]
        model = (self.kernels.rhs, self.kernels.jacobian)
        p = np.ascontiguousarray(s.p[i])
        play = p[self.index["rudder_play"]] > 0.0
        record = (d.time, d.rudder, self._quiet(i) if play else d.rudder, d.other, d.measured)
        error = np.array([self.rudder_sd, self.between])
        fixed = (p, self.layout, self.unit, s.noise, error, added, d.start, d.start_var)
        if free is None and self.free_s is not None:
            free = int(np.searchsorted(d.time, min(self.free_s, 0.2 * d.time[-1]))) + 2
        run_filter(*model, *record, *fixed, size if free is None else free, which, probes(s.p[i, which]), *run, *trace)
        return run

    def _quiet(self, i: int) -> np.ndarray:
        """The rudder (T,) of record i without its sensor's noise."""
        key = i, self.rudder_sd
        if key not in self._without_noise:
            self._without_noise[key] = quietened(self.data[i].rudder, self.rudder_sd)
        return self._without_noise[key]

    def many(
        self, settings: Sequence[Setting], records: Sequence[Sequence[int] | None] | None = None
    ) -> list[Innovations]:
        """Innovations at several settings; records: for each, those that are run (None: all)."""
        which = [None] * len(settings) if records is None else records
        everyone = range(len(self.data))
        jobs = [
            (s, i) for s, chosen in zip(settings, which, strict=True) for i in (everyone if chosen is None else chosen)
        ]
        runs = self._pool.map(lambda job: self._run(*job), jobs)
        return [self._joined([next(runs) for _ in (everyone if chosen is None else chosen)]) for chosen in which]

    def free_run(self, s: Setting, i: int, free: int) -> np.ndarray:
        """Predicted channels (T, 6) of record i: filtered up to sample `free`, simulated from there."""
        return self._run(s, i, free).predicted

    def traces(self, s: Setting) -> list[Trace]:
        """Every record through the filter, written down for `responses`."""
        return list(self._pool.map(lambda i: self._traced(s, i)[1], range(len(self.data))))

    def responses(
        self, traces: Sequence[Trace], axes: Sequence[int], forcing: Sequence[Sequence[np.ndarray]]
    ) -> np.ndarray:
        """Derivatives (m, N*6) of the whitened innovations by the size of added series; forcing[j][i] is (T,)."""
        out = np.zeros((len(axes), self.edges[-1] * CHANNELS))
        for i, trace in enumerate(traces):
            self._carry(
                trace, i, np.array(axes, np.int64), np.ascontiguousarray(np.stack([f[i] for f in forcing])), out
            )
        return out

    def tangent(self, s: Setting, indices: Sequence[int]) -> np.ndarray:
        """Derivatives (m, N*6) of the whitened innovations by entries of the model's vector, in one pass.

        With the filter's gains held: what is left out has mean zero, so that the estimating equations D e = 0 keep
        their root.
        """
        axes = np.arange(len(indices)) + self.n_forces + CHANNELS
        out = np.zeros((axes.size, self.edges[-1] * CHANNELS))

        def along(i: int) -> None:
            self._carry(self._traced(s, i, indices)[1], i, axes, np.ones((axes.size, self.data[i].time.size)), out)

        list(self._pool.map(along, range(len(self.data))))
        return out

    def _carry(self, trace: Trace, i: int, axes: np.ndarray, forcing: np.ndarray, out: np.ndarray) -> None:
        from ._linear import carry  # numba

        run = (trace.transition, trace.slopes, trace.gains, trace.roots)
        carry(*run, len(self.kernels.STATES), self.n_forces, axes, forcing, trace.pushes, self.edges[i], out)

    def scores(self, s: Setting, now: Innovations, parameters: Sequence[Parameter]) -> np.ndarray:
        """As `column`, but what moves only entries of the model's vector comes out of one pass (`tangent`)."""
        size = len(self.names) - len(OUTER)
        inner = [
            p.series is None and p.law is None and p.record is None and all(i < size for i, _ in p.slots)
            for p in parameters
        ]
        out = np.zeros((len(parameters), now.e.size))
        outer = [p for p, inside in zip(parameters, inner, strict=True) if not inside]
        out[np.flatnonzero(~np.array(inner, bool))] = self.column(s, now, outer)
        used = sorted({i for p, inside in zip(parameters, inner, strict=True) if inside for i, _ in p.slots})
        if used:
            rows = dict(zip(used, self.tangent(s, used), strict=True))
            for j in np.flatnonzero(inner).tolist():
                for i, weight in parameters[j].slots:
                    out[j] += weight * rows[i]
        out[~np.isfinite(out).all(axis=1)] = 0.0
        return out

    # ---- parameters
    def moved(self, s: Setting, parameter: Parameter, change: float) -> Setting:
        """The setting with `change` added to a parameter."""
        if parameter.series is not None:
            axis, arrays = parameter.series
            old = s.added or tuple(np.zeros((d.time.size, self.n_forces + CHANNELS)) for d in self.data)
            new = [a.copy() for a in old]
            for a, series in zip(new, arrays, strict=True):
                a[:, axis] += change * series
            amounts = {**s.amounts, parameter.name: s.amounts.get(parameter.name, 0.0) + change}
            return replace(s, added=tuple(new), amounts=amounts)
        p = s.p.copy()
        rows = slice(None) if parameter.record is None else parameter.record
        if parameter.law is not None:
            old = s.amounts.get(parameter.name, 0.0)
            step = np.asarray(parameter.law(old + change)) - np.asarray(parameter.law(old))
            p[:, [index for index, _ in parameter.slots]] += step * [weight for _, weight in parameter.slots]
            return replace(s, p=p, amounts={**s.amounts, parameter.name: old + change})
        for index, weight in parameter.slots:
            p[rows, index] += change * weight
        return replace(s, p=p)

    def value(self, s: Setting, parameter: Parameter) -> float:
        """The parameter's present value (0 where the effect is absent)."""
        if parameter.series is not None or parameter.law is not None:
            return s.amounts.get(parameter.name, 0.0)
        index, weight = parameter.slots[0]
        row = 0 if parameter.record is None else parameter.record
        return float((s.p[row, index] - self.base[index]) / weight)

    def at(self, s: Setting, parameter: Parameter, value: float) -> Setting:
        """The setting with a parameter at a value, inside its bounds."""
        return self.moved(s, parameter, float(np.clip(value, parameter.low, parameter.high)) - self.value(s, parameter))

    def column(self, s: Setting, now: Innovations, parameters: Sequence[Parameter]) -> np.ndarray:
        """Derivatives (m, N*6) of the whitened innovations by parameters (mean part: de + e dlog S)."""
        steps = [self._steps.get(_key(p), p.scale) for p in parameters]
        first = self._columns(s, now, parameters, steps)
        size = np.linalg.norm(first, axis=1) * steps
        odd = [j for j in range(len(parameters)) if np.isfinite(size[j]) and size[j] > 0 and not 1e-6 < size[j] < 5.0]
        if odd:
            for j in odd:
                steps[j] = steps[j] * 0.1 / max(size[j], 1e-9)
            first[odd] = self._columns(s, now, [parameters[j] for j in odd], [steps[j] for j in odd])
        for p, step in zip(parameters, steps, strict=True):
            self._steps[_key(p)] = step
        first[~np.isfinite(first).all(axis=1)] = 0.0
        return first

    def _columns(
        self, s: Setting, now: Innovations, parameters: Sequence[Parameter], steps: Sequence[float]
    ) -> np.ndarray:
        signs = [-1.0 if self.value(s, p) + h > p.high else 1.0 for p, h in zip(parameters, steps, strict=True)]
        settings = [self.moved(s, p, g * h) for p, h, g in zip(parameters, steps, signs, strict=True)]
        which = [None if p.record is None else [p.record] for p in parameters]
        out = np.zeros((len(parameters), now.e.size))
        for row, p, h, g, found in zip(out, parameters, steps, signs, self.many(settings, which), strict=True):
            part = slice(None) if p.record is None else slice(self.edges[p.record], self.edges[p.record + 1])
            own = Innovations(now.e[part], now.log_s[part], now.states[part])
            row.reshape(-1, CHANNELS)[part] = own.change(found) / (g * h)
        return out

    # ---- noise
    def fit_noise(self, s: Setting, most: int = 8, tolerance: float = 0.05) -> tuple[Setting, Innovations]:
        """Noise of largest likelihood: sensor sds, force sds (>= 0) and their correlation time, by Fisher scoring."""
        now, followed = self._followed(s)
        for left in reversed(range(most)):
            if now.log_likelihood <= -1e299:
                break
            gain, s, now, followed = self._noise_step(s, now, followed, left == 0)
            if gain < tolerance:
                break
        return s, now

    def _followed(self, s: Setting) -> tuple[Innovations, list[tuple[Run, Trace]]]:
        """Innovations at a setting, and every record's run with what derivatives need of it."""
        followed = list(self._pool.map(lambda i: self._traced(s, i), range(len(self.data))))
        return self._joined(run for run, _ in followed), followed

    def _noise_step(
        self, s: Setting, now: Innovations, followed: list[tuple[Run, Trace]], last: bool
    ) -> tuple[float, Setting, Innovations, list[tuple[Run, Trace]]]:
        """Gain of one step, and where it leads; the last one need not be followed."""
        nf, noise = self.n_forces, s.noise
        sensors = self._sensor_step(noise, now)
        q = (noise[6 : 6 + nf] / QUANTUM) ** 2
        gradient, fisher = self._force_scores(s, now, followed)
        for damping in DAMPINGS:
            change = _bounded_step(gradient, fisher + damping * np.diag(np.diag(fisher)), q)
            trial = noise.copy()
            trial[:CHANNELS] = sensors
            new = np.clip(q + change[:nf], 0.0, 30.0 * q + 100.0)
            trial[6 : 6 + nf] = QUANTUM * np.sqrt(np.where(new < 1e-6, 0.0, new))
            factor = np.exp(np.clip(change[nf], -0.7, 0.7))
            trial[6 + nf] = np.clip(noise[6 + nf] * factor, SHORTEST_TAU_S * self.clock, LONGEST_TAU_S * self.clock)
            there = replace(s, noise=trial)
            found, onward = (self.evaluate(there), followed) if last else self._followed(there)
            if found.log_likelihood > now.log_likelihood - 1e-6:
                return found.log_likelihood - now.log_likelihood, there, found, onward
        return 0.0, s, now, followed

    def _sensor_step(self, noise: np.ndarray, now: Innovations) -> np.ndarray:
        share = noise[:CHANNELS] ** 2 / np.exp(2.0 * now.log_s)
        used = now.e != 0.0
        excess = np.sum((np.clip(now.e, -CLIP, CLIP) ** 2 - 1.0) * share * used, axis=0)
        weight = np.maximum(np.sum(share**2 * used, axis=0), 1e-9)
        return np.maximum(noise[:CHANNELS] * np.exp(np.clip(0.5 * excess / weight, -0.4, 0.4)), self.floors)

    def _force_scores(
        self, s: Setting, now: Innovations, followed: Sequence[tuple[Run, Trace]]
    ) -> tuple[np.ndarray, np.ndarray]:
        nf = self.n_forces
        de, dl = self._by_noise(s, followed)
        gradient = -np.sum(dl + now.e.ravel() * de, axis=1)
        mean = de + now.e.ravel() * dl
        fisher = mean @ mean.T + 2.0 * dl @ dl.T
        fisher[nf, nf] += 1.0
        return gradient, fisher

    def _by_noise(self, s: Setting, followed: Sequence[tuple[Run, Trace]]) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives (nf + 1, N*6) of innovations and of log S / 2 by variances (QUANTUM^2) and log time of forces."""
        from ._linear import LANES, vary  # numba

        by_e, by_log_s = np.zeros((2, LANES, self.edges[-1] * CHANNELS))

        def along(i: int) -> None:
            run, t = followed[i]
            done = (t.transition, t.slopes, t.gains, t.roots, t.spreads, run.e, run.states)
            n, first = len(self.kernels.STATES), self.edges[i]
            vary(*done, self.data[i].time, s.noise, n, QUANTUM, first, by_e, by_log_s)

        list(self._pool.map(along, range(len(self.data))))
        return by_e[: self.n_forces + 1], by_log_s[: self.n_forces + 1]

    def settle(self, s: Setting, start: Setting) -> tuple[Setting, Innovations]:
        """The best noise of several starts: the present one, none, and faint gusts."""
        best = self.fit_noise(s, 12)
        for amount in (0.0, 4.0):
            noise = start.noise.copy()
            noise[6 : 6 + self.n_forces] = amount * QUANTUM * np.array([1.0, 2.0, 1.0])[: self.n_forces]
            if np.array_equal(noise, s.noise):
                continue
            found = self.fit_noise(replace(s, noise=noise), 12)
            if found[1].log_likelihood > best[1].log_likelihood + 1e-3:
                best = found
        return best

    # ---- parameters of largest likelihood
    def refit(
        self,
        s: Setting,
        parameters: Sequence[Parameter],
        most: int = 6,
        prior: np.ndarray | None = None,
        tolerance: float = 0.05,
    ) -> tuple[Setting, Innovations]:
        """Parameters and noise of largest likelihood near a setting: Gauss-Newton steps between noise steps."""
        s, now = self.fit_noise(s, 2)
        for iteration in range(most):
            before = now.log_likelihood
            if before <= -1e299:
                break
            s, now = self.gauss_newton(s, now, parameters, prior)
            s, now = self.fit_noise(s, 2 if iteration == most - 1 else 1)
            if now.log_likelihood - before < tolerance:
                break
        return s, now

    def gauss_newton(
        self, s: Setting, now: Innovations, parameters: Sequence[Parameter], prior: np.ndarray | None = None
    ):
        """One damped step of the parameters with the noise held."""
        if not parameters:
            return s, now
        d = self.column(s, now, parameters)
        fisher, gradient = d @ d.T, -d @ now.e.ravel()
        values = np.array([self.value(s, p) for p in parameters])
        if prior is not None:
            fisher = fisher + np.diag(prior)
            gradient = gradient - prior * values
        scale = np.sqrt(np.diag(fisher)) + 1e-30
        change = (
            np.linalg.lstsq(fisher / np.outer(scale, scale) + 1e-9 * np.eye(scale.size), gradient / scale, rcond=None)[
                0
            ]
            / scale
        )
        penalty = 0.0 if prior is None else 0.5 * np.sum(prior * values**2)
        for power in range(6):
            trial, moved = s, []
            for p, value, step in zip(parameters, values, change * 0.5**power, strict=True):
                trial = self.at(trial, p, value + step)
                moved.append(self.value(trial, p))
            found = self.evaluate(trial)
            cost = 0.0 if prior is None else 0.5 * np.sum(prior * np.array(moved) ** 2)
            if found.log_likelihood - cost > now.log_likelihood - penalty:
                return trial, found
        return s, now


def probes(values: np.ndarray) -> np.ndarray:
    """Steps over which derivatives by entries of the model's vector are differenced."""
    return 1e-3 * np.where(values != 0.0, np.abs(values), 1.0)


def _key(p: Parameter) -> tuple:
    return (p.name, p.slots, p.record)


def _bounded_step(gradient: np.ndarray, fisher: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Scoring step of (variances, log tau) that keeps variances at zero which want to be negative."""
    nf = q.size
    active = [j for j in range(nf) if not (q[j] <= 0.0 and gradient[j] <= 0.0)]
    active += [nf] if q.max() > 1e-4 else []
    while active:
        step = np.zeros(nf + 1)
        block = fisher[np.ix_(active, active)]
        step[active] = np.linalg.solve(block + 1e-9 * np.trace(block) * np.eye(len(active)), gradient[active])
        blocked = [j for j in active if j < nf and q[j] <= 0.0 and step[j] < 0.0]
        if not blocked:
            return step
        active = [j for j in active if j not in blocked]
    return np.zeros(nf + 1)


def state_seen(symbol: str, states: Sequence[str]) -> str | None:
    """The state that a channel measures: its own, or for the surge of a response model the speed loss."""
    if symbol in states:
        return symbol
    return "speed_loss_state" if symbol == "u" and "speed_loss_state" in states else None


def base_vector(model: Model, kernels: kernel_store.Kernels) -> np.ndarray:
    """Parameter vector (NP,) of the base model with every effect absent."""
    length = model.particulars.get("L", 1.0)
    numbers = {name: 0.0 for name in kernels.CONSTANTS} | NEUTRAL | {"rho": 1025.0, "wind_L": length}
    numbers |= {k: v * length**2 if k.startswith("A_") else v for k, v in DEFAULT_WINDAGE.items()}
    numbers |= dict(model.windage or {}) | rigid_body(model)
    numbers |= {"rho": model.particulars["rho"]} if "rho" in model.particulars else {}
    numbers |= dict(zip(model.constant_names, model.constants, strict=True))
    outer = np.zeros(len(OUTER))
    outer[OMEGA], outer[ZETA] = 0.7, 0.1
    return np.concatenate([model.coefficients, [numbers[name] for name in kernels.CONSTANTS], outer])


def rigid_body(model: Model) -> dict[str, float]:
    """Mass [kg], m x_G [kg m] and yaw inertia [kg m2] of the hull; a radius of gyration of L/4 where none is known."""
    known = {**model.particulars, **dict(zip(model.constant_names, model.constants.tolist(), strict=True))}
    if not model.is_3dof or "nabla" not in known:
        return {}
    mass, length = known.get("rho", 1025.0) * known["nabla"], known["L"]
    centre, radius = known.get("x_G", 0.0), known.get("k_zz", 0.25 * length)
    prime = 0.5 * known.get("rho", 1025.0) * length**5
    inertia = known.get("I_zz", known["I_z"] * prime if "I_z" in known else mass * radius**2)
    return {"rigid_mass": mass, "rigid_moment": mass * centre, "rigid_inertia": inertia}


def force_units(model: Model, data: Sequence[Data]) -> np.ndarray:
    """Units (nf,) of the forces: rho L^2 U0^2 / 2 (times L), or a typical yaw acceleration for response models."""
    if model.is_3dof:
        length, rho = model.particulars.get("L", 1.0), model.particulars.get("rho", 1025.0)
        pressure = 0.5 * rho * length**2 * model.speed_m_s**2
        return np.array([pressure, pressure, pressure * length])
    slopes = []
    for d in data:
        rate = d.measured[:, 1] if np.isfinite(d.measured[:, 1]).any() else np.gradient(d.measured[:, 0], d.time)
        window = max(2, d.time.size // 100)
        rise = rate[window:] - rate[:-window]
        slopes.append(np.sqrt(np.nanmean((rise / (d.time[window:] - d.time[:-window])) ** 2)))
    typical = 6000.0 * max(float(np.median(slopes)), 1e-9)
    return np.array([typical] if "w" not in model.states else [typical / max(_fast_time(model), 1e-3), typical])


def _fast_time(model: Model) -> float:
    """A second-order response model's shorter time constant: forces on its highest derivative count against it."""
    a1 = model.coefficients[0]
    return 1.0 / max(abs(a1), 1e-6) if np.isfinite(a1) else 1.0


def _data(record: Record, model: Model, kernels: kernel_store.Kernels) -> Data:
    given = inputs_of(record, model)
    time = np.ascontiguousarray(record.time_s - record.time_s[0])
    rudder = given["delta"]
    if not np.isfinite(rudder).any():
        raise CannotFit(f"record {record.name} has no rudder samples")
    rudder = bridged(rudder, time)
    other = [bridged(given[name], time) for name in model.inputs[1:]]
    measured = np.full((time.size, CHANNELS), np.nan)
    spikes, near = 0, 0
    for c, symbol in enumerate(SYMBOLS):
        values = samples(record, symbol)
        if values is not None and state_seen(symbol, kernels.STATES) is not None:
            measured[:, c], found, close = without_spikes(values)
            spikes, near = spikes + found, near + close
    if not np.isfinite(measured[:, :2]).any():
        raise CannotFit(f"record {record.name} has neither heading nor yaw rate")
    start, spread = _start(record, model, kernels, rudder[0])
    inputs = np.column_stack([*other, np.zeros((time.size, 0))])
    rudder, inputs = np.ascontiguousarray(rudder), np.ascontiguousarray(inputs)
    return Data(record.name, time, rudder, inputs, measured, start, spread**2, spikes, near)


def _start(record: Record, model: Model, kernels: kernel_store.Kernels, rudder: float) -> tuple[np.ndarray, np.ndarray]:
    start, spread = initial_state_of(record, model)
    for i, name in enumerate(model.states):
        if name == "w" and kernels.RATE_GAIN is not None:
            start[i] -= model.coefficients[kernels.RATE_GAIN] * rudder
    extra = [rudder if name == "lead_state" else 0.0 for name in kernels.STATES[len(model.states) :]]
    return np.concatenate([start, extra]), np.concatenate([spread, np.zeros(len(extra))])


def without_spikes(values: np.ndarray) -> tuple[np.ndarray, int, int]:
    """Series (T,) with single-sample spikes as gaps, their number, and the number of samples that nearly are.

    A spike departs from the cubic through its two neighbours to each side by more than SPIKE robust standard deviations
    and, at first, more than they do, or it and the next one depart from the cubic through those beside both; with those
    found left out of the cubics all are judged anew, as spikes make what is between them look like one.  Near misses
    lie between NEAR and SPIKE (many of them: a heavy tail, not outliers).
    """
    spike, known = np.zeros(values.size, bool), np.isfinite(values)
    first = spike
    least = LEAST * float(np.std(values[known])) if known.any() else 0.0
    if values.size < 12 or known.sum() < 12:
        return values.copy(), 0, 0
    for _ in range(SPIKE_ROUNDS):
        good = known & ~spike
        departure = _departures(values, good)
        spread = max(1.4826 * float(np.median(departure[good])), least)
        peak = departure >= _largest_beside(np.where(spike, 0.0, departure))
        found = (departure > SPIKE * spread) & (spike | peak) & known & (spread > 0.0)
        if np.array_equal(found, spike) and spike.sum() > OFTEN * values.size:
            found = spike | _twins(values, good, SPIKE * spread)
        if np.array_equal(found, spike):
            break
        first = found if not spike.any() else first
        if found.sum() > GROWTH * first.sum() + 2:
            spike = first
            break
        spike = found
    near = peak & ~spike & (departure > NEAR * spread)
    return np.where(spike, np.nan, values), int(spike.sum()), int(near.sum())


def _twins(y: np.ndarray, good: np.ndarray, limit: float) -> np.ndarray:
    """(T,) good samples that, both of two in turn, are further than the limit from the cubic through those beside."""
    late = _departures(y, good, 1) > limit
    early = _departures(y[::-1], good[::-1], 1)[::-1] > limit
    pair = late[:-1] & early[1:] & good[:-1] & good[1:] & (limit > 0.0)
    return np.append(pair, False) | np.append(False, pair)


def _departures(y: np.ndarray, good: np.ndarray, skip: int = 0) -> np.ndarray:
    """Distances (T,) from the cubic through the two good neighbours to each side, in units of noise alike for all;
    0 where they are more than REACH samples away.  skip: so many samples after each are not used for it."""
    out, place = np.zeros(y.size), np.arange(y.size)
    own = np.flatnonzero(good)
    after = np.searchsorted(own, place + skip, side="right")
    before = np.searchsorted(own, place)
    inside = (before >= 2) & (after + 2 <= own.size)
    k = place[inside]
    nodes = np.stack([own[before[inside] - 2], own[before[inside] - 1], own[after[inside]], own[after[inside] + 1]])
    away = (nodes - k).astype(float)
    weights = np.ones_like(away)
    for i, j in permutations(range(4), 2):
        weights[i] *= away[j] / (away[j] - away[i])
    distance = np.abs(y[k] - np.sum(weights * y[nodes], axis=0)) / np.sqrt(1.0 + np.sum(weights**2, axis=0))
    out[k] = np.where(np.isfinite(distance) & (np.abs(away).max(axis=0) <= REACH), distance, 0.0)
    return out


def _largest_beside(x: np.ndarray) -> np.ndarray:
    """The larger (T,) of the two values beside each."""
    padded = np.concatenate([[0.0], x, [0.0]])
    return np.maximum(padded[:-2], padded[2:])
