"""Estimates of several models or methods side by side, and the chosen one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...models.extras import extras_told
from ...models.result import Result, above
from ..run.squares import Squares

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from ...models.model import Model
    from .estimate import Estimate


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
