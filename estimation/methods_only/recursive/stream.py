"""Recursive methods on a stream: chunks of a record are added one after the other, and the recursion continues.

A difference equation at the border of two chunks needs samples of both, so the last samples of a chunk are kept and
differenced again with the next chunk.  Every row is used once, and the trajectory is that of the whole record.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from ....datasets.record import Record
from ....models.errors import BadInput, CannotFit, FitFailed
from ....models.model import Model
from ...numerics import factors
from ...regression.samples import RegressionSamples
from ...regression.schemes import LOCAL, samples_of
from ...results.fit import SHORTEST, Fit, prepared
from . import recursion
from .recursion import RecursionPrior, RecursionState, UpdateRule, row_scales, scaled_rows

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
        self.n_samples, self.clock_s = 0, 0.0
        self._last_row, self._first_row = -np.inf, 0.0
        self._passed = 0.0
        self._tail: Record | None = None
        self._factor = factors.empty(len(model.coordinates))
        self._paths: deque[tuple[np.ndarray, np.ndarray]] = deque()
        if scale_with is not None:
            self._begin([samples_of(record, self.model, scheme) for record in prepared(scale_with, model)])

    def _begin(self, parts: Sequence[RegressionSamples]) -> RecursionState:
        scales = row_scales(parts, self.model, self.prior.kind)
        self.state = RecursionState(self.prior, scales, self.make_rule(parts))
        return self.state

    def add(self, chunk: Record) -> None:
        """Take the next samples.  A chunk that starts before the last one ended is the beginning of a new run."""
        if self._tail is not None and chunk.time_s[0] <= self._tail.time_s[-1]:
            self._passed, self._last_row, self._tail = self.clock_s, -np.inf, None
        joined = chunk if self._tail is None else _joined(self._tail, chunk)
        self._tail = joined.slice(-OVERLAP, None) if joined.n > OVERLAP else joined
        if joined.n < SHORTEST:
            return
        samples = samples_of(prepared([joined], self.model)[0], self.model, self.scheme)
        samples = samples.at(samples.time_s > self._last_row)
        if samples.time_s.size:
            self._take(samples)

    def _take(self, samples: RegressionSamples) -> None:
        state = self.state or self._begin([samples])
        if not np.isfinite(self._last_row):
            self._first_row = float(samples.time_s[0])
        paths = []
        for y, phi in samples.blocks(self.model):
            paths.append(state.add(y, phi))
            left, rows = scaled_rows(y, phi, state.scales)
            self._factor = factors.fold(self._factor, np.column_stack([rows, left]))
        self._last_row = float(samples.time_s[-1])
        time = self._passed + samples.time_s - self._first_row
        self.clock_s, self.n_samples = float(time[-1]), self.n_samples + samples.time_s.size
        self._keep(time, np.concatenate(paths))

    def _keep(self, time: np.ndarray, path: np.ndarray) -> None:
        """Add to the trajectory; its oldest pieces are dropped where it grows too long."""
        self._paths.append((time, path))
        while len(self._paths) > 1 and sum(piece.size for _, piece in self._paths) > recursion.LONGEST_PATH:
            self._paths.popleft()

    def fit(self) -> Fit:
        """The estimate so far.

        Raises
        ------
        CannotFit : there are not more rows than coefficients yet.
        FitFailed : the recursion is not finite any more.
        """
        p = len(self.model.coordinates)
        if self.state is None or self.n_samples * self.state.per_sample <= p:
            raise CannotFit(f"{self.n_samples} samples so far for {p} coefficients")
        if not np.isfinite(self.state.theta).all():
            raise FitFailed("the recursion has diverged")
        squares = float(((self._factor @ np.append(self.state.theta, -1.0)) ** 2).sum())
        return Fit(
            self.state.coefficients(),
            self.state.covariance(squares, self.n_samples * self.state.per_sample, self.n_samples),
            n_iterations=self.n_samples,
            trajectory=np.concatenate([path for _, path in self._paths]),
            trajectory_time_s=np.concatenate([time for time, _ in self._paths]),
        )


def _joined(first: Record, second: Record) -> Record:
    """Both records one after the other, with the second's rudder sign; channels that one of them lacks are left out."""
    if second.meta.positive_rudder is not None:
        first = first.turned(second.meta.positive_rudder)
    names = [name for name in second.channels if first.has(name)]
    channels = {name: np.concatenate([first.column(name), second.column(name)]) for name in names}
    return Record(np.concatenate([first.time_s, second.time_s]), channels, second.name, second.meta)
