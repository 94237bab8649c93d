"""Recursive least squares, and the machinery that its weighted and forgetting relatives share."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Estimate, Fit, FitFailed, Method, blas_limited
from .ls import check_scheme
from .regression import Differences, differences
from .tuning.space import Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .online import Stream

LONGEST_PATH = 20_000_000
"""Numbers above which the kept trajectory is thinned to every second, third, ... sample."""
PRIORS = ("scaled", "physical")


@dataclass(frozen=True)
class Setting:
    """Numbers of the recursion.

    p0 is the initial P = p0 I and theta0 (p,) the initial coefficients; mu the forgetting factor of one sample, weight
    the constant L(k) of paper 000.  `prior` says where P is p0 I: 'scaled', where every column of the regression and
    every equation has unit root mean square, or 'physical', in the model's coordinates and the rows as they are.
    """

    p0: float
    theta0: np.ndarray
    mu: float = 1.0
    weight: float = 1.0
    prior: str = "scaled"
    as_printed: bool = False

    def run(self, rows, per_sample: int, theta, state, spread, path) -> None:
        """Go through scalar rows (y (M,), h (M, p), forget (M,)), `per_sample` to a sample, updating the rest in place.

        theta (p,); P = U diag(spread) U' with state = U' (p, p), or as printed P itself in state; path (M, p).
        """
        from . import _rls_kernels

        y, h, forget = rows
        if self.as_printed:
            _rls_kernels.recursive_ls_as_printed(y, h, forget, self.weight, theta, state, path)
        else:
            _rls_kernels.recursive_ls(y, h, forget, self.weight, theta, state, spread, path)

    def times(self) -> float:
        """How often a row has been taken on average: P is so many times smaller than the covariance."""
        return self.weight


class Recursion(NamedTuple):
    """Outcome of `recursion`, in the units of the coefficients."""

    coefficients: np.ndarray
    covariance: np.ndarray
    path: np.ndarray
    time_s: np.ndarray


class Scales(NamedTuple):
    """Root mean squares of the rows' left sides (k,) and of the columns (p,); zeros replaced by one."""

    equations: np.ndarray
    columns: np.ndarray
    n: int


def scales_of(parts: Sequence[Differences], model: Model, setting: Setting) -> Scales:
    """Scales of the rows of all parts; FitFailed if no column is finite and non-zero."""
    left, columns, n = 0.0, 0.0, 0
    for y, phi in _blocks(parts, model):
        left, columns, n = left + (y**2).sum(axis=0), columns + (phi**2).sum(axis=0), n + len(y)
    equations = np.sqrt(np.asarray(left) / n)
    used = (np.asarray(columns) > 0.0).any(axis=1) & (equations > 0.0)
    if not used.any() or not np.isfinite(columns).all():
        raise FitFailed("the regression has no finite, non-zero columns")
    if setting.prior == "physical":
        equations = np.ones_like(equations)
    equations = np.where(used, equations, np.inf)  # an equation without unknowns drops out
    total = np.sqrt((np.asarray(columns) / n / equations[:, None] ** 2).sum(axis=0))
    return Scales(equations, np.where(total > 0.0, total, 1.0), n)


def _blocks(parts: Sequence[Differences], model: Model) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    for part in parts:
        yield from part.blocks(model)


def _scaled_rows(y: np.ndarray, phi: np.ndarray, scales: Scales, mu: float):
    """Scalar rows y (M,), h (M, p), and the forgetting before each: mu at the first equation of a sample."""
    used = np.flatnonzero(np.isfinite(scales.equations))
    rows = (phi[:, used] / scales.equations[used, None] / scales.columns).reshape(-1, phi.shape[2])
    forget = np.ones((len(y), used.size))
    forget[:, 0] = mu
    return np.ascontiguousarray((y / scales.equations)[:, used].ravel()), np.ascontiguousarray(rows), forget.ravel()


class Progress:
    """A recursion under way: coefficients and P in scaled units, and the path so far.

    `add` takes more samples.  Batch and online use go through the same steps.
    """

    def __init__(self, setting: Setting, scales: Scales) -> None:
        self.setting, self.scales = setting, scales
        p = scales.columns.size
        self.theta = np.ascontiguousarray(setting.theta0 * scales.columns)
        self.spread = np.full(p, setting.p0)
        if setting.prior == "physical":
            self.spread = self.spread * scales.columns**2
        self.state = np.diag(self.spread) if setting.as_printed else np.eye(p)
        self.per_sample = int(np.isfinite(scales.equations).sum())

    def add(self, y: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """Coefficients (n, p) after each of n samples y (n, k), phi (n, k, p)."""
        rows = _scaled_rows(y, phi, self.scales, self.setting.mu)
        path = np.empty_like(rows[1])
        self.setting.run(rows, self.per_sample, self.theta, self.state, self.spread, path)
        return path[self.per_sample - 1 :: self.per_sample] / self.scales.columns

    def scaled(self, y: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """Scalar rows [phi | y] (n k, p + 1) as the recursion takes them."""
        left, rows, _ = _scaled_rows(y, phi, self.scales, 1.0)
        return np.column_stack([rows, left])

    def coefficients(self) -> np.ndarray:
        """The latest coefficients (p,)."""
        return self.theta / self.scales.columns

    def covariance(self, noise: float) -> np.ndarray:
        """Covariance (p, p) for rows whose variance makes up the factor `noise`."""
        covariance = self.state if self.setting.as_printed else (self.state.T * self.spread) @ self.state
        return covariance * noise / np.outer(self.scales.columns, self.scales.columns)


def recursion(parts: Sequence[Differences], model: Model, setting: Setting) -> Recursion:
    """Run through all samples once, record after record, P and the coefficients carried over.

    g = P h/(mu/L + h'P h);  theta += g (y - h'theta);  P = (P - g h'P)/mu  for each scalar row (paper 000, eq 22 with
    its erratum), or eq 22 as printed, or what else the setting runs.  Regressors are scaled inside.
    """
    scales = scales_of(parts, model, setting)
    progress = Progress(setting, scales)
    stride = max(1, -(-scales.n * scales.columns.size // LONGEST_PATH))
    paths, seen = [], 0
    for y, phi in _blocks(parts, model):
        path = progress.add(y, phi)
        picked = np.arange((scales.n - 1 - seen) % stride, len(y), stride)  # the last sample is among them
        paths.append(path[picked])
        seen += len(y)
    noise = _noise(parts, model, scales, progress.theta, setting)
    clock = _clock(parts)[(scales.n - 1) % stride :: stride]
    return Recursion(progress.coefficients(), progress.covariance(noise), np.concatenate(paths), clock)


def _noise(parts, model, scales: Scales, theta: np.ndarray, setting: Setting) -> float:
    """Factor that turns P into a covariance: residual variance times L, and the loss of data by forgetting."""
    total, count = 0.0, 0
    for y, phi in _blocks(parts, model):
        left, rows, _ = _scaled_rows(y, phi, scales, 1.0)
        total, count = total + float(((left - rows @ theta) ** 2).sum()), count + left.size
    return noise_factor(total, count, theta.size, scales.n, setting)


def noise_factor(total: float, count: int, p: int, n: int, setting: Setting) -> float:
    """As `_noise`, from the sum of squares `total` that `count` scalar rows of n samples leave with p coefficients."""
    mu = setting.mu
    forgotten = 1.0 if mu == 1.0 else (1.0 - mu ** (2 * n)) / ((1.0 - mu**n) * (1.0 + mu))
    return total / max(count - p, 1) * setting.times() * forgotten


def _clock(parts: Sequence[Differences]) -> np.ndarray:
    """Seconds of record seen at each row, counted on from record to record."""
    clock, passed = [], 0.0
    for part in parts:
        if part.time_s.size:
            clock.append(passed + part.time_s - part.time_s[0])
            passed = clock[-1][-1]
    return np.concatenate(clock)


class Rls(Method):
    """Plain recursive least squares.

    Parameters
    ----------
    p0 : initial P = p0 I, in the coordinates that `prior` names.
    theta0 : initial coefficients, one number for all or (p,) numbers.
    prior : 'scaled' (every regressor column and equation of unit root mean square) or 'physical' (the model's
        coordinates and unscaled rows, as paper 000 has it).
    scheme : difference scheme, see `regression`.

    Several records are run through one after the other; P and the coefficients are carried over.
    """

    name = "rls"
    title = "recursive least squares"
    search_space: ClassVar = {"p0": Real(1e-2, 1e12, log=True)}
    order_matters = True
    _stream: Stream | None = None

    def __init__(self, p0: float = 1e10, theta0=0.0, prior: str = "scaled", scheme: str = "forward") -> None:
        self.p0, self.theta0, self.prior, self.scheme = p0, theta0, prior, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if not self.p0 > 0.0:
            raise BadInput(f"p0 is {self.p0!r}, a positive number is needed")
        if self.prior not in PRIORS:
            raise BadInput(f"prior is {self.prior!r}", hint=f"known: {', '.join(PRIORS)}")

    def setting(self, p: int) -> Setting:
        """Numbers of the recursion for p coefficients."""
        return Setting(self.p0, self._theta0(p), prior=self.prior)

    def setting_for(self, parts: Sequence[Differences], p: int) -> Setting:
        """As `setting`, for methods whose numbers depend on the rows."""
        return self.setting(p)

    def _theta0(self, p: int) -> np.ndarray:
        theta0 = np.asarray(self.theta0, float)
        if theta0.shape not in ((), (p,)):
            raise CannotFit(f"theta0 has {theta0.size} numbers for {p} coefficients")
        return np.broadcast_to(theta0, (p,))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        parts = differences(records, model, self.scheme)
        found = recursion(parts, model, self.setting_for(parts, len(model.coordinates)))
        return Fit(
            found.coefficients,
            found.covariance,
            n_iterations=sum(len(part.time_s) for part in parts),
            trajectory=found.path,
            trajectory_time_s=found.time_s,
        )

    def partial_fit(self, chunk: Record, model: Model, scale_with: Sequence[Record] | None = None) -> Estimate | None:
        """Take the next samples of a stream and return the estimate so far; None while there are too few.

        Chunks of any length give the trajectory of the whole record: exactly with `prior='physical'`, or with
        `scale_with` that record; otherwise the scaled prior has the units of the first chunk.  A chunk that starts
        before the last one ended begins a new run.  `reset` forgets everything; another model does so too.

        Raises
        ------
        CannotFit : a channel is missing.
        FitFailed : the recursion has diverged.
        BadInput : an option is impossible, or the scheme needs the whole record.
        """
        from .online import Stream

        if self._stream is None or self._stream.model.id != model.id:
            self.check_options()
            self._stream = Stream(self, model, scale_with)
        wall, cpu = time.perf_counter(), time.process_time()
        with np.errstate(all="ignore"), blas_limited():
            self._stream.add(chunk)
            try:
                fit = self._stream.fit()
            except CannotFit:
                return None
        return self._wrap(fit, model, time.perf_counter() - wall, time.process_time() - cpu)

    def reset(self) -> None:
        """Forget the stream of `partial_fit`."""
        self._stream = None
