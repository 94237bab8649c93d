"""What the uncertainty that methods state is worth: how often their intervals hold, and the probabilistic scores."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..numbers import percent
from ..tables import Table, field, make_table
from .columns import count, numeric
from .standings import labels, median

if TYPE_CHECKING:
    from .standings import Frame

SCORES = ("coverage_95", "crps_median", "coverage_free", "crps_free")
NOTE = (
    "Inside: mean share of the stated 95 % intervals that hold the true parameter, or the sample of a held-out record. "
    "CRPS: median continuous ranked probability score, over the true value or the spread of the record. Free runs are "
    "drawn 20 times from what the method states: covariance of coefficients, Gaussian process, or trees. Noise "
    "of the held-out sensors counts as error. Intervals that are too small hold less than 95 %."
)


COLUMNS = (
    field("method"),
    count("runs"),
    numeric("parameters inside", "coverage_95", percent),
    numeric("CRPS of parameters", "crps_median"),
    numeric("free run inside", "coverage_free", percent),
    numeric("CRPS of free runs", "crps_free"),
)


def uncertainty_table(results: Frame) -> Table:
    """Methods that state an uncertainty, the best free runs first; no row where none was scored."""
    scored = [name for name in SCORES if name in results]
    known = results[results[scored].notna().any(axis=1)]
    rows = [_row(str(label), own[scored]) for label, own in known.groupby(labels(known), observed=True)]
    rows.sort(key=lambda row: (np.isnan(row["crps_free"]), row["crps_free"], row["method"]))
    return make_table(COLUMNS, rows, "What stated uncertainties are worth", NOTE)


def _row(label: str, own: Frame) -> dict[str, Any]:
    means = {name: float(own[name].mean()) if name.startswith("coverage") else median(own[name]) for name in own}
    return {"method": label, "runs": len(own)} | dict.fromkeys(SCORES, np.nan) | means


def uncertainty_finding(runs: Frame) -> str | None:
    """How often the stated intervals of free runs hold, with the ship's own equations and on measured ships.

    runs : as `standings.judged` gives them.
    """
    if "coverage_free" not in runs:
        return None
    shares = runs.groupby("case", observed=True)["coverage_free"].agg(["mean", "count"])
    told = [f"{case} {percent(float(mean))} ({int(n)} runs)" for case, mean, n in shares.itertuples(name=None) if n]
    text = f"The 95 % intervals of free runs that methods state hold the record in: {', '.join(told)}."
    return text if told else None
