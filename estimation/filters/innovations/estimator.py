"""Records and a model under the innovations filter: likelihood, free runs, and parameters that move the filter.

A `Setting` says everything that the filter is run at.  An `Estimator` holds the records and never changes; it
evaluates settings.  The latest runs of single segments are kept, found by the content of everything that a run depends
on beside the estimator itself: fits come back to what they have just left.  Derivatives are in `derivatives`, the fit
of the noise in `noise_fit`, that of parameters in `refit`.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from threading import Lock
from typing import TYPE_CHECKING, NamedTuple, TypeVar

import numpy as np

from ....datasets.record import Record
from ....datasets.signals import sensor_sd
from ....models import kernels as kernel_store
from ....models.model import Model
from ...numerics.threads import in_threads
from ...records.gaps import clock_of
from .segments import Segment, rudder_sd, segments_of
from .settings import Noise, Parameter, Setting
from .vector import CHANNELS, OUTER, PLACE, RMS, SYMBOLS, base_vector, names_of, state_of

if TYPE_CHECKING:
    from ._arguments import FilterRun, FilterSizes, Recorded, Trace, Values

    Made = tuple[FilterRun, Trace | None]

KEPT = 2
"""Runs of each segment that are kept."""


class Recent:
    """The latest runs, with their traces where these were asked for; shared by threads."""

    def __init__(self, most: int) -> None:
        self._made: OrderedDict[tuple, Made] = OrderedDict()
        self._most, self._lock = most, Lock()

    def get(self, key: tuple, traced: bool) -> Made | None:
        """The run of a key, None where it is not there, or not with a trace that is wanted."""
        with self._lock:
            found = self._made.get(key)
            if found is None or (traced and found[1] is None):
                return None
            self._made.move_to_end(key)
            return found

    def put(self, key: tuple, made: Made) -> None:
        """Keep a run, and let go of the one that was not asked for longest."""
        with self._lock:
            self._made[key] = made
            self._made.move_to_end(key)
            if len(self._made) > self._most:
                self._made.popitem(last=False)


def run_of(
    kernels: kernel_store.Kernels,
    shape: FilterSizes,
    places: np.ndarray,
    recorded: Recorded,
    values: Values,
    free: int,
    traced: bool,
) -> Made:
    """A segment through the filter, freely from sample `free` on, traced or not.

    places : the state of each channel, as `Estimator.places`.
    """
    from ._arguments import FilterRun, Trace
    from ._kernel import run_filter

    size, nf = recorded.time.size, shape.n_forces
    nx = shape.n + nf + (2 if values.vector[shape.n_theta + RMS] > 0.0 else 0)
    run = FilterRun(*(np.empty((size, m)) for m in (CHANNELS, CHANNELS, nx, CHANNELS)))
    rows = size if traced else 0
    trace = Trace(
        np.zeros((rows, nx, nx)), np.zeros((rows, CHANNELS, nx)), np.zeros((rows, CHANNELS, nx)),
        np.zeros((rows, CHANNELS)), np.zeros((rows, nf, nx)), np.zeros((rows, CHANNELS)),
    )  # fmt: skip
    run_filter(kernels.rhs, kernels.jacobian, shape, places, recorded, values, free, run, trace)
    return run, trace if traced else None


def content_of(s: Setting, segment: int, index: Mapping[str, int]) -> tuple:
    """What a run of a segment depends on, of a setting: the time of a rudder fault of no size is nothing to it.

    index : name -> entry of the parameter vector.
    """
    noise, vector = s.noise, s.vectors[segment]
    if vector[index["rudder_fault"]] == 0.0:
        vector = vector.copy()
        vector[index["rudder_fault_time"]] = 0.0
    added = None if s.added is None else s.added[segment].tobytes()
    numbers = (vector, noise.sensor_sd, noise.force_sd)
    return (*(part.tobytes() for part in numbers), noise.correlation_time_s, added)


T = TypeVar("T")
R = TypeVar("R")
START_TAU_S = 15.0
"""Correlation time of random forces on a 160 m ship that fits start from; smaller ships scale it by the clock."""
CORNER_ERROR = 0.12
"""Error of the mean rudder between two samples with a corner between them, as a share of the second difference, where
nothing is known of how the rudder moves there."""
COARSEST = 2e-3
"""Change of an innovation, in standard deviations, that a coarser step of the model's integration may make."""
FLOOR = (3e-4, 3e-4, 3e-4, 3e-4, 1e-5, 1e-5)
"""Smallest sensor sd that is believed, as a share of each channel's own spread."""
DIVERGED = -1e300
"""Log likelihood of a run that is not finite."""


class Innovations(NamedTuple):
    """Whitened innovations and log S / 2, (N, 6) over all segments in turn; filtered states (N, nx)."""

    e: np.ndarray
    log_s: np.ndarray
    states: np.ndarray

    @property
    def log_likelihood(self) -> float:
        """Log likelihood short of a constant; DIVERGED where it is not finite.

        Section 2 of docs/mathematics/diagnosis.md.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            value = -np.sum(self.log_s) - 0.5 * np.sum(self.e**2)
        return float(value) if np.isfinite(value) else DIVERGED

    @property
    def diverged(self) -> bool:
        """Whether the run is not finite."""
        return self.log_likelihood <= DIVERGED

    def change(self, other: Innovations) -> np.ndarray:
        """Change (N, 6) to other innovations at another setting (mean part: de + e dlog S)."""
        return (other.e - self.e) + self.e * (other.log_s - self.log_s)


@dataclass(frozen=True)
class Estimator:
    """The segments of all records, ready for the filter; made by `estimator`.

    unit : (nf,) units of the random forces, N and N m (response models: rad/s^2 and its like).
    rudder_sd : noise of the rudder's sensor, rad.  corner_error : see CORNER_ERROR (0: corners at samples only).
    clock : time scale against a 160 m ship.  terms : product terms that the vector holds beside the bank's.
    """

    model: Model
    kernels: kernel_store.Kernels
    segments: tuple[Segment, ...]
    unit: np.ndarray
    base: np.ndarray
    rudder_sd: float
    clock: float
    commanded: bool
    threads: int = 2
    terms: tuple[str, ...] = ()
    corner_error: float = CORNER_ERROR

    # ---- what there is
    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the entries of the parameter vector."""
        return names_of(self.kernels)

    @cached_property
    def index(self) -> dict[str, int]:
        """Name -> entry of the parameter vector."""
        return {name: i for i, name in enumerate(self.names)}

    @cached_property
    def edges(self) -> np.ndarray:
        """(S + 1,) first sample of each segment among all, and their number."""
        return np.concatenate([[0], np.cumsum([d.time.size for d in self.segments])])

    @property
    def n_records(self) -> int:
        return self.segments[-1].record + 1

    @cached_property
    def record_names(self) -> tuple[str, ...]:
        """Name of each record."""
        return tuple(dict((d.record, d.name) for d in self.segments)[i] for i in range(self.n_records))

    @property
    def n_forces(self) -> int:
        return self.unit.size

    @property
    def n_theta(self) -> int:
        """Entries of the vector that are the model's own."""
        return len(self.names) - len(OUTER)

    @cached_property
    def n_values(self) -> int:
        """Measured values that the filter uses."""
        return int(sum(np.isfinite(d.measured[:, self.channels]).sum() for d in self.segments))

    @cached_property
    def channels(self) -> np.ndarray:
        """(6,) whether any segment measures the channel and the model has the state."""
        known = np.array([state_of(s, self.kernels.STATES) is not None for s in SYMBOLS])
        return known & np.any([np.isfinite(d.measured).any(axis=0) for d in self.segments], axis=0)

    def rows(self, record: int | None) -> list[int]:
        """Segments of a record, or all of them."""
        return [i for i, d in enumerate(self.segments) if record is None or d.record == record]

    def samples_of(self, segment: int) -> slice:
        """Samples of a segment among all."""
        return slice(int(self.edges[segment]), int(self.edges[segment + 1]))

    @cached_property
    def owner(self) -> np.ndarray:
        """(N,) record that each sample belongs to."""
        return np.concatenate([np.full(d.time.size, d.record) for d in self.segments])

    def joined(self, of_segment: Callable[[Segment], np.ndarray]) -> np.ndarray:
        """A series (N, ...) of all samples, from one of each segment."""
        return np.concatenate([of_segment(d) for d in self.segments])

    @cached_property
    def floors(self) -> np.ndarray:
        """(6,) smallest sensor sd that is believed: FLOOR of each channel's own spread (interpolated records are
        smoother than any sensor, and no model is better than that); that of headings ends at the whole compass."""
        out = np.full(CHANNELS, 1e-9)
        for c in np.flatnonzero(self.channels):
            seen = [d.measured[:, c] for d in self.segments if np.isfinite(d.measured[:, c]).any()]
            spread = max(float(np.nanstd(y)) for y in seen)
            out[c] = max(FLOOR[c] * min(spread, np.pi / np.sqrt(3.0) if c == 0 else np.inf), 1e-9)
        return out

    # ---- variations
    def first(self, share: float) -> Estimator:
        """The same with only the first part of every segment."""
        return replace(self, segments=tuple(d.first(max(8, int(share * d.time.size))) for d in self.segments))

    def with_corners(self, share: float) -> Estimator:
        """The same, with another share of the rudder's second difference in doubt at its corners (0: none)."""
        return replace(self, corner_error=share)

    def with_channels(self, used: Sequence[bool]) -> Estimator:
        """The same with some of the six channels only."""
        kept = [replace(d, measured=np.where(used, d.measured, np.nan)) for d in self.segments]
        return replace(self, segments=tuple(kept))

    def start(self) -> Setting:
        """The base model with sensor noise read off the records and no random forces."""
        sd = np.ones(CHANNELS)
        for c in np.flatnonzero(self.channels):
            found = [sensor_sd(d.measured[:, c]) for d in self.segments if np.isfinite(d.measured[:, c]).any()]
            sd[c] = max(float(np.median(found)), self.floors[c])
        noise = Noise(sd, np.zeros(self.n_forces), START_TAU_S * self.clock)
        return Setting(np.tile(self.base, (len(self.segments), 1)), noise)

    # ---- running the filter
    def in_threads(self, work: Callable[[T], R], items: Iterable[T]) -> list[R]:
        """Results of work that mostly runs compiled code, in the order of the items."""
        return in_threads(self.threads, work, items)

    def evaluate(self, s: Setting, traced: bool = False) -> Innovations:
        """Innovations of all segments at a setting; traced where derivatives will probably be asked for there."""
        one = partial(self._filtered, s, free=None, traced=traced, keep=True)
        return self.gathered([run for run, _ in self.in_threads(one, range(len(self.segments)))])

    def many(
        self, settings: Sequence[Setting], segments: Sequence[Sequence[int] | None] | None = None
    ) -> list[Innovations]:
        """Innovations at several settings, to compare them; segments: for each, those that are run (None: all)."""
        every = range(len(self.segments))
        which = [every if chosen is None else chosen for chosen in segments or [None] * len(settings)]
        jobs = [(s, i) for s, chosen in zip(settings, which, strict=True) for i in chosen]
        runs = iter(self.in_threads(lambda job: self.run(*job), jobs))
        return [self.gathered([next(runs) for _ in chosen]) for chosen in which]

    def gathered(self, runs: Sequence[FilterRun]) -> Innovations:
        """Innovations of several segments in turn, without the states of waves."""
        n = len(self.kernels.STATES) + self.n_forces
        parts = [(run.e, run.log_s, run.states[:, :n]) for run in runs]
        if len(parts) == 1:
            return Innovations(*parts[0])
        return Innovations(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def run(self, s: Setting, segment: int, free: int | None = None) -> FilterRun:
        """One segment through the filter, freely from sample `free` on."""
        return self._filtered(s, segment, free, traced=False, keep=False)[0]

    def traced(self, s: Setting, segment: int) -> tuple[FilterRun, Trace]:
        """One segment through the filter, with all that derivatives need of the run."""
        run, trace = self._filtered(s, segment, None, traced=True, keep=True)
        assert trace is not None
        return run, trace

    def _filtered(self, s: Setting, segment: int, free: int | None, traced: bool, keep: bool) -> Made:
        """One segment through the filter, freely from sample `free` on (None: nowhere), traced or not,
        and kept or not.

        The arrays are shared: they are not written to.
        """
        free = self.segments[segment].time.size if free is None else free
        key = (segment, free, *content_of(s, segment, self.index))
        found = self.recent.get(key, traced)
        if found is None:
            recorded, values = self.arguments(s, segment)
            found = run_of(self.kernels, self.shape, self.places, recorded, values, free, traced)
            if keep:
                self.recent.put(key, found)
        return found

    def arguments(self, s: Setting, segment: int) -> tuple[Recorded, Values]:
        """What the filter's kernel takes of a segment and of a setting."""
        from ._arguments import Recorded, Values  # numba

        d, noise, vector = self.segments[segment], s.noise, s.vectors[segment].copy()
        vector[self.index["rudder_fault_time"]] -= d.offset_s
        added = np.zeros((d.time.size, self.n_forces + CHANNELS)) if s.added is None else s.added[segment]
        error, tau = np.array([self.rudder_sd, self.corner_error]), np.array([noise.correlation_time_s])
        recorded = Recorded(d.time, d.rudder, d.quiet, d.other, d.environment, d.measured, d.start, d.variance)
        return recorded, Values(vector, self.unit, noise.sensor_sd, noise.force_sd, tau, added, error)

    def free_run(self, s: Setting, segment: int, free: int) -> np.ndarray:
        """Predicted channels (T, 6) of a segment: filtered up to sample `free`, simulated from there without random
        forces."""
        return self.run(s, segment, free).predicted

    @cached_property
    def recent(self) -> Recent:
        """The latest runs that fits may come back to."""
        return Recent(KEPT * len(self.segments))

    @cached_property
    def places(self) -> np.ndarray:
        """(6,) the state of each channel: -1 without one, -2 - state for a position that nothing measures."""
        states = self.kernels.STATES
        seen = [state_of(symbol, states) for symbol in SYMBOLS]
        places = [-1 if name is None else states.index(name) for name in seen]
        idle = [not used and symbol in ("x", "y") for used, symbol in zip(self.channels, SYMBOLS, strict=True)]
        return np.array([-2 - i if i >= 0 and out else i for i, out in zip(places, idle, strict=True)], np.int64)

    @cached_property
    def shape(self) -> FilterSizes:
        """Sizes that the kernel needs."""
        return self._shape(_substeps(self))

    def _shape(self, substeps: int) -> FilterSizes:
        from ._arguments import FilterSizes

        inputs = list(self.kernels.INPUTS)
        first = inputs.index("force_x" if "force_x" in inputs else "force")
        current = inputs.index("current_north") if "current_north" in inputs else -1
        return FilterSizes(len(self.kernels.STATES), self.n_theta, len(inputs), first, current, substeps, self.n_forces)

    # ---- parameters
    def moved(self, s: Setting, parameter: Parameter, change: float) -> Setting:
        """The setting with `change` added to a parameter."""
        if parameter.series is not None:
            axis, arrays = parameter.series
            old = s.added or tuple(np.zeros((d.time.size, self.n_forces + CHANNELS)) for d in self.segments)
            new = [a.copy() for a in old]
            for a, series in zip(new, arrays, strict=True):
                a[:, axis] += change * series
            amounts = {**s.amounts, parameter.name: s.amounts.get(parameter.name, 0.0) + change}
            return replace(s, added=tuple(new), amounts=amounts)
        vectors, rows = s.vectors.copy(), self.rows(parameter.record)
        if parameter.law is not None:
            old = s.amounts.get(parameter.name, 0.0)
            step = np.asarray(parameter.law(old + change)) - np.asarray(parameter.law(old))
            for (entry, weight), part in zip(parameter.slots, step.tolist(), strict=True):
                vectors[rows, entry] += part * weight
            return replace(s, vectors=vectors, amounts={**s.amounts, parameter.name: old + change})
        for entry, weight in parameter.slots:
            vectors[rows, entry] += change * weight
        return replace(s, vectors=vectors)

    def value(self, s: Setting, parameter: Parameter) -> float:
        """The parameter's present value (0 where the effect is absent)."""
        if parameter.series is not None or parameter.law is not None:
            return s.amounts.get(parameter.name, 0.0)
        entry, weight = parameter.slots[0]
        return float((s.vectors[self.rows(parameter.record)[0], entry] - self.base[entry]) / weight)

    def at(self, s: Setting, parameter: Parameter, value: float) -> Setting:
        """The setting with a parameter at a value, inside its bounds."""
        return self.moved(s, parameter, float(np.clip(value, parameter.low, parameter.high)) - self.value(s, parameter))

    def with_entries(self, s: Setting, values: dict[str, float], record: int | None = None) -> Setting:
        """The setting with entries of the vector at values, in all records or one."""
        vectors = s.vectors.copy()
        for name, value in values.items():
            vectors[self.rows(record), self.index[name]] = value
        return replace(s, vectors=vectors)


def estimator(
    model: Model,
    records: Sequence[Record],
    unit: np.ndarray | None = None,
    threads: int = 2,
    terms: Sequence[str] = (),
) -> Estimator:
    """The records under the filter of a model with coefficients.

    unit : (nf,) units of the random forces; None: see `force_units`.
    terms : product terms (`models.families.extensions`) that the vector holds beside those of the bank.

    Raises
    ------
    CannotFit : if a record lacks what the model needs.
    """
    kernels = kernel_store.load("~".join([model.family + kernel_store.BANK, *terms]))
    clock = clock_of(model, records)
    segments = segments_of(records, model, kernels, clock)
    base = base_vector(model, kernels)
    if "speed_loss_state" in kernels.STATES:
        base[len(base) - len(OUTER) + PLACE["reference_speed"]] = _first_speed(segments)
    return Estimator(
        model=model,
        kernels=kernels,
        segments=segments,
        unit=force_units(model, segments) if unit is None else unit,
        base=base,
        rudder_sd=rudder_sd(segments),
        clock=clock,
        commanded=all(not r.has("rudder_rad") for r in records),
        threads=threads,
        terms=tuple(terms),
    )


def probes(values: np.ndarray) -> np.ndarray:
    """Steps over which derivatives by entries of the vector are differenced."""
    return 1e-3 * np.where(values != 0.0, np.abs(values), 1.0)


def _first_speed(segments: Sequence[Segment]) -> float:
    """Speed (m/s) in the first part of the records; 1 where none is measured."""
    found = np.concatenate([d.measured[: max(5, d.time.size // 50), 2] for d in segments])
    found = found[np.isfinite(found)]
    return float(np.median(found)) if found.size else 1.0


def _substeps(est: Estimator) -> int:
    """RK4 steps a sample is cut into: twice as many until the base model's innovations hardly change."""
    dt = est.segments[0].step_s
    most = int(np.ceil(dt / est.model.max_step_s - 1e-9))
    if most <= 1:
        return 1

    def innovations(steps: int) -> np.ndarray:
        other = replace(est)
        other.__dict__["shape"] = est._shape(steps)
        return np.concatenate([other.run(other.start(), i).e for i in range(len(other.segments))])

    steps, coarse = 1, innovations(1)
    while steps < most:
        fine = innovations(2 * steps)
        if np.all(np.abs(fine - coarse) < COARSEST * (1.0 + np.abs(fine))):
            return steps
        coarse, steps = fine, 2 * steps
    return most


# ---- Units in which the filter counts random forces.


def force_units(model: Model, segments: Sequence[Segment]) -> np.ndarray:
    """Units (nf,) of the forces: rho L^2 U0^2 / 2 (times L), or a typical yaw acceleration for response models."""
    if model.is_3dof:
        length, rho = model.particulars.get("L", 1.0), model.particulars.get("rho", 1025.0)
        pressure = 0.5 * rho * length**2 * model.speed_m_s**2
        return np.array([pressure, pressure, pressure * length])
    slopes = []
    for d in segments:
        rate = d.measured[:, 1] if np.isfinite(d.measured[:, 1]).any() else np.gradient(d.measured[:, 0], d.time)
        window = max(2, d.time.size // 100)
        rise = (rate[window:] - rate[:-window]) / (d.time[window:] - d.time[:-window])
        slopes.append(np.sqrt(np.mean(rise[np.isfinite(rise)] ** 2)) if np.isfinite(rise).any() else 0.0)
    typical = 6000.0 * max(float(np.median(slopes)), 1e-9)
    return np.array([typical] if "w" not in model.states else [typical / max(_fast_time(model), 1e-3), typical])


def _fast_time(model: Model) -> float:
    """A second-order response model's shorter time constant: forces on its highest derivative count against it."""
    a1 = model.coefficients[0]
    return 1.0 / max(abs(a1), 1e-6) if np.isfinite(a1) else 1.0
