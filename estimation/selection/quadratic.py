"""Normal equations by unit (a record, or a piece of one), and what follows from them by algebra alone.

The errors of unit k in channel c about a point are linear in the numbers x that all units share and in the unit's own
effects z (its start, its neutral rudder angle):

    e_kc + J_kc x + L_kc z_k,        z_k ~ N(-z0_k, S^2) about the point z0_k,   x_j ~ N(-x0_j, sd_j^2)

All that is needed of them are the sums of products of columns over the samples, G_kc = [J L e]^T [J L e]: sums of
squares, normal equations at any size of the channels, eliminated own effects, left-out units and subsets of numbers
are algebra on them.
Source: block elimination as in mixed-effects models, Pinheiro and Bates 2000, section 2.2; leaving a unit out by
subtracting its block, Cook and Weisberg 1982, section 3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

ROUNDS = 8
"""Most times that numbers are put on their bounds and the rest is solved again."""


class Prior(NamedTuple):
    """Numbers under their priors: values now (p,), standard deviations (p,), and bounds (p,)."""

    values: np.ndarray
    sd: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def of(self, chosen: Sequence[int]) -> Prior:
        """Those of some numbers."""
        return Prior(*(part[list(chosen)] for part in self))


class Normal(NamedTuple):
    """Normal equations of each unit with its own effects eliminated.

    matrix (K, p, p), slope (K, p);  back (K, m, p + 1): own effects follow as back[:, -1] - back[:, :-1] x.
    """

    matrix: np.ndarray
    slope: np.ndarray
    back: np.ndarray

    def of(self, chosen: Sequence[int]) -> Normal:
        """Those of some numbers, the others at rest."""
        pick = np.asarray(chosen, int)
        back = self.back[:, :, [*chosen, self.back.shape[2] - 1]]
        return Normal(self.matrix[:, pick[:, None], pick], self.slope[:, pick], back)


@dataclass(frozen=True)
class Quadratic:
    """Sums of products of K units in C channels about a point, for p shared numbers and m own effects of each unit.

    Eq. 2 of docs/mathematics/pieces.md.

    gram (K, C, q, q) : q = p + m + 1: of the numbers' columns, those of the own effects, and the errors.
    weight (K,) or (K, C) : independent values that a sample counts as.  own (K, m), own_sd (m,) : own effects at the
    point and their prior standard deviations.
    """

    gram: np.ndarray
    weight: np.ndarray
    own: np.ndarray
    own_sd: np.ndarray

    @property
    def n_own(self) -> int:
        """m."""
        return self.own_sd.size

    @property
    def n_numbers(self) -> int:
        """p."""
        return self.gram.shape[2] - 1 - self.n_own

    @cached_property
    def _places(self) -> tuple[slice, slice]:
        return slice(0, self.n_numbers), slice(self.n_numbers, self.n_numbers + self.n_own)

    def normal(self, size: np.ndarray, weight: np.ndarray | None = None) -> Normal:
        """Normal equations where channel c has independent errors of standard deviation size (C,); weight : another
        one.

        Eq. 5 of docs/mathematics/pieces.md.
        """
        numbers, own = self._places
        weight = self.weight if weight is None else weight
        each = np.broadcast_to(weight.reshape(len(weight), -1), self.gram.shape[:2])
        whole = np.einsum("kcij,c,kc->kij", self.gram, size**-2.0, each)
        inner = whole[:, own, own] + np.diag(self.own_sd**-2.0)
        pull = -whole[:, own, -1] - self.own * self.own_sd**-2.0
        mixed = whole[:, own, numbers]
        back = np.linalg.solve(inner, np.concatenate([mixed, pull[:, :, None]], axis=2))
        across = np.swapaxes(mixed, 1, 2)
        matrix = whole[:, numbers, numbers] - across @ back[:, :, :-1]
        return Normal(matrix, -whole[:, numbers, -1] - (across @ back[:, :, -1:])[:, :, 0], back)

    def squares(self, step: np.ndarray, own: np.ndarray, chosen: Sequence[int]) -> np.ndarray:
        """Sums of squared errors (K, C) after steps of the chosen numbers, (K, k), and of the own effects (K, m)."""
        places = [*chosen, *range(self.n_numbers, self.gram.shape[2])]
        whole = np.concatenate([step, own, np.ones((len(own), 1))], axis=1)
        picked = self.gram[:, :, np.array(places)[:, None], places]
        return np.maximum(np.sum((picked @ whole[:, None, :, None])[..., 0] * whole[:, None], axis=2), 0.0)

    def left_out(self, normal: Normal, chosen: Sequence[int], prior: Prior) -> np.ndarray:
        """Sums of squared errors (K, C) of each unit by the fit of the chosen numbers to all other units.

        normal : all numbers' equations.  prior : of the chosen ones.  The unit's own effects are fitted to it.
        """
        equations = normal.of(chosen)
        steps = left_out_steps(equations, prior)
        return self.squares(steps, own_step(equations, steps), chosen)


def own_step(normal: Normal, steps: np.ndarray) -> np.ndarray:
    """Steps (K, m) of the own effects that follow from steps (K, k) of the numbers."""
    return normal.back[:, :, -1] - (normal.back[:, :, :-1] @ steps[:, :, None])[:, :, 0]


def joint(normal: Normal, prior: Prior) -> tuple[np.ndarray, np.ndarray]:
    """Matrix (k, k) and slope (k,) of all units together with the priors, eq. 6 of docs/mathematics/pieces.md."""
    matrix = normal.matrix.sum(axis=0) + np.diag(prior.sd**-2.0)
    return matrix, normal.slope.sum(axis=0) - prior.values * prior.sd**-2.0


def own_information(normal: Normal, prior: Prior, n_held: int) -> float:
    """Largest share of the information on a number behind the first n_held ones that these, free under their priors,
    leave of it: 0 where they take its place."""
    matrix = normal.matrix.sum(axis=0)
    held, new = slice(0, n_held), slice(n_held, None)
    across = matrix[held, new]
    left = matrix[new, new] - across.T @ np.linalg.solve(matrix[held, held] + np.diag(prior.sd[held] ** -2.0), across)
    whole = np.diag(matrix[new, new])
    return float(np.max(np.divide(np.diag(left), whole, out=np.zeros_like(whole), where=whole > 0.0), initial=0.0))


def left_out_steps(normal: Normal, prior: Prior) -> np.ndarray:
    """Steps (K, k) of the numbers by the fits without each unit, within their bounds.

    Eq. 7 of docs/mathematics/pieces.md.
    """
    matrix, slope = joint(normal, prior)
    steps = np.linalg.solve(matrix - normal.matrix, (slope - normal.slope)[:, :, None])[:, :, 0]
    low, high = prior.low - prior.values, prior.high - prior.values
    for k in np.flatnonzero(np.any((steps < low) | (steps > high), axis=1)):
        steps[k] = bounded_solve(matrix - normal.matrix[k], slope - normal.slope[k], low, high)
    return steps


def bounded_solve(matrix: np.ndarray, slope: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The step (k,) of normal equations within bounds: numbers beyond a bound are put on it, and the rest is solved
    again."""
    step, free = np.zeros(slope.size), np.ones(slope.size, bool)
    for _ in range(ROUNDS):
        if free.any():
            rest = slope[free] - matrix[np.ix_(free, ~free)] @ step[~free]
            step[free] = np.linalg.solve(matrix[np.ix_(free, free)], rest)
        beyond = free & ((step < low) | (step > high))
        if not beyond.any():
            break
        step[beyond] = np.clip(step[beyond], low[beyond], high[beyond])
        free &= ~beyond
    return np.clip(step, low, high)
