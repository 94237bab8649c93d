"""Several models or methods on the same records, compared by free runs of records that took no part in the fit.

With records held out, every candidate is fitted once, to all training records.  Without, each training record is left
out in turn; a single record is cut into blocks of time instead.  The error of a candidate is the mean over channels of
sqrt(SSE/SST), pooled over the records that test it, in the channels that all candidates predict.  Among candidates
whose error is not larger than the least by more than the standard error of the difference over these records, the one
with the fewest coefficients is chosen.
Source of the rule: Hastie, Tibshirani & Friedman 2009, The Elements of Statistical Learning, sec 7.10.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...datasets.instruments import hull_record
from ...datasets.record import Record
from ...models import kernels
from ...models.errors import BadInput, CannotFit, FitFailed
from ...models.extras import extras_told
from ...models.model import Model, resolve
from ...models.result import Result, above
from ...models.vessel import vessel_files
from ..records.naming import named
from ..run.run import run_along
from ..run.squares import Squares
from ..validation.validate import TOGETHER
from .estimate import Estimate, published

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Candidate:
    """One model fitted by one method, and its free runs of the records that test it.

    estimate : fitted to all training records, None where that failed;  reason : why there is no error;  squares :
    record -> channel -> sums of squares;  diverged : records whose run diverges;  error : mean over channels of
    sqrt(SSE/SST), inf where a run diverges, nan where there is none;  errors : the same of each record, in units of
    the same spread.
    """

    model: Model
    method: str
    estimate: Estimate | None
    reason: str = ""
    squares: Mapping[str, Mapping[str, Squares]] | None = None
    diverged: tuple[str, ...] = ()
    wall_s: float = np.nan
    error: float = np.nan
    errors: tuple[float, ...] = ()

    @property
    def n_parameters(self) -> int:
        """Coefficients that were fitted; 0 for a black box."""
        return 0 if self.estimate is None else self.estimate.coefficients.size

    @property
    def n_penalised(self) -> float:
        """Coefficients, and more than any for a black box."""
        return np.inf if self.estimate is not None and self.estimate.predictor is not None else self.n_parameters

    def pooled(self, channel: str) -> Squares:
        """Sums of squares of a channel over the records that test the candidate."""
        total = Squares()
        for own in (self.squares or {}).values():
            total = total.plus(own.get(channel, Squares()))
        return total


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """Models or methods side by side, by free runs of records that took no part in the fit: `compare` makes it.

    candidates : in the order given, with estimate, error and time of each.

    basis : 'held out', 'records left out' or 'blocks left out';  tested : names of the records that test the
    candidates;  channels : those in which the errors are compared;  place : of the chosen candidate.
    """

    candidates: tuple[Candidate, ...]
    basis: str
    tested: tuple[str, ...]
    channels: tuple[str, ...]
    place: int
    room: ClassVar[str] = "identification.comparison"
    pictured: ClassVar[str] = "errors of the candidates"

    @property
    def chosen(self) -> Candidate:
        """The candidate with the smallest error, or a simpler one that does not differ from it."""
        return self.candidates[self.place]

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "basis": self.basis,
            "tested_on": list(self.tested),
            "channels": list(self.channels),
            "chosen": {"model": self.chosen.model.id, "method": self.chosen.method},
            "candidates": [self._row(one) for one in self.candidates],
        }

    def _row(self, one: Candidate) -> dict[str, Any]:
        scores = {c: one.pooled(c).scores() for c in self.channels} if one.squares else {}
        fitted = one.estimate
        return {
            "model": one.model.id,
            "method": one.method,
            "coefficients": one.n_parameters,
            "error": one.error,
            "rmse_free": {c: rmse for c, (rmse, _) in scores.items()},
            "r2_free": {c: r2 for c, (_, r2) in scores.items()},
            "diverged": list(one.diverged),
            "parameters": {} if fitted is None else fitted.parameters,
            "stderr": {} if fitted is None else fitted.stderr,
            "wall_s": one.wall_s,
            "reason": one.reason,
            "chosen": one is self.chosen,
        }

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """A row a candidate: model, method, coefficients, error, RMSE and R² of every channel, time and reason."""
        import pandas as pd

        rows = self.to_json()["candidates"]
        flat = ("model", "method", "coefficients", "error", "wall_s", "reason", "chosen")
        return pd.DataFrame(
            [
                {name: row[name] for name in flat}
                | {
                    f"{kind}_{channel}": row[kind].get(channel)
                    for kind in ("rmse_free", "r2_free")
                    for channel in self.channels
                }
                for row in rows
            ]
        )

    def plot(self) -> Figure:
        """Draw the error of every candidate on each record that tests it; a logarithmic axis.

        Returns
        -------
        A matplotlib figure, not attached to pyplot: save it with `savefig`.
        """
        return above("reporting.identification.comparison").comparison_figure(self)

    def __repr__(self) -> str:
        chosen = self.chosen
        return f"<Comparison of {len(self.candidates)}, {self.basis}: {chosen.model.id} by {chosen.method}>"


BLOCKS = 4
"""Blocks of time into which a single record is cut."""
HELD_OUT, RECORDS, TIME_BLOCKS = "held out", "records left out", "blocks left out"
Entrant = tuple["Model", str, Any]
"""A model, a method as text, and the method itself: `fit(records, model)`, which raises CannotFit and FitFailed."""


def compare(entrants: Sequence[Entrant], train: Sequence[Record], held_out: Sequence[Record] = ()) -> Comparison:
    """Fit all entrants to the training records and compare their free runs of records that took no part.

    Parameters
    ----------
    entrants : models and methods; one that does not apply or fails is kept with its reason.
    train, held_out : records as they were read.  Without held-out records the training records, or
        blocks of a single one, are left out in turn.

    Raises
    ------
    BadInput : there is no entrant or no training record, or a single training record is too short to be cut.
    CannotFit : no entrant can be fitted, or none predicts a channel that the records measure.
    """
    if not entrants or not train:
        raise BadInput("a comparison needs at least one candidate and one record")
    basis, folds = _folds(train, held_out)
    found = [_candidate(one, train, folds, refit=basis != HELD_OUT) for one in entrants]
    if not any(one.squares for one in found):
        raise CannotFit("; ".join(f"{one.model.id} by {one.method}: {one.reason}" for one in found))
    channels = _common(found)
    if not channels:
        raise CannotFit("no channel is predicted by all candidates")
    spread = {c: _spread(found, c) for c in channels}
    judged = tuple(_judged(one, channels, spread) for one in found)
    tested = tuple(record.name for _, kept in folds for record in kept)
    return Comparison(judged, basis, tested, channels, _choice(judged))


def _folds(train: Sequence[Record], held_out: Sequence[Record]) -> tuple[str, list[tuple[list[Record], list[Record]]]]:
    """The basis, and pairs of records to fit and records that test."""
    if held_out:
        return HELD_OUT, [(list(train), _distinct(held_out))]
    basis, parts = (RECORDS, _distinct(train)) if len(train) > 1 else (TIME_BLOCKS, _blocks(train[0]))
    return basis, [([*parts[:i], *parts[i + 1 :]], [part]) for i, part in enumerate(parts)]


def _distinct(records: Sequence[Record]) -> list[Record]:
    return [replace(record, name=name) for name, record in named(records).items()]


def _blocks(record: Record) -> list[Record]:
    edges = np.linspace(0, record.n, BLOCKS + 1).astype(int).tolist()
    if record.n < 16 * BLOCKS:
        hint = "give a second record, or records that are held out"
        raise BadInput(f"{record.n} samples cannot be cut into {BLOCKS} blocks", file=record.name, hint=hint)
    cuts = enumerate(pairwise(edges), 1)
    return [replace(record.slice(a, b), name=f"{record.name}, block {i}") for i, (a, b) in cuts]


def _candidate(
    one: Entrant, train: Sequence[Record], folds: Sequence[tuple[list[Record], list[Record]]], refit: bool
) -> Candidate:
    """The entrant fitted to all training records, and its runs of the records that test it.

    refit : whether it is fitted anew for each of them; otherwise no record that tests it is a training record.
    """
    model, method, _ = one
    estimate: Estimate | None = None
    squares: dict[str, dict[str, Squares]] = {}
    diverged: list[str] = []
    try:
        estimate = published(_fitted(one, train))
        for given, kept in folds:
            own = _fitted(one, given) if refit else estimate
            for record in kept:
                run = run_along(own.model, record, own.predictor)
                squares[record.name] = run.squares()
                diverged += [record.name] if run.diverged else []
    except (CannotFit, FitFailed) as error:
        wall_s = np.nan if estimate is None else estimate.wall_s
        return Candidate(model, method, estimate, error.reason, wall_s=wall_s)
    return Candidate(model, method, estimate, "", squares, tuple(diverged), estimate.wall_s)


def _fitted(one: Entrant, records: Sequence[Record]) -> Estimate:
    model, _, method = one
    return method.fit([hull_record(record, model) for record in records], model)


def _common(candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Channels that every candidate predicts in every record that tests it."""
    sets = [set(channels) for one in candidates for channels in (one.squares or {}).values()]
    shared = set.intersection(*sets) if sets else set()
    return tuple(channel for channel in TOGETHER if channel in shared)


def _spread(candidates: Sequence[Candidate], channel: str) -> float:
    """Mean square deviation of the measured samples: the same for all candidates."""
    total = next(one for one in candidates if one.squares).pooled(channel)
    return total.spread / max(total.n, 1)


def _judged(one: Candidate, channels: Sequence[str], spread: Mapping[str, float]) -> Candidate:
    if not one.squares:
        return one
    if one.diverged:
        return replace(one, error=np.inf, errors=tuple(np.inf for _ in one.squares), reason="diverges")

    def error(sums: Mapping[str, Squares]) -> float:
        known = [c for c in channels if spread[c] > 0.0 and sums[c].n]
        return float(np.mean([np.sqrt(sums[c].error / sums[c].n / spread[c]) for c in known])) if known else np.nan

    pooled = {c: one.pooled(c) for c in channels}
    return replace(one, error=error(pooled), errors=tuple(error(own) for own in one.squares.values()))


def _choice(judged: Sequence[Candidate]) -> int:
    """The place of the simplest candidate that does not differ from the best.

    Raises CannotFit where the runs of all candidates diverge.
    """
    finite = [i for i, one in enumerate(judged) if np.isfinite(one.error)]
    if not finite:
        raise CannotFit("the free runs of all candidates diverge")
    best = min(finite, key=lambda i: judged[i].error)
    equal = [i for i in finite if i == best or not _worse(judged[i], judged[best])]
    return min(equal, key=lambda i: (judged[i].n_penalised, judged[i].error))


def _worse(one: Candidate, best: Candidate) -> bool:
    """Whether the error is larger by more than the standard error of the difference over the records."""
    difference = np.subtract(one.errors, best.errors)
    if difference.size < 2:
        return True
    return bool(difference.mean() > difference.std(ddof=1) / np.sqrt(difference.size))


# ---- Which model structures can be tried on records.


def families_for(records: Sequence[Record]) -> list[Model]:
    """Families that need no constants of a ship, and the structures of vessels that the records name, blank.

    A 3-DOF model has lengths and masses in it: without a vessel there is none to try.
    """
    free = [resolve(name) for name, facts in kernels.catalogue().items() if not facts["constants"]]
    vessels = dict.fromkeys(record.meta.vessel for record in records if record.meta.vessel in vessel_files())
    named = [resolve(vessel) for vessel in vessels if vessel is not None]
    return [*free, *(model.blanked() for model in named if model.family not in {one.family for one in free})]
