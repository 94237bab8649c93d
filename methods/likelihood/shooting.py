"""Multiple shooting: records cut into stretches whose initial states are unknowns, closed step by step.

Short runs cannot run away, whatever the coefficients, so a start may be poor and the ship unstable on its course.  The
jumps between stretches are penalised by their squares, in units of a standard deviation that shrinks until the
trajectory is continuous to a millionth of its size; a run over the whole record from there closes it exactly.
Bock 1983, Recent advances in parameter identification for ODE; the penalty's homotopy as in Voss, Timmer & Kurths 2004.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .. import factors, freerun
from ..series import Series
from .horizons import measured_state
from .minimiser import ROUGH, Minimum, levenberg_marquardt
from .problem import Point, Problem

CLOSING = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Standard deviations of the jumps in turn, in units of the states' size."""
SHORTEST_STRETCH = 8
"""Steps of the time grid that a stretch has at least."""
ITERATIONS = 12
"""Of each stage but the first."""


@dataclass(frozen=True)
class Chain(Problem):
    """A problem whose series are stretches, those of `links` to be joined without a jump."""

    links: tuple[tuple[int, int], ...] = ()
    jump_sd: np.ndarray = field(default_factory=lambda: np.ones(0))
    """(n,) standard deviation that jumps are counted in."""

    def jumps(self, z: np.ndarray) -> np.ndarray:
        """Differences (links, n) between the end of a stretch and the next one's initial state; zero if not joined."""
        model, runs = self.unpack(z)
        found = np.zeros((len(self.links), len(model.states)))
        for row, (left, right) in zip(found, self.links, strict=True):
            series, state, free, _ = runs[left]
            row[list(free)] = (freerun.end_state(model, series, state) - runs[right][1])[list(free)]
        return found

    def at(self, z: np.ndarray) -> Point:
        point = super().at(z)
        if not np.isfinite(point.cost):
            return point
        cost = point.cost + 0.5 * float(np.sum((self.jumps(z) / self.jump_sd) ** 2))
        return point._replace(cost=cost if np.isfinite(cost) else np.inf)

    def _folded(self, point: Point, scale: np.ndarray, weights: tuple[np.ndarray, ...] | None) -> np.ndarray:
        return factors.fold(super()._folded(point, scale, weights), self._jump_rows(point.z))

    def _jump_rows(self, z: np.ndarray) -> np.ndarray:
        """Rows of [derivatives | - jump] in units of the jumps' standard deviation."""
        model, runs = self.unpack(z)
        chart = None if self.unknowns is None else self.unknowns.jacobian(z[: self.own])
        rows = []
        for left, right in self.links:
            series, state, free, place = runs[left]
            end, columns = freerun.end_of(model, series, state, free)
            own = np.column_stack([columns, runs[right][1] - end])[list(free)]
            wide = freerun.embed(own, chart, self.own, place, self.width)
            wide[np.arange(len(free)), runs[right][3] + np.arange(len(free))] -= 1.0
            rows.append(wide / self.jump_sd[list(free), None])
        return np.vstack(rows)

    def first(self, z: np.ndarray) -> np.ndarray:
        """The unknowns of runs over whole records: those of each record's first stretch."""
        joined = {right for _, right in self.links}
        _, runs = self.unpack(z)
        states = [z[place : place + len(free)] for i, (_, _, free, place) in enumerate(runs) if i not in joined]
        return np.concatenate([z[: self.own], *states])


class Shot(NamedTuple):
    """A chain closed as far as penalties can."""

    chain: Chain
    minimum: Minimum
    n_iterations: int


def shoot(problem: Problem, own: np.ndarray, stretches: int, most: int) -> Shot:
    """The problem (channels weighed by their sensors) from coefficients or parameters `own`, closed in stages."""
    chain = chained(problem, stretches)
    z, count = chain.start(own), 0
    size = chain.jump_sd
    for stage, share in enumerate(CLOSING):
        chain = replace(chain, jump_sd=share * size)
        found = levenberg_marquardt(chain, z, ITERATIONS if stage else most, ROUGH)
        z, count = found.z, count + found.n_iterations
    return Shot(chain, found, count)


def chained(problem: Problem, stretches: int) -> Chain:
    """The problem with every record cut into that many stretches; jumps count in units of the states' size."""
    cut, free, links = [], [], []
    for series, own in zip(problem.series, problem.free, strict=True):
        pieces = _stretches(series, problem, stretches)
        links += [(len(cut) + i, len(cut) + i + 1) for i in range(len(pieces) - 1)]
        cut += pieces
        free += [own] * len(pieces)
    starts = np.array([s.start for s in cut])
    size = starts.std(axis=0) + np.mean([s.start_sd for s in cut], axis=0)
    shared = {"unknowns": problem.unknowns, "loss": problem.loss, "sensor": problem.sensor}
    size = np.where(size > 0.0, size, 1.0)
    return Chain(problem.model, tuple(cut), tuple(free), links=tuple(links), jump_sd=size, **shared)


def _stretches(series: Series, problem: Problem, count: int) -> list[Series]:
    """The series cut at points of its time grid; each stretch but the first starts from what is measured there."""
    steps = len(series.inputs) - 1
    edges = np.round(np.linspace(0, steps, max(1, min(count, steps // SHORTEST_STRETCH)) + 1)).astype(int)
    found = []
    for a, b in pairwise(edges.tolist()):
        within = (series.index >= a) & ((series.index < b) | (b == steps))
        start = series.start
        if a and within.any():
            start = measured_state(series, problem.model, int(np.flatnonzero(within)[0]), start)
        found.append(
            replace(
                series,
                inputs=np.ascontiguousarray(series.inputs[a : b + 1]),
                outputs=series.outputs[within],
                index=series.index[within] - a,
                part=series.part[within],
                start=start,
            )
        )
    return found
