"""Does the best grey box beat the best black box in free runs?  A paired test over vessels and conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .paired import signed_rank
from .standings import CELL

if TYPE_CHECKING:
    import pandas as pd

METRIC = "rmse_free_yaw_rate_rad_s"
FEWEST = 6
"""Pairs below which a Wilcoxon test cannot become significant at 5 %."""
LARGEST_RATIO = 1e6
"""Ratio that stands for one method of a pair failing or diverging."""


@dataclass(frozen=True)
class GreyBlack:
    """The best method of each kind by mean rank, and their errors' ratio (grey over black) over the conditions.

    `ratio` is the median, `better` the number of `pairs` in which the grey box has the smaller error, `p` the two-sided
    p-value of Wilcoxon's signed-rank test on the logarithms of the ratios.  The methods are chosen on the same runs.
    """

    grey: str
    black: str
    ratio: float
    better: int
    pairs: int
    p: float

    def sentence(self) -> str:
        """The result in one sentence."""
        if self.p >= 0.05:
            verdict = "no difference is shown between"
        else:
            verdict = "the grey box beats the black box:" if self.ratio < 1.0 else "the black box beats the grey box:"
        names = f"{self.grey} (best grey box) and {self.black} (best black box)"
        return (
            f"In free runs {verdict} {names}; the ratio of yaw-rate errors has the median {self.ratio:.2g}, the "
            f"grey box is better in {self.better} of {self.pairs} vessels and conditions (Wilcoxon p = {self.p:.2g})."
        )


def kinds_of(names: list[str]) -> dict[str, str]:
    """Method of a results table -> its kind; methods that are not installed here are left out."""
    from ...methods.registry import find
    from ...models.errors import BadInput

    found = {}
    for name in names:
        try:
            found[name] = find(name.partition(",")[0]).kind if ".py:" not in name else ""
        except BadInput:
            continue
    return found


def grey_against_black(results: pd.DataFrame, kinds: Mapping[str, str], metric: str = METRIC) -> GreyBlack | None:
    """The best grey box against the best black box; None where fewer than six conditions have both.

    Parameters
    ----------
    results : rows of `results.parquet`; each condition's error of a method is the median over its seeds.  A run that
        failed or diverged has an infinite error; rows that do not apply are left out.
    kinds : method -> kind, see `kinds_of`.
    """
    errors = _errors(results, kinds, metric)
    chosen = {kind: _best(errors, [m for m in errors if kinds[m] == kind]) for kind in ("grey box", "black box")}
    grey, black = chosen["grey box"], chosen["black box"]
    if grey is None or black is None:
        return None
    pairs: Any = errors[[grey, black]].dropna()
    pairs = pairs[np.isfinite(pairs).any(axis=1)]
    if len(pairs) < FEWEST:
        return None
    with np.errstate(all="ignore"):
        ratio = np.clip(pairs[grey].to_numpy() / pairs[black].to_numpy(), 1.0 / LARGEST_RATIO, LARGEST_RATIO)
    p = signed_rank(pairs[grey].to_numpy(), pairs[black].to_numpy())
    return GreyBlack(grey, black, float(np.median(ratio)), int((ratio < 1.0).sum()), len(pairs), p)


def _errors(results: pd.DataFrame, kinds: Mapping[str, str], metric: str) -> pd.DataFrame:
    """Median errors over seeds: a row a condition, a column a method."""
    rows: Any = results[(results["status"] != "not_applicable") & results["method"].isin(list(kinds))]
    if "variant" in rows:
        rows = rows[rows["variant"] == "corrected"]
    lost = (rows["status"] != "ok") | rows["diverged"].fillna(False).astype(bool) | rows[metric].isna()
    rows = rows.assign(error=rows[metric].astype(float).where(~lost, np.inf))
    return rows.groupby([*CELL, "method"])["error"].median().unstack("method")


def _best(errors: pd.DataFrame, methods: list[str]) -> str | None:
    """The method of least mean rank over the conditions that all of those which ran most conditions share."""
    if not methods:
        return None
    own = errors[methods]
    own = own.loc[:, own.notna().sum() == own.notna().sum().max()]
    return str(own.dropna().rank(axis=1).mean().idxmin())
