"""Derivatives of the whitened innovations by parameters, all from one stored run of each segment.

The gains of the filter are held: what is left out has mean zero at the truth, so that the estimating equations
D e = 0 keep their root.  An entry of the model, of the rudder chain or of the environment pushes the states; one of a
sensor shifts what the channel shows.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from .estimator import probes
from .vector import BIAS, CHANNELS, DELAY, DRIFT, EARTH, MISALIGNMENT, SCALE, SPEED

if TYPE_CHECKING:
    from ._arguments import FilterRun, Trace
    from .estimator import Estimator
    from .settings import Parameter, Setting

Series = Sequence[np.ndarray]
U, V = 2, 3
NO_PUSHES = np.zeros((0, 0, 0))


def traces(est: Estimator, s: Setting) -> list[Trace]:
    """Every segment through the filter, stored for `responses`."""
    return est.in_threads(lambda i: est.traced(s, i)[1], range(len(est.segments)))


def responses(
    est: Estimator,
    runs: Sequence[Trace],
    axes: Sequence[int],
    forcing: Sequence[Series],
    into: np.ndarray | None = None,
) -> np.ndarray:
    """Derivatives (m, N*6) of the whitened innovations by the size of added series.

    axes : (m,) a force, or the number of forces + a channel.  forcing : for each, one array (T,) a segment.
    into : zeros (m, N*6) that are filled, instead of new ones.
    """
    out = np.zeros((len(axes), est.edges[-1] * CHANNELS)) if into is None else into
    still = np.zeros((len(axes), len(est.kernels.STATES)))
    for i, trace in enumerate(runs):
        sizes = np.ascontiguousarray(np.stack([series[i] for series in forcing]))
        _carry(est, trace, i, np.array(axes, np.int64), sizes, still, out)
    return out


def tangent(est: Estimator, s: Setting, entries: Sequence[int], steps: Mapping[int, float] | None = None) -> np.ndarray:
    """Derivatives (m, N*6) of the whitened innovations by entries of the parameter vector.

    steps : entry -> step over which its push of the states is differenced (default: `estimator.probes`).
    """
    order = np.argsort(entries, kind="stable")
    if np.any(np.diff(order) < 0):  # rows are filled in place, those of entries that push the states first
        return tangent(est, s, [entries[j] for j in order], steps)[np.argsort(order)]
    out = np.zeros((len(entries), est.edges[-1] * CHANNELS))
    outer = np.array(entries) - est.n_theta
    pushing, given = np.flatnonzero(outer < DRIFT + 2), steps or {}
    sensors = np.flatnonzero(outer >= DRIFT + 2)
    runs = est.in_threads(lambda i: est.traced(s, i), range(len(est.segments)))

    def along(i: int, rows: np.ndarray) -> None:
        (run, trace), varied = runs[i], [entries[row] for row in rows]
        over = probes(s.vectors[i, varied])
        over = np.array([given.get(entry, h) for entry, h in zip(varied, over.tolist(), strict=True)])
        _carry_pushes(est, trace, i, _pushes(est, s, i, run, varied, over), out[rows[0] : rows[-1] + 1])

    def beside(i: int) -> None:
        _carry_sensors(est, s, i, *runs[i], sensors, outer[sensors], out)

    jobs: list[Callable[[], None]] = [partial(along, *job) for job in _shared_out(pushing, len(runs), est.threads)]
    jobs += [partial(beside, i) for i in range(len(runs) if sensors.size else 0)]
    est.in_threads(lambda job: job(), jobs)
    return out


def _pushes(
    est: Estimator, s: Setting, segment: int, run: FilterRun, varied: Sequence[int], steps: np.ndarray
) -> np.ndarray:
    """Changes (T, m, n) of the states over the next step by entries of the vector, along a run at the setting."""
    from ._pushes import run_pushes  # numba

    found = np.zeros((run.e.shape[0], len(varied), est.shape.n))
    if len(varied):
        recorded, values = est.arguments(s, segment)
        model, which = (est.kernels.rhs, est.kernels.jacobian), np.array(varied, np.int64)
        run_pushes(*model, est.shape, est.places, recorded, values, which, steps, run.states, found)
    return found


def _shared_out(rows: np.ndarray, segments: int, threads: int) -> list[tuple[int, np.ndarray]]:
    """The rows of every segment as jobs; segments that would leave threads idle are cut into a job for each."""
    whole = segments - segments % threads
    parts = [part for part in np.array_split(rows, threads) if part.size]
    every = [(i, rows) for i in range(whole if rows.size else 0)]
    return every + [(i, part) for i in range(whole, segments) for part in parts]


def columns(est: Estimator, s: Setting, parameters: Sequence[Parameter]) -> np.ndarray:
    """Derivatives (m, N*6) of the whitened innovations by parameters; zero where they are not finite."""
    out = np.zeros((len(parameters), est.edges[-1] * CHANNELS))
    single = [j for j, p in enumerate(parameters) if p.series is None]
    entries = sorted({entry for j in single for entry, _ in parameters[j].slots})
    rows = dict(zip(entries, tangent(est, s, entries, _steps(est, parameters)), strict=True)) if entries else {}
    for j in single:
        p, segments = parameters[j], est.rows(parameters[j].record)
        own = slice(est.edges[segments[0]] * CHANNELS, est.edges[segments[-1] + 1] * CHANNELS)
        for (entry, _), weight in zip(p.slots, _weights(est, s, p), strict=True):
            out[j, own] += weight * rows[entry][own]
    added = [j for j, p in enumerate(parameters) if p.series is not None]
    if added:
        series = [parameters[j].series for j in added]
        found = responses(est, traces(est, s), [x[0] for x in series if x], [x[1] for x in series if x])
        out[added] = found
    out[~np.isfinite(out).all(axis=1)] = 0.0
    return out


def _steps(est: Estimator, parameters: Sequence[Parameter]) -> dict[int, float]:
    """Steps of entries of rudder and environment: a small change of the parameters that move them (play far below the
    rudder sensor's noise acts otherwise than play of its size)."""
    found: dict[int, float] = {}
    for p in parameters:
        for entry, weight in p.slots if p.law is None else ():
            if entry >= est.n_theta:
                found[entry] = min(found.get(entry, np.inf), p.scale * abs(weight))
    return found


def _weights(est: Estimator, s: Setting, p: Parameter) -> list[float]:
    """How much each slot moves when the parameter does, at its present value."""
    if p.law is None:
        return [weight for _, weight in p.slots]
    value = est.value(s, p)
    step = p.scale if value + p.scale <= p.high else -p.scale
    slope = (np.asarray(p.law(value + step)) - np.asarray(p.law(value))) / step
    return [float(part * weight) for part, (_, weight) in zip(slope, p.slots, strict=True)]


def _carry(
    est: Estimator, trace: Trace, i: int, axes: np.ndarray, forcing: np.ndarray, initial: np.ndarray, out: np.ndarray,
    pushed: np.ndarray = NO_PUSHES,
) -> None:  # fmt: skip
    from ._derivatives import carry  # numba

    run = (trace.transition, trace.slopes, trace.gains, trace.roots)
    n, first = len(est.kernels.STATES), est.edges[i]
    carry(*run, n, est.n_forces, axes, forcing, pushed, initial, first, out)


def _carry_pushes(est: Estimator, trace: Trace, i: int, pushed: np.ndarray, out: np.ndarray) -> None:
    """Fill the derivatives (m, N*6) by entries that push the states (T, m, n)."""
    m = pushed.shape[1]
    axes = np.arange(m) + est.n_forces + CHANNELS
    one, still = np.ones((m, est.segments[i].time.size)), np.zeros((m, len(est.kernels.STATES)))
    _carry(est, trace, i, axes, one, still, out, pushed)


def _carry_sensors(
    est: Estimator,
    s: Setting,
    i: int,
    run: FilterRun,
    trace: Trace,
    rows: np.ndarray,
    entries: np.ndarray,
    out: np.ndarray,
) -> None:
    """Fill the rows of entries of the sensors: each is one or two shifted channels."""
    shifts = [(row, c, shift) for row, entry in zip(rows, entries, strict=True)
              for c, shift in _shifts(est, s, i, run, trace, int(entry))]  # fmt: skip
    if not shifts:
        return
    initial = np.zeros((len(shifts), len(est.kernels.STATES)))
    q = s.vectors[i, est.n_theta :]
    place = dict(zip(rows.tolist(), entries.tolist(), strict=True))
    for j, (row, c, shift) in enumerate(shifts):
        starts = place[row] in (SCALE + c, BIAS + c) and est.places[c] >= 0 and not (c in (U, V) and q[EARTH] > 0.0)
        if starts and not (c == U and q[SPEED] > 0.0):  # the first state is what the channel's first sample says
            initial[j, est.places[c]] = -shift[0] / (1.0 + q[SCALE + c])
    axes = np.array([est.n_forces + c for _, c, _ in shifts], np.int64)
    found = np.zeros((len(shifts), out.shape[1]))
    _carry(est, trace, i, axes, np.stack([shift for *_, shift in shifts]), initial, found)
    own = slice(est.edges[i] * CHANNELS, est.edges[i + 1] * CHANNELS)
    for j, (row, *_) in enumerate(shifts):
        out[row, own] += found[j, own]


def _shifts(
    est: Estimator, s: Setting, i: int, run: FilterRun, trace: Trace, entry: int
) -> list[tuple[int, np.ndarray]]:
    """Channels that an entry of the sensors shifts, with the derivatives (T,) of what they show.

    Waves and clock jitter have none: they are variances.
    """
    q = s.vectors[i, est.n_theta :]

    def shown(c: int) -> np.ndarray:
        """What the sensor of channel c would show without scale and bias."""
        return (run.predicted[:, c] - q[BIAS + c]) / (1.0 + q[SCALE + c])

    def gain(c: int) -> float:
        return 1.0 + q[SCALE + c]

    for first, shift in (
        (SCALE, shown),
        (BIAS, lambda c: np.ones(run.e.shape[0])),
        (DELAY, lambda c: -gain(c) * _rates(est, q, trace, run, c)),
    ):
        if first <= entry < first + CHANNELS:
            c = entry - first
            return [(c, shift(c))] if est.places[c] >= 0 else []
    if entry == MISALIGNMENT and est.places[U] >= 0 and est.places[V] >= 0:
        return [(U, gain(U) * shown(V)), (V, -gain(V) * shown(U))]
    if entry == SPEED and est.places[U] >= 0:
        return [(U, gain(U) * shown(U) / q[SPEED])]
    return []


def _rates(est: Estimator, q: np.ndarray, trace: Trace, run: FilterRun, c: int) -> np.ndarray:
    """Time derivative (T,) of what the sensor of channel c shows, without its scale."""
    if c == U and q[SPEED] > 0.0:
        return -q[SPEED] * trace.rates[:, c]
    if c not in (U, V) or est.places[U] < 0 or est.places[V] < 0:
        return trace.rates[:, c]
    angle = -run.states[:, est.places[0]] if q[EARTH] > 0.0 else np.full(run.e.shape[0], q[MISALIGNMENT])
    along, across = trace.rates[:, U], trace.rates[:, V]
    if c == U:
        return along * np.cos(angle) + across * np.sin(angle)
    return -along * np.sin(angle) + across * np.cos(angle)
