"""Free runs fitted to several records at once, with effects that each record has of its own.

A free run uses nothing of a record but its inputs, its measured wind and its initial state.  Numbers of the model
(coefficients or constants) have Gaussian priors and are common to all records.  Every record has a deviation of its
neutral rudder angle and of its initial state, with priors too: without them the coefficients would absorb the trim of
single runs.

The criterion is the sum over channels of N_eff / 2 log(S_c + floor_c^2), S_c being the mean squared error of all
records and N_eff the records' duration over the correlation time of the residuals, plus half the squares of all numbers
in prior standard deviations.  Measured thrust counts with a fixed standard deviation, N_eff S_c / (2 sd_c^2).
Gauss-Newton steps eliminate the records' own effects by a Schur complement; leaving a record out subtracts its part of
the normal equations and takes one step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..models.errors import CannotFit
from .likelihood.minimiser import Damping, try_steps
from .linear_algebra import finite
from .series import MEASURED, Series, samples, series_of
from .weather import with_wind

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

THRUST = "propeller_thrust_N"
CORRELATION = 1.7
"""Correlation time of the residuals of free runs, in ship lengths sailed (10 s for a 7 m model at 1.18 m/s)."""
STEP = 0.035
"""Largest time step of the runs, in ship lengths sailed."""
NEUTRAL_ANGLE_SD = np.deg2rad(0.3)
"""Standard deviation of a record's neutral rudder angle about the common one, rad."""
START_SD = {"u": 2.5e-3, "v": 2.5e-3, "r": 3e-3, "psi": 2e-3}
"""Standard deviation of a record's initial state about the estimated one: shares of speed, of speed / length, rad."""
FLOOR = {"u": 2.5e-3, "v": 2.5e-3, "r": 5e-3, "psi": np.deg2rad(0.5), THRUST: 0.05}
"""Error below which a channel counts as perfect: shares of speed, of speed / length, rad, share of the mean thrust."""
LARGEST = 20.0
"""Largest residual, in the channel's own size, that a run which leaves the record counts with."""
DIFFERENCE = 1e-3
"""Step of the derivatives, in prior standard deviations."""
FIRST_DAMPING = 1e-2
RULE = Damping(growth=5.0, least=5e-3, trials=6)
ENOUGH = 0.01
"""Fall of the criterion below which a fit ends."""
Block = tuple[np.ndarray, np.ndarray, np.ndarray]
"""One record's share of the normal equations (p, p), (p,), and how its own effects follow (k, p + 1)."""
LONGEST = 3.0
"""Longest single step, in prior standard deviations."""
START_S = 0.17
"""Stretch of a record from which its initial state is estimated, in ship lengths sailed."""


@dataclass(frozen=True)
class Number:
    """One number of the model that may move: place in `Model.theta`, prior mean and standard deviation."""

    name: str
    place: int
    mean: float
    sd: float


@dataclass(frozen=True)
class Run:
    """One record prepared for free runs: its series, thinned, and the thrust (N,) where it was measured.

    The inputs of the series hold the measured wind where it counts, see `weather.with_wind`.
    """

    series: Series
    thrust: np.ndarray | None
    duration_s: float

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.series.name


@dataclass(frozen=True, eq=False)
class Problem:
    """A model and the records that it is fitted to.

    channels : symbols of the states that count, and THRUST where a record measures it.
    thrust : thrust [N] from states (N, n), inputs (N, nu) and theta; None where the family has none.
    """

    model: Model
    runs: tuple[Run, ...]
    channels: tuple[str, ...]
    length_s: float
    thrust: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray] | None

    @cached_property
    def unit(self) -> np.ndarray:
        """(C,) size of each channel in which FLOOR and START_SD are shares."""
        speed = self.model.speed_m_s if np.isfinite(self.model.speed_m_s) else 1.0
        sizes = {"u": speed, "v": speed, "r": 1.0 / self.length_s, "psi": 1.0, THRUST: self._mean_thrust}
        return np.array([sizes[c] for c in self.channels])

    @property
    def _mean_thrust(self) -> float:
        known = [np.nanmean(np.abs(run.thrust)) for run in self.runs if run.thrust is not None]
        return float(np.mean(known)) if known else 1.0

    @cached_property
    def floor(self) -> np.ndarray:
        """(C,) error below which a channel counts as perfect, SI."""
        return self.unit * np.array([FLOOR[c] for c in self.channels])

    @cached_property
    def known(self) -> np.ndarray:
        """(C,) channels whose error size is the floor: a fit must not give up measured thrust for other channels."""
        return np.array([c == THRUST for c in self.channels])

    @property
    def states(self) -> tuple[str, ...]:
        """States whose initial value belongs to a record."""
        return tuple(s for s in START_SD if s in self.model.states)

    @cached_property
    def own_sd(self) -> np.ndarray:
        """(k,) prior standard deviations of a record's own effects: neutral rudder angle, initial states."""
        speed = self.model.speed_m_s if np.isfinite(self.model.speed_m_s) else 1.0
        sizes = {"u": speed, "v": speed, "r": 1.0 / self.length_s, "psi": 1.0}
        return np.array([NEUTRAL_ANGLE_SD, *(START_SD[s] * sizes[s] for s in self.states)])

    @cached_property
    def weight(self) -> np.ndarray:
        """(R,) independent values that a record's duration amounts to."""
        return np.array([run.duration_s for run in self.runs]) / (CORRELATION * self.length_s)

    def residuals(self, theta: np.ndarray, run: Run, own: np.ndarray) -> np.ndarray:
        """Measured minus simulated channels (N, C), SI; nan at gaps, LARGEST units where the run is lost.

        theta : the model's, or that of its environment variant, whose wind coefficients then take part.
        """
        from ..models.simulate import substeps, variant

        series, model = run.series, self.model
        inputs = series.inputs.copy()
        inputs[:, 0] += own[0]
        start = series.start.copy()
        for value, symbol in zip(own[1:], self.states, strict=True):
            start[model.states.index(symbol)] += value
        states, count = np.empty((len(inputs), start.size)), substeps(model, series.dt)
        kernels, numbers = variant(model, inputs.shape[1], theta)
        kernels.simulate(start, inputs, numbers, series.dt / count, count, False, states)
        found = [series.observe(states[:, series.columns])]
        if THRUST in self.channels:
            found.append(self._thrust_of(run, states, inputs, theta))
        error = self._measured(run) - np.column_stack(found)
        lost = ~np.isfinite(error) & np.isfinite(self._measured(run))
        with np.errstate(invalid="ignore"):
            error = np.clip(error / self.unit, -LARGEST, LARGEST)
        return np.where(lost, LARGEST, error) * self.unit

    def _thrust_of(self, run: Run, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray) -> np.ndarray:
        if run.thrust is None or self.thrust is None:
            return np.full(len(run.series.index), np.nan)
        with np.errstate(all="ignore"):
            own = self.model.theta.size
            return run.series.observe(self.thrust(states, inputs[:, : len(self.model.inputs)], theta[:own]))

    def _measured(self, run: Run) -> np.ndarray:
        if THRUST not in self.channels:
            return run.series.outputs
        missing = np.full(len(run.series.index), np.nan)
        return np.column_stack([run.series.outputs, missing if run.thrust is None else run.thrust])


@dataclass(frozen=True)
class Squares:
    """Sums of squared errors (C,) and counts (C,) of one record."""

    total: np.ndarray
    count: np.ndarray


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fit: theta with its free numbers, the records' own effects (R, k), error sizes (C,), criterion.

    normal, slope : normal equations (p, p), (p,) of the free numbers with all own effects eliminated, priors included;
    parts : each record's share of them.
    """

    problem: Problem
    numbers: tuple[Number, ...]
    theta: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    criterion: float
    normal: np.ndarray
    slope: np.ndarray
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]

    @property
    def values(self) -> np.ndarray:
        """(p,) values of the free numbers."""
        return self.theta[[n.place for n in self.numbers]]


@dataclass(frozen=True)
class LeftOut:
    """One record predicted by a fit to the others: the free numbers' values (p,), squared errors with the record's own
    effects estimated and with none, and half the penalty of the own effects."""

    values: np.ndarray
    adapted: Squares
    free: Squares
    penalty: float


def problem(model: Model, records: Sequence[Record]) -> Problem:
    """The model and records as a problem; records are thinned to STEP.

    Raises
    ------
    CannotFit : no record, the model has no speed and length to scale by, or a record lacks a channel.
    """
    length_s = ship_length_s(model)
    symbols = [s for s in MEASURED if s in model.states and all(_measures(r, s) for r in records)]
    if not records or not symbols:
        raise CannotFit("no record, or no state that all records measure")
    from ..models.outputs import thrust_of

    thrust = thrust_of(model.family)
    runs = tuple(_run(record, model, symbols, length_s) for record in records)
    held = thrust is not None and any(run.thrust is not None for run in runs)
    relaxed = replace(model, max_step_s=max(model.max_step_s, STEP * length_s))
    return Problem(relaxed, runs, (*symbols, *((THRUST,) if held else ())), length_s, thrust)


def ship_length_s(model: Model) -> float:
    """Time in which the ship sails her own length, s.

    Raises
    ------
    CannotFit : the model has no speed or no length.
    """
    length = model.particulars.get("L") or dict(zip(model.constant_names, model.constants, strict=True)).get("L")
    if not length or not model.speed_m_s > 0.0:
        raise CannotFit(f"model {model.id} states no length and speed to scale by")
    return float(length / model.speed_m_s)


def _measures(record: Record, symbol: str) -> bool:
    values = samples(record, symbol)
    return values is not None and bool(np.isfinite(values).any())


def _run(record: Record, model: Model, symbols: Sequence[str], length_s: float) -> Run:
    thinned = record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))
    series = with_wind(series_of(thinned, model, symbols), record, model)
    thrust = _smoothed(record, thinned) if record.has(THRUST) else None
    series = replace(series, start=_start(series, record, model, length_s))
    return Run(series, thrust, float(record.time_s[-1] - record.time_s[0]))


def _smoothed(record: Record, thinned: Record) -> np.ndarray:
    """Thrust at the thinned samples, as the mean over twelve of them."""
    values, n = record.column(THRUST), max(1, round(12.0 * thinned.dt / record.dt))
    known = np.isfinite(values)
    kernel = np.ones(n)
    total = np.convolve(np.where(known, values, 0.0), kernel, "same")
    count = np.convolve(known.astype(float), kernel, "same")
    mean = np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)
    return np.interp(thinned.time_s, record.time_s, mean)


def _start(series: Series, record: Record, model: Model, length_s: float) -> np.ndarray:
    """Initial state by a polynomial through the first stretch of each measured state."""
    start, t = series.start.copy(), record.time_s - record.time_s[0]
    for i, symbol in enumerate(model.states):
        values = samples(record, symbol) if symbol in MEASURED else None
        if values is None:
            continue
        early = np.isfinite(values) & (t <= START_S * length_s)
        if early.sum() >= 3:
            degree = 2 if early.sum() >= 6 else 1
            start[i] = np.polyval(np.polyfit(t[early], values[early], degree), 0.0)
    return start


# ---- fit
class _Here(NamedTuple):
    """Where a fit stands: theta, the records' own effects, error sizes, criterion."""

    theta: np.ndarray
    own: np.ndarray
    sd: np.ndarray
    cost: float


def fit(
    p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray | None = None, most: int = 12
) -> Fitted:
    """Damped Gauss-Newton steps from theta as long as the criterion falls.

    theta (m,) : start; own (R, k) : start of the records' own effects, zero unless given.
    """
    own = np.zeros((len(p.runs), p.own_sd.size)) if own is None else own
    here, damping = _at(p, numbers, theta, own), FIRST_DAMPING
    for _ in range(most):
        normal, slope, blocks = normal_equations(p, numbers, here.theta, here.own, here.sd)
        trial = try_steps(
            partial(_damped, normal, slope), partial(_moved, p, numbers, here, blocks), here.cost, damping, 0.0, RULE
        )
        if not trial.better:
            break
        gained, here, damping = here.cost - trial.point.cost, trial.point, max(trial.damping / RULE.growth, 1e-6)
        if gained < ENOUGH:
            break
    normal, slope, blocks = normal_equations(p, numbers, here.theta, here.own, here.sd)
    parts = tuple((a, g) for a, g, _ in blocks)
    return Fitted(p, tuple(numbers), here.theta, here.own, here.sd, here.cost, normal, slope, parts)


def _damped(normal: np.ndarray, slope: np.ndarray, damping: float) -> tuple[np.ndarray, float]:
    step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), slope)
    return step, 0.5 * float(slope @ step)


def _moved(p: Problem, numbers: Sequence[Number], here: _Here, blocks: Sequence[Block], step: np.ndarray) -> _Here:
    """Where a step of the free numbers leads; the own effects follow it."""
    theta = here.theta.copy()
    theta[[n.place for n in numbers]] += step
    own = np.array([b + x[:, -1] - x[:, :-1] @ step for b, (_, _, x) in zip(here.own, blocks, strict=True)])
    return _at(p, numbers, theta, own)


def _at(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> _Here:
    cost, sd = _criterion(p, numbers, theta, own)
    return _Here(theta, own, sd, cost)


def stepped(
    found: Fitted,
    numbers: Sequence[Number],
    pick: np.ndarray,
    equations: tuple[np.ndarray, np.ndarray, Sequence[Block]],
) -> Fitted:
    """One Gauss-Newton step of some numbers from a fit, by `equations` of more numbers, of which `pick` are these."""
    p, (normal, slope, blocks) = found.problem, equations
    block = normal[np.ix_(pick, pick)]
    step = np.linalg.lstsq(finite(block), slope[pick], rcond=None)[0]
    step *= min(1.0, LONGEST / max(float(np.max(np.abs(step) / [n.sd for n in numbers], initial=0.0)), 1e-9))
    theta = found.theta.copy()
    theta[[n.place for n in numbers]] += step
    own = np.array([b + x[:, -1] - x[:, pick] @ step for b, (_, _, x) in zip(found.own, blocks, strict=True)])
    criterion, sd = _criterion(p, numbers, theta, own)
    parts = tuple((a[np.ix_(pick, pick)], g[pick] - a[np.ix_(pick, pick)] @ step) for a, g, _ in blocks)
    return Fitted(p, tuple(numbers), theta, own, sd, criterion, block, slope[pick] - block @ step, parts)


def squares(p: Problem, theta: np.ndarray, run: Run, own: np.ndarray | None = None) -> Squares:
    """Squared errors of one free run; own: the record's own effects, none unless given."""
    error = p.residuals(theta, run, np.zeros(p.own_sd.size) if own is None else own)
    return Squares(np.nansum(error**2, axis=0), np.isfinite(error).sum(axis=0))


def pooled(parts: Sequence[Squares]) -> np.ndarray:
    """Root mean squared error (C,) over records; nan where nothing was measured."""
    count = sum(part.count for part in parts)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(sum(part.total for part in parts) / count)


def _criterion(p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray) -> tuple[float, np.ndarray]:
    """The criterion and the error sizes (C,), floors included."""
    errors = pooled([squares(p, theta, run, b) for run, b in zip(p.runs, own, strict=True)])
    sd = np.where(p.known, p.floor, np.sqrt(errors**2 + p.floor**2))
    misfit = np.where(p.known, 0.5 * (errors / p.floor) ** 2, np.log(sd))
    prior = sum(((theta[n.place] - n.mean) / n.sd) ** 2 for n in numbers) + float(np.sum((own / p.own_sd) ** 2))
    return float(p.weight.sum() * np.sum(misfit) + 0.5 * prior), sd


def normal_equations(
    p: Problem, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, list[Block]]:
    """Normal equations (p, p), (p,) of the free numbers, priors included, with all own effects eliminated.

    Also for each record its share of both, and (k, p + 1) how its own effects follow: constant part last, minus slopes.
    """
    blocks = [_block(p, i, numbers, theta, own[i], sd) for i in range(len(p.runs))]
    precision = np.array([n.sd**-2.0 for n in numbers])
    mean, values = np.array([n.mean for n in numbers]), theta[[n.place for n in numbers]] if numbers else np.zeros(0)
    normal = np.diag(precision) + sum(a for a, _, _ in blocks)
    return normal, sum(g for _, g, _ in blocks) - precision * (values - mean), blocks


def _block(
    p: Problem, i: int, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray, sd: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One record's normal equations with its own effects eliminated: (p, p), (p,), (k, p + 1)."""
    run, q = p.runs[i], len(numbers)
    error, slopes = _jacobian(p, run, numbers, theta, own)
    counted = np.maximum(np.isfinite(error).sum(axis=0), 1)
    weight = np.sqrt(p.weight[i] / counted) / sd
    rows = np.where(np.isfinite(slopes), slopes, 0.0) * weight[None, :, None]
    target = np.where(np.isfinite(error), error, 0.0) * weight
    rows, target = rows.reshape(-1, rows.shape[2]), target.ravel()
    matrix, slope = rows.T @ rows, -(rows.T @ target)
    inner = matrix[q:, q:] + np.diag(p.own_sd**-2.0)
    pull = slope[q:] - own / p.own_sd**2
    follow = np.linalg.solve(inner, np.column_stack([matrix[q:, :q], pull]))
    return matrix[:q, :q] - matrix[:q, q:] @ follow[:, :q], slope[:q] - matrix[:q, q:] @ follow[:, q], follow


def _jacobian(
    p: Problem, run: Run, numbers: Sequence[Number], theta: np.ndarray, own: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors (N, C) and their central differences (N, C, p + k) by the free numbers and the record's own effects."""
    error = p.residuals(theta, run, own)
    out = np.empty((*error.shape, len(numbers) + own.size))
    for j, n in enumerate(numbers):
        h, ahead, behind = DIFFERENCE * n.sd, theta.copy(), theta.copy()
        ahead[n.place] += h
        behind[n.place] -= h
        out[:, :, j] = (p.residuals(ahead, run, own) - p.residuals(behind, run, own)) / (2.0 * h)
    for j, sd in enumerate(p.own_sd):
        h = 10.0 * DIFFERENCE * sd
        step = h * (np.arange(own.size) == j)
        ahead, behind = p.residuals(theta, run, own + step), p.residuals(theta, run, own - step)
        out[:, :, len(numbers) + j] = (ahead - behind) / (2.0 * h)
    return error, out


# ---- prediction of records that were left out
def own_effects(p: Problem, i: int, theta: np.ndarray, sd: np.ndarray, own: np.ndarray, most: int = 2) -> np.ndarray:
    """The own effects (k,) of one record at given common numbers."""
    cost, damping = _own_cost(p, i, theta, sd, own), 1e-3
    for _ in range(most):
        follow = _block(p, i, (), theta, own, sd)[2]
        for _ in range(4):
            trial = own + follow[:, -1] / (1.0 + damping)
            lower = _own_cost(p, i, theta, sd, trial)
            if lower < cost:
                own, cost, damping = trial, lower, damping / 5.0
                break
            damping = 8.0 * max(damping, 0.1)
        else:
            break
    return own


def _own_cost(p: Problem, i: int, theta: np.ndarray, sd: np.ndarray, own: np.ndarray) -> float:
    part = squares(p, theta, p.runs[i], own)
    mean = part.total / np.maximum(part.count, 1)
    return float(0.5 * p.weight[i] * np.sum(mean / sd**2) + 0.5 * np.sum((own / p.own_sd) ** 2))


def leave_one_out(found: Fitted) -> tuple[LeftOut, ...]:
    """Each record predicted by a fit to the others: its normal equations subtracted and one step taken."""
    return tuple(_left_out(found, i) for i in range(len(found.problem.runs)))


def _left_out(found: Fitted, i: int) -> LeftOut:
    p, theta = found.problem, found.theta.copy()
    if found.numbers:
        matrix, slope = found.parts[i]
        step = np.linalg.solve(found.normal - matrix, found.slope - slope)
        size = float(np.max(np.abs(step) / np.array([n.sd for n in found.numbers])))
        theta[[n.place for n in found.numbers]] += step * min(1.0, LONGEST / max(size, 1e-9))
    own = own_effects(p, i, theta, found.sd, found.own[i])
    penalty = 0.5 * float(np.sum((own / p.own_sd) ** 2))
    adapted, free = squares(p, theta, p.runs[i], own), squares(p, theta, p.runs[i])
    return LeftOut(theta[[n.place for n in found.numbers]], adapted, free, penalty)


def score(p: Problem, parts: Sequence[LeftOut], kept: Sequence[int] | None = None) -> float:
    """Mean of the log scores with the records' own effects (penalised) and of plain free runs; lower is better.

    kept : records that count, all unless given.
    """
    kept = list(range(len(parts))) if kept is None else list(kept)
    floor = p.floor**2
    adapted = pooled([parts[i].adapted for i in kept]) ** 2
    free = pooled([parts[i].free for i in kept]) ** 2
    penalty = sum(parts[i].penalty for i in kept) / float(p.weight[kept].sum())
    states = [c for c, name in enumerate(p.channels) if name != THRUST]
    known = [c for c in states if np.isfinite(adapted[c])]
    both = 0.5 * np.log(adapted + floor) + 0.5 * np.log(free + floor)
    return float(0.5 * np.sum(both[known]) + 0.5 * penalty)


def jackknife(values: np.ndarray) -> np.ndarray:
    """Jackknife standard error (...,) of a statistic from its values (R, ...) with one record left out each."""
    n = len(values)
    return np.sqrt((n - 1.0) / n * np.sum((values - values.mean(axis=0)) ** 2, axis=0))


def score_difference(p: Problem, old: Sequence[LeftOut], new: Sequence[LeftOut]) -> tuple[float, float]:
    """By how much the score falls from old to new, and its jackknife standard error over records."""
    everyone = range(len(old))
    others = [[j for j in everyone if j != i] for i in everyone]
    single = np.array([score(p, old, kept) - score(p, new, kept) for kept in others])
    return score(p, old) - score(p, new), float(jackknife(single)) if len(old) > 1 else np.inf
