"""Squared errors of one record's free run to second order in common numbers and the record's own effects.

From one set of derivatives follow the normal equations of every choice of numbers, and what each choice would leave of
the error: by algebra, without a further run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .problem import Squares

Block = tuple[np.ndarray, np.ndarray, np.ndarray]
"""One record's share of the normal equations (q, q), (q,), and how its own effects follow (k, q + 1)."""


@dataclass(frozen=True, eq=False)
class Tangent:
    """One record's errors (N, C), SI, with derivatives (N, C, q + k) by q common numbers and own effects (k,), taken or
    carried on to where it stands."""

    error: np.ndarray
    slopes: np.ndarray
    own: np.ndarray

    def of(self, pick: np.ndarray) -> Tangent:
        """The same for some of the common numbers, by place."""
        tail = np.arange(self.slopes.shape[2] - self.own.size, self.slopes.shape[2])
        return Tangent(self.error, self.slopes[:, :, np.concatenate([pick, tail])], self.own)

    def carried(self, error: np.ndarray, own: np.ndarray, step: np.ndarray, scale: np.ndarray) -> Tangent:
        """The tangent after a step (q,) of the common numbers, where errors are (N, C) and own effects (k,): the least
        change of the derivatives, in units of the scale (q + k,), that explains how the errors changed.

        Source: Broyden 1965, Mathematics of Computation 19, 577, eq. 4.5.
        """
        change = np.concatenate([step, own - self.own])
        weighted = change / scale**2
        length = float(change @ weighted)
        if length == 0.0:
            return Tangent(error, self.slopes, own)
        unexplained = (error - self.error - self.slopes @ change) / length
        return Tangent(error, self.slopes + unexplained[:, :, None] * weighted, own)

    def expansion(self, own_precision: np.ndarray) -> Expansion:
        """The squared errors that follow; what is not finite counts as zero."""
        columns = np.concatenate([self.slopes, self.error[:, :, None]], axis=2)
        seen = np.isfinite(self.error)
        known = np.where(np.isfinite(columns) & seen[:, :, None], columns, 0.0)
        by_channel = known.transpose(1, 2, 0)
        gram = by_channel @ by_channel.transpose(0, 2, 1)
        return Expansion(gram, seen.sum(axis=0), self.own, own_precision)


@dataclass(frozen=True, eq=False)
class Expansion:
    """One record's errors e + J x to first order in x = (q common numbers, k own effects), as sums over its samples.

    gram : (C, q + k + 1, q + k + 1) products of the columns of [J, e] by channel, SI.  count : (C,) known samples.
    own : (k,) the own effects where it was made; own_precision : (k,) of their prior.
    """

    gram: np.ndarray
    count: np.ndarray
    own: np.ndarray
    own_precision: np.ndarray

    def of(self, pick: np.ndarray) -> Expansion:
        """The same for some of the common numbers, by place."""
        tail = np.arange(self.gram.shape[1] - self.own.size - 1, self.gram.shape[1])
        kept = np.concatenate([pick, tail])
        return Expansion(self.gram[:, kept[:, None], kept], self.count, self.own, self.own_precision)

    def block(self, weight: float, sd: np.ndarray) -> Block:
        """Normal equations with the own effects eliminated.

        Eq. 3 of docs/mathematics/calibration.md.

        weight : independent values that the record amounts to.  sd (C,) : error sizes.
        """
        q = self.gram.shape[1] - self.own.size - 1
        weights = weight / np.maximum(self.count, 1) / sd**2
        whole = np.tensordot(weights, self.gram, axes=1)
        matrix, slope = whole[:-1, :-1], -whole[:-1, -1]
        inner = matrix[q:, q:] + np.diag(self.own_precision)
        pull = slope[q:] - self.own * self.own_precision
        follow = np.linalg.solve(inner, np.column_stack([matrix[q:, :q], pull]))
        return matrix[:q, :q] - matrix[:q, q:] @ follow[:, :q], slope[:q] - matrix[:q, q:] @ follow[:, q], follow

    def squares(self, step: np.ndarray, own: np.ndarray) -> Squares:
        """Squared errors after a step (q,) of the common numbers, with own effects (k,)."""
        x = np.concatenate([step, own - self.own, [1.0]])
        return Squares(np.maximum(np.einsum("i,cij,j->c", x, self.gram, x), 0.0), self.count)

    def adapted(self, step: np.ndarray, follow: np.ndarray) -> np.ndarray:
        """Own effects (k,) that go with a step (q,) of the common numbers; follow : as `block` gives it.

        Eq. 5 of docs/mathematics/calibration.md.
        """
        return self.own + follow[:, -1] - follow[:, :-1] @ step
