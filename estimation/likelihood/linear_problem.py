"""A least-squares problem linearised about one point: damped steps on its triangular factor.

Many records have unknowns of their own (initial states) beside those that all share: the matrix of derivatives has the
form of an arrow.  The own unknowns of every record are eliminated by orthogonal transformations, so that time and
memory grow with the number of records, not with its cube and square.
Source: Golub & Pereyra 1973, SIAM J. Numer. Anal. 10, 413; Bjorck 1996, Numerical Methods for Least Squares Problems,
sec 6.3 (block angular form).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...models.linear_algebra import lstsq, matrix_rank, svd
from ..numerics import factors

NULL = 1e-12
"""Singular values (columns of unit length) below which a direction counts as not identified."""


class LinearProblem:
    """The weighted problem linearised about one point, in columns of unit length.

    factor (rows, width + 1) is the triangular factor of [derivatives | residuals]; length (width,) are the lengths of
    the columns where the factor does not hold all of their rows.
    """

    def __init__(self, factor: np.ndarray, length: np.ndarray | None = None) -> None:
        self.a, self.b = factor[:, :-1], factor[:, -1]
        self.length = factors.column_lengths(self.a) if length is None else length
        u, s, vt = svd(self.a / self.length, full_matrices=False)
        kept = s > NULL * s[0]
        self.singular, self.projected = s[kept], (u.T @ self.b)[kept]
        self.back = vt[kept].T / self.length[:, None]

    def step(self, damping: float) -> tuple[np.ndarray, float]:
        """The damped step (width,), and the decrease of half the sum of squares that it predicts."""
        left = damping / (self.singular**2 + damping)
        step = self.back @ (self.singular / (self.singular**2 + damping) * self.projected)
        return step, float(0.5 * np.sum(self.projected**2 * (1.0 - left**2)))

    def solved(self, gradient: np.ndarray, damping: float) -> np.ndarray:
        """The damped normal equations' solution (width,) for a right-hand side (width,)."""
        return self.back @ ((self.back.T @ gradient) / (self.singular**2 + damping))

    def step_within(self, damping: float, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, float]:
        """The same for a step between low and high (width,).

        Unknowns whose step would cross a bound are set on it, and the others are solved again.
        """
        inside = np.ones(self.length.size, bool)
        step = np.zeros(self.length.size)
        while inside.any():
            a = self.a[:, inside] / self.length[inside]
            rest = self.b - self.a[:, ~inside] @ step[~inside]
            damped = np.vstack([a, np.sqrt(damping) * np.eye(a.shape[1])])
            right = np.concatenate([rest, np.zeros(a.shape[1])])
            step[inside] = lstsq(damped, right, rcond=NULL) / self.length[inside]
            outside = inside & ((step < low) | (step > high))
            if not outside.any():
                break
            step[outside] = np.clip(step, low, high)[outside]
            inside &= ~outside
        return step, float(0.5 * (self.b @ self.b - np.sum((self.b - self.a @ step) ** 2)))


class Own(NamedTuple):
    """Rows of B records that hold their own f unknowns: triangle (B, f, f) of those, shared (B, f, n + 1) of the shared
    unknowns and the right side, places (B, f) of the own unknowns among all."""

    places: np.ndarray
    triangle: np.ndarray
    shared: np.ndarray


class RecordRows(NamedTuple):
    """Rows (m, f + n + 1) of one record: its own f unknowns, which begin at `place`, the shared n, the right side."""

    place: int
    free: int
    values: np.ndarray


@dataclass(frozen=True)
class Arrow:
    """The factor of [derivatives | residuals]: rows of the records' own unknowns, and one triangle (<= n + 1, n + 1)
    of the shared unknowns, which are the first n of all."""

    own: tuple[Own, ...]
    shared: np.ndarray

    @classmethod
    def of(cls, parts: Iterable[RecordRows], shared: np.ndarray) -> Arrow:
        """The factor of the rows of all records and of further rows (m, n + 1) in the shared unknowns."""
        alike: dict[int, list[RecordRows]] = {}
        for part in parts:
            alike.setdefault(part.free, []).append(part)
        own, rest = [], [shared]
        for free, group in alike.items():
            width = shared.shape[1] + free
            stacked = np.zeros((len(group), max(width, *(len(part.values) for part in group)), width))
            for place, part in zip(stacked, group, strict=True):
                place[: len(part.values)] = part.values
            triangle = np.asarray(np.linalg.qr(stacked, mode="r"))
            places = np.array([part.place for part in group])[:, None] + np.arange(free)
            own.append(Own(places, triangle[:, :free, :free], triangle[:, :free, free:]))
            rest.append(triangle[:, free:, free:].reshape(-1, width - free))
        return cls(tuple(own), factors.fold(factors.empty(shared.shape[1] - 1), np.vstack(rest)))

    @property
    def finite(self) -> bool:
        """Whether all numbers are."""
        return all(np.isfinite(part).all() for part in (self.shared, *(o.triangle for o in self.own)))

    @property
    def own_rank(self) -> int:
        """Number of directions of the own unknowns that the rows determine."""
        found = 0
        for own in self.own:
            length = factors.divisors(np.linalg.norm(own.triangle, axis=1))
            found += int(matrix_rank(own.triangle / length[:, None, :]).sum())
        return found


class LinearArrow:
    """As `LinearProblem`, for an arrow: steps are damped in columns of unit length."""

    def __init__(self, arrow: Arrow) -> None:
        self.arrow, self.n = arrow, arrow.shared.shape[1] - 1
        squares = (arrow.shared[:, :-1] ** 2).sum(axis=0)
        squares += sum((own.shared[:, :, :-1] ** 2).sum(axis=(0, 1)) for own in arrow.own)
        self.length = factors.divisors(np.sqrt(squares))
        self.lengths = [factors.divisors(np.linalg.norm(own.triangle, axis=1)) for own in arrow.own]
        self.width = self.n + sum(own.places.size for own in arrow.own)

    def step(self, damping: float) -> tuple[np.ndarray, float]:
        """The damped step (width,), and the decrease of half the sum of squares that it predicts."""
        open_ended = np.full(self.width, np.inf)
        return self.step_within(damping, -open_ended, open_ended)

    def step_within(self, damping: float, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, float]:
        """The same with the shared unknowns between low and high (width,)."""
        solved = [_eliminated(own, length, damping) for own, length in zip(self.arrow.own, self.lengths, strict=True)]
        rows = [self.arrow.shared, *(rest.reshape(-1, self.n + 1) for _, _, rest in solved)]
        reduced = LinearProblem(factors.fold(factors.empty(self.n), np.vstack(rows)), self.length)
        step = np.zeros(self.width)
        step[: self.n], _ = reduced.step_within(damping, low[: self.n], high[: self.n])
        moved, right = self.arrow.shared[:, :-1] @ step[: self.n], self.arrow.shared[:, -1]
        gain = 0.5 * float(moved @ (2.0 * right - moved))
        for own, length, (triangle, above, _) in zip(self.arrow.own, self.lengths, solved, strict=True):
            known = above[:, :, -1] - above[:, :, :-1] @ step[: self.n]
            found = np.linalg.solve(triangle, known[:, :, None])[:, :, 0] / length
            step[own.places] = found
            moved = (own.triangle @ found[:, :, None])[:, :, 0] + own.shared[:, :, :-1] @ step[: self.n]
            gain += 0.5 * float((moved * (2.0 * own.shared[:, :, -1] - moved)).sum())
        return step, gain


def _eliminated(own: Own, length: np.ndarray, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle (B, f, f) of the damped own unknowns in unit lengths, their rows (B, f, n + 1), and what is left of the
    shared unknowns (B, f, n + 1)."""
    count, free, width = own.shared.shape
    stacked = np.zeros((count, 2 * free, free + width))
    stacked[:, :free, :free], stacked[:, :free, free:] = own.triangle / length[:, None, :], own.shared
    stacked[:, free + np.arange(free), np.arange(free)] = np.sqrt(damping)
    found = np.asarray(np.linalg.qr(stacked, mode="r"))
    rest = np.zeros((count, free, width))
    rest[:, : found.shape[1] - free] = found[:, free:, free:]
    return found[:, :free, :free], found[:, :free, free:], rest
