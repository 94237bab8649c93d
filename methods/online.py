"""Recursive methods on a stream: chunks of a record go in one after the other, and the recursion goes on.

A difference equation at the border of two chunks needs samples of both, so the last samples of a chunk are kept and
differenced again with the next; every row is used once, and the trajectory is that of the whole record.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.record import Record
from ..models.errors import BadInput
from . import factors
from .base import SHORTEST, CannotFit, Fit, FitFailed, prepared
from .regression import Differences, difference

if TYPE_CHECKING:
    from ..models.model import Model
    from .rls import Progress, Rls

OVERLAP = 8
"""Samples of a chunk that are kept: more than any difference scheme reaches over."""
LOCAL = ("forward", "midpoint", "heading-difference")
"""Schemes whose rows depend on neighbouring samples only."""


class Stream:
    """A recursion that is fed chunk by chunk.

    Parameters
    ----------
    method : rls or a relative; its options are read when the first rows come.
    model : the structure to identify.
    scale_with : records of an earlier run, from which the scaled prior takes its units; None: the first chunk that has
        usable rows.

    Raises
    ------
    BadInput : the method's scheme integrates over the whole record.
    """

    def __init__(self, method: Rls, model: Model, scale_with: Sequence[Record] | None = None) -> None:
        if method.scheme not in LOCAL:
            raise BadInput(f"scheme {method.scheme!r} needs the whole record", hint=f"online: {', '.join(LOCAL)}")
        self.method, self.model = method, model.blanked()
        self.progress: Progress | None = None
        self.seen, self.clock_s = 0, 0.0
        self._last_row, self._first_row = -np.inf, 0.0
        self._passed = 0.0
        self._tail: Record | None = None
        self._factor = factors.empty(len(model.coordinates))
        self._paths: deque[tuple[np.ndarray, np.ndarray]] = deque()
        if scale_with is not None:
            self._begin([difference(record, self.model, method.scheme) for record in prepared(scale_with, model)])

    def _begin(self, parts: Sequence[Differences]) -> Progress:
        from .rls import Progress, scales_of

        setting = self.method.setting_for(parts, len(self.model.coordinates))
        self.progress = Progress(setting, scales_of(parts, self.model, setting))
        return self.progress

    def add(self, chunk: Record) -> int:
        """Take the next samples; returns how many regression rows they completed.

        A chunk that starts before the last one ended is the beginning of a new run.
        """
        if self._tail is not None and chunk.time_s[0] <= self._tail.time_s[-1]:
            self._new_run()
        joined = chunk if self._tail is None else _joined(self._tail, chunk)
        self._tail = joined.slice(-OVERLAP, None) if joined.n > OVERLAP else joined
        if joined.n < SHORTEST:
            return 0
        part = difference(prepared([joined], self.model)[0], self.model, self.method.scheme)
        part = _after(part, self._last_row)
        if part.time_s.size:
            self._take(part)
        return part.time_s.size

    def _new_run(self) -> None:
        self._passed, self._last_row, self._tail = self.clock_s, -np.inf, None

    def _take(self, part: Differences) -> None:
        progress = self.progress or self._begin([part])
        if not np.isfinite(self._last_row):
            self._first_row = float(part.time_s[0])
        paths = []
        for y, phi in part.blocks(self.model):
            paths.append(progress.add(y, phi))
            self._factor = factors.fold(self._factor, progress.scaled(y, phi))
        self._last_row = float(part.time_s[-1])
        time = self._passed + part.time_s - self._first_row
        self.clock_s, self.seen = float(time[-1]), self.seen + part.time_s.size
        self._keep(time, np.concatenate(paths))

    def _keep(self, time: np.ndarray, path: np.ndarray) -> None:
        from .rls import LONGEST_PATH

        self._paths.append((time, path))
        while len(self._paths) > 1 and sum(piece.size for _, piece in self._paths) > LONGEST_PATH:
            self._paths.popleft()

    def fit(self) -> Fit:
        """The estimate so far.

        Raises
        ------
        CannotFit : there are not more rows than coefficients yet.
        FitFailed : the recursion is not finite any more.
        """
        from .rls import noise_factor

        p = len(self.model.coordinates)
        if self.progress is None or self.seen * self.progress.per_sample <= p:
            raise CannotFit(f"{self.seen} samples so far for {p} coefficients")
        if not np.isfinite(self.progress.theta).all():
            raise FitFailed("the recursion has diverged")
        rest = float(((self._factor @ np.append(self.progress.theta, -1.0)) ** 2).sum())
        noise = noise_factor(rest, self.seen * self.progress.per_sample, p, self.seen, self.progress.setting)
        return Fit(
            self.progress.coefficients(),
            self.progress.covariance(noise),
            n_iterations=self.seen,
            trajectory=np.concatenate([path for _, path in self._paths]),
            trajectory_time_s=np.concatenate([time for time, _ in self._paths]),
        )


def _joined(first: Record, second: Record) -> Record:
    """Both records one after the other, in the second's sign of the rudder; channels that one lacks are left out."""
    if second.meta.positive_rudder is not None:
        first = first.turned(second.meta.positive_rudder)
    names = [name for name in second.channels if first.has(name)]
    channels = {name: np.concatenate([first.column(name), second.column(name)]) for name in names}
    return Record(np.concatenate([first.time_s, second.time_s]), channels, second.name, second.meta)


def _after(part: Differences, time_s: float) -> Differences:
    new = part.time_s > time_s
    arrays = {name: np.ascontiguousarray(getattr(part, name)[new]) for name in ("states", "accelerations", "inputs")}
    return replace(part, time_s=part.time_s[new], **arrays)
