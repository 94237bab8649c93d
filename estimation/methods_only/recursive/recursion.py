"""Recursive least squares over the rows of records: prior, scaling, the recursion itself and its covariance.

The coefficients theta and their covariance P are updated sample by sample.  How one sample changes them is an
`UpdateRule`; the rules of the multi-innovation and iterative-learning methods stand with these methods.

On a stream, chunks of a record are added one after the other, and the recursion continues.  A difference equation at
the border of two chunks needs samples of both, so the last samples of a chunk are kept and differenced again with the
next chunk.  Every row is used once, and the trajectory is that of the whole record.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ....datasets.record import Record
from ....models.errors import BadInput, CannotFit, FitFailed
from ....models.model import Model
from ...numerics import factors
from ...regression.samples import RegressionSamples
from ...regression.schemes import LOCAL, samples_of
from ...results.fit import LONGEST_PATH, SHORTEST, Fit, prepared

PRIORS = ("scaled", "physical")


class RecursionPrior(NamedTuple):
    """Initial coefficients theta0 (p,) and initial P = p0 I.

    `kind` says where P is p0 I: 'scaled', where every column of the regression and every equation has unit root mean
    square, or 'physical', in the model's coordinates and the rows as they are.
    """

    p0: float
    theta0: np.ndarray
    kind: str = "scaled"


def prior_of(p0: float, theta0, kind: str, p: int) -> RecursionPrior:
    """The prior that options state for p coefficients; theta0 is one number for all or (p,) numbers.

    Raises
    ------
    CannotFit : theta0 has another number of values.
    """
    values = np.asarray(theta0, float)
    if values.shape not in ((), (p,)):
        raise CannotFit(f"theta0 has {values.size} numbers for {p} coefficients")
    return RecursionPrior(float(p0), np.broadcast_to(values, (p,)), kind)


class UpdateRule:
    """How scalar rows change the coefficients and P."""

    plain_covariance: bool = False
    """Whether the rule works on P itself instead of its factors."""
    forgetting: float = 1.0
    """Forgetting factor of one sample, 1 for none."""
    repetitions: float = 1.0
    """How often a row has been used on average: P is so many times smaller than the covariance."""

    def run(
        self,
        y: np.ndarray,
        h: np.ndarray,
        per_sample: int,
        theta: np.ndarray,
        factor: np.ndarray,
        diagonal: np.ndarray,
        path: np.ndarray,
    ) -> None:
        """Go through scalar rows y (M,), h (M, p), `per_sample` of them to a sample, updating the rest in place.

        theta (p,); P = U diag(diagonal) U' with factor = U' (p, p), or P itself in `factor` if `plain_covariance`;
        path (M, p) takes theta after each row.
        """
        raise NotImplementedError(f"{type(self).__name__} does not implement run()")


class LeastSquaresRule(UpdateRule):
    """Weighted least squares with forgetting (paper 000, eq 22).

    mu is the forgetting factor of one sample and weight the constant weight L(k); with `as_printed` the equation is
    taken literally.
    """

    def __init__(self, mu: float = 1.0, weight: float = 1.0, as_printed: bool = False) -> None:
        self.forgetting, self.repetitions, self.plain_covariance = mu, weight, as_printed

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        from ._kernels import recursive_ls

        forget, weight = np.ones(len(y)), self.repetitions
        forget[::per_sample] = self.forgetting
        if not self.plain_covariance:
            recursive_ls(y, h, forget, weight, theta, factor, diagonal, path)
            return
        for k, (row, mu) in enumerate(zip(h, forget, strict=True)):
            moved, predicted = factor @ row, row @ theta / mu
            factor[:] = factor / mu - np.outer(moved, moved) / (mu * mu / weight + mu * (row @ moved))
            theta[:] = theta / mu + weight * (y[k] - predicted) * (factor @ row)
            path[k] = theta


class RowScales(NamedTuple):
    """Root mean squares of the rows' left sides (k,) and of the columns (p,), and the number of samples.

    Zeros are replaced by one; an equation without unknowns has an infinite scale.
    """

    equations: np.ndarray
    columns: np.ndarray
    n: int


def row_scales(parts: Sequence[RegressionSamples], model: Model, kind: str) -> RowScales:
    """Scales of the rows of all parts for a prior of that kind.

    Raises
    ------
    FitFailed : no column is finite and non-zero.
    """
    left, columns, n = 0.0, 0.0, 0
    for y, phi in _blocks(parts, model):
        left, columns, n = left + (y**2).sum(axis=0), columns + (phi**2).sum(axis=0), n + len(y)
    equations = np.sqrt(np.asarray(left) / n)
    used = (np.asarray(columns) > 0.0).any(axis=1) & (equations > 0.0)
    if not used.any() or not np.isfinite(columns).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    if kind == "physical":
        equations = np.ones_like(equations)
    equations = np.where(used, equations, np.inf)  # an equation without unknowns is left out
    total = np.sqrt((np.asarray(columns) / n / equations[:, None] ** 2).sum(axis=0))
    return RowScales(equations, np.where(total > 0.0, total, 1.0), n)


def _blocks(parts: Sequence[RegressionSamples], model: Model) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for part in parts:
        yield from part.blocks(model)


def scaled_rows(y: np.ndarray, phi: np.ndarray, scales: RowScales) -> tuple[np.ndarray, np.ndarray]:
    """Scalar rows y (M,), h (M, p) in scaled units of samples y (n, k), phi (n, k, p)."""
    used = np.flatnonzero(np.isfinite(scales.equations))
    rows = (phi[:, used] / scales.equations[used, None] / scales.columns).reshape(-1, phi.shape[2])
    return np.ascontiguousarray((y / scales.equations)[:, used].ravel()), np.ascontiguousarray(rows)


class RecursionState:
    """A recursion in progress: coefficients and P in scaled units, and the trajectory.

    Batch and online use go through the same steps: `take` the samples, then `fit`.  Every `stride`-th sample is kept in
    the trajectory, the last of those that the scales are of among them.
    """

    def __init__(self, prior: RecursionPrior, scales: RowScales, rule: UpdateRule, stride: int = 1) -> None:
        self.scales, self.rule, self.stride = scales, rule, stride
        p = scales.columns.size
        self.theta = np.ascontiguousarray(prior.theta0 * scales.columns)
        self.diagonal = np.full(p, prior.p0)
        if prior.kind == "physical":
            self.diagonal = self.diagonal * scales.columns**2
        self.factor = np.diag(self.diagonal) if rule.plain_covariance else np.eye(p)
        self.per_sample = int(np.isfinite(scales.equations).sum())
        self.n_samples, self.clock_s = 0, 0.0
        self._residuals = factors.empty(p)
        self._paths: deque[tuple[np.ndarray, np.ndarray]] = deque()

    def add(self, y: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """Coefficients (n, p) after each of n samples y (n, k), phi (n, k, p)."""
        left, rows = scaled_rows(y, phi, self.scales)
        path = np.empty_like(rows)
        self.rule.run(left, rows, self.per_sample, self.theta, self.factor, self.diagonal, path)
        self._residuals = factors.fold(self._residuals, np.column_stack([rows, left]))
        return path[self.per_sample - 1 :: self.per_sample] / self.scales.columns

    def take(self, samples: RegressionSamples, model: Model, begin_s: float) -> None:
        """Go through samples whose time (N,) counts from `begin_s`; the oldest pieces of a trajectory that grows too
        long are dropped."""
        if not samples.time_s.size:
            return
        path = np.concatenate([self.add(y, phi) for y, phi in samples.blocks(model)])
        time = self.clock_s + samples.time_s - begin_s
        kept = slice((self.scales.n - 1 - self.n_samples) % self.stride, None, self.stride)
        self._paths.append((time[kept], path[kept].copy()))
        self.n_samples += len(path)
        while self.stride == 1 and len(self._paths) > 1 and sum(one.size for _, one in self._paths) > LONGEST_PATH:
            self._paths.popleft()

    def fit(self) -> Fit:
        """The estimate so far.

        P becomes a covariance by the residual variance, the repetitions of a row, and the loss of data by forgetting.
        """
        mu, n, count = self.rule.forgetting, self.n_samples, self.n_samples * self.per_sample
        squares = float(((self._residuals @ np.append(self.theta, -1.0)) ** 2).sum())
        forgotten = 1.0 if mu == 1.0 else (1.0 - mu ** (2 * n)) / ((1.0 - mu**n) * (1.0 + mu))
        noise = squares / max(count - self.theta.size, 1) * self.rule.repetitions * forgotten
        covariance = self.factor if self.rule.plain_covariance else (self.factor.T * self.diagonal) @ self.factor
        return Fit(
            self.theta / self.scales.columns,
            covariance * noise / np.outer(self.scales.columns, self.scales.columns),
            n_iterations=n,
            trajectory=np.concatenate([path for _, path in self._paths]),
            trajectory_time_s=np.concatenate([time for time, _ in self._paths]),
        )


def recursion(parts: Sequence[RegressionSamples], model: Model, prior: RecursionPrior, rule: UpdateRule) -> Fit:
    """Go through all samples once, record after record; P and the coefficients are carried over.

    g = P h/(mu/L + h'P h);  theta += g (y - h'theta);  P = (P - g h'P)/mu  for each scalar row (paper 000, eq 22 with
    its erratum), or whatever the rule does instead.  Regressors are scaled inside.

    Raises
    ------
    FitFailed : no column is finite and non-zero.
    """
    scales = row_scales(parts, model, prior.kind)
    state = RecursionState(prior, scales, rule, max(1, -(-scales.n * scales.columns.size // LONGEST_PATH)))
    for part in parts:
        if part.time_s.size:
            state.take(part, model, float(part.time_s[0]))
            state.clock_s += float(np.ptp(part.time_s))
    return state.fit()


OVERLAP = 8
"""Samples of a chunk that are kept: more than any difference scheme uses for one row."""


class RecordStream:
    """A recursion that takes records chunk by chunk.

    Parameters
    ----------
    model : the structure to identify.
    scheme : difference scheme of `regression.schemes`.
    prior : initial coefficients and P.
    make_rule : makes the update rule from the first samples.
    scale_with : records of an earlier run, from which the scaled prior takes its units; None: the first chunk that has
        usable rows.

    Raises
    ------
    BadInput : the scheme integrates over the whole record.
    """

    def __init__(
        self,
        model: Model,
        scheme: str,
        prior: RecursionPrior,
        make_rule: Callable[[Sequence[RegressionSamples]], UpdateRule],
        scale_with: Sequence[Record] | None = None,
    ) -> None:
        if scheme not in LOCAL:
            raise BadInput(f"scheme {scheme!r} needs the whole record", hint=f"online: {', '.join(LOCAL)}")
        self.model, self.scheme, self.prior, self.make_rule = model.blanked(), scheme, prior, make_rule
        self.state: RecursionState | None = None
        self._last_row, self._first_row = -np.inf, 0.0
        self._tail: Record | None = None
        if scale_with is not None:
            self._begin([samples_of(record, self.model, scheme) for record in prepared(scale_with, model)])

    def _begin(self, parts: Sequence[RegressionSamples]) -> RecursionState:
        scales = row_scales(parts, self.model, self.prior.kind)
        self.state = RecursionState(self.prior, scales, self.make_rule(parts))
        return self.state

    def add(self, chunk: Record) -> None:
        """Take the next samples.  A chunk that starts before the last one ended is the beginning of a new run."""
        if self._tail is not None and chunk.time_s[0] <= self._tail.time_s[-1]:
            if self.state is not None and np.isfinite(self._last_row):
                self.state.clock_s += self._last_row - self._first_row
            self._last_row, self._tail = -np.inf, None
        joined = chunk if self._tail is None else _joined(self._tail, chunk)
        self._tail = joined.slice(-OVERLAP, None) if joined.n > OVERLAP else joined
        if joined.n < SHORTEST:
            return
        samples = samples_of(prepared([joined], self.model)[0], self.model, self.scheme)
        samples = samples.at(samples.time_s > self._last_row)
        if samples.time_s.size:
            if not np.isfinite(self._last_row):
                self._first_row = float(samples.time_s[0])
            (self.state or self._begin([samples])).take(samples, self.model, self._first_row)
            self._last_row = float(samples.time_s[-1])

    def fit(self) -> Fit:
        """The estimate so far.

        Raises
        ------
        CannotFit : there are not more rows than coefficients yet.
        FitFailed : the recursion is not finite any more.
        """
        p, n = len(self.model.coordinates), 0 if self.state is None else self.state.n_samples
        if self.state is None or n * self.state.per_sample <= p:
            raise CannotFit(f"{n} samples so far for {p} coefficients")
        if not np.isfinite(self.state.theta).all():
            raise FitFailed("the recursion has diverged")
        return self.state.fit()


def _joined(first: Record, second: Record) -> Record:
    """Both records one after the other, with the second's rudder sign; channels that one of them lacks are left out."""
    if second.meta.positive_rudder is not None:
        first = first.turned(second.meta.positive_rudder)
    names = [name for name in second.channels if first.has(name)]
    channels = {name: np.concatenate([first.column(name), second.column(name)]) for name in names}
    return Record(np.concatenate([first.time_s, second.time_s]), channels, second.name, second.meta)
