"""Training and held-out records with a model whose numbers move, and the errors of its free runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.problem import (
    THRUST,
    LocalChange,
    Problem,
    Run,
    pooled,
    problem,
    squares,
)
from ...estimation.records.gaps import unbroken
from ...models.errors import CannotFit
from ...models.model import CHANNELS
from ...models.time_scale import time_scale_s

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..prepared import Prepared
    from .attempts import Attempt

FEWEST = 3
"""Records that leaving one out needs; fewer are cut into pieces."""
USUAL, SHORTEST, MOST = 10.0, 3.5, 6
"""Usual and shortest piece of a record, in ship lengths sailed, and how many pieces there are of one at most."""


class Problems(NamedTuple):
    """Training and held-out records with the model."""

    train: Problem
    held_out: Problem | None

    def with_change(self, local: LocalChange | None) -> Problems:
        """The same with what differs in a regime."""
        held_out = None if self.held_out is None else replace(self.held_out, local=local)
        return Problems(replace(self.train, local=local), held_out)

    @property
    def runs(self) -> list[str]:
        """Names of all runs."""
        return [run.name for p in (self.train, self.held_out) if p is not None for run in p.runs]

    def with_runs(self, change: Callable[[Run], Run]) -> Problems:
        """The same with every run changed."""

        def changed(p: Problem) -> Problem:
            return replace(p, runs=tuple(map(change, p.runs)))

        return Problems(changed(self.train), None if self.held_out is None else changed(self.held_out))


def problems_of(whole: Model, records: Prepared, threads: int) -> Problems:
    """The records of a diagnosis as problems.

    Raises
    ------
    CannotFit : a record lacks what free runs need, or the records are too short to leave a part out.
    """
    held_out = problem(whole, unbroken(records.held_out, whole)) if records.held_out else None
    return Problems(problem(whole, _pieces(unbroken(records.train, whole), whole), threads), held_out)


def _pieces(records: Sequence[Record], model: Model) -> list[Record]:
    """The records, or equal pieces of them where there are fewer than FEWEST.

    Raises
    ------
    CannotFit : they are too short to be cut.
    """
    if len(records) >= FEWEST:
        return list(records)
    length_s, out = time_scale_s(model), []
    for record in records:
        lengths = float(record.time_s[-1] - record.time_s[0]) / length_s
        needed = min(math.ceil(FEWEST / len(records)), int(lengths / SHORTEST))
        parts = max(min(int(lengths / USUAL), MOST), needed, 1)
        edges = np.linspace(0, record.n, parts + 1).astype(int).tolist()
        cuts = [record.slice(a, b) for a, b in pairwise(edges)]
        out += [replace(cut, name=f"{record.name}, part {i + 1}") for i, cut in enumerate(cuts)]
    if len(out) < FEWEST:
        raise CannotFit(f"the records last less than {FEWEST * SHORTEST * length_s:.0f} s: no part can be left out")
    return out


def errors_of(on: Problems, attempt: Attempt) -> dict[str, tuple[float, float | None]]:
    """Column -> errors of left-out training records and of held-out records."""
    own = dict(zip(columns_of(on.train), pooled([x.free for x in attempt.left_out]).tolist(), strict=True))
    held: Mapping[str, float] = {}
    if on.held_out is not None:
        parts = [squares(on.held_out, attempt.fitted.theta, run) for run in on.held_out.runs]
        held = dict(zip(columns_of(on.held_out), pooled(parts).tolist(), strict=True))
    return {column: (value, held.get(column)) for column, value in own.items()}


def columns_of(p: Problem) -> list[str]:
    """Names of the columns that count."""
    return [c if c == THRUST else CHANNELS[c] for c in p.channels]
