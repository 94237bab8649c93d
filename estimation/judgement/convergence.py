"""Convergence of a recursive method: settling time into a band around a value, and overshoot, of every parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...models.errors import BadInput
from ..estimates.estimate import Estimate

BANDS = (0.05, 0.02)
"""Half widths of the bands, relative to the value."""


def convergence(
    estimate: Estimate, truth: Mapping[str, float] | None = None, bands: Sequence[float] = BANDS
) -> dict[str, tuple[dict[float, float], float]]:
    """Convergence of every published parameter of a recursive method's estimate.

    Parameter -> settling times, band -> seconds of record after which it stays in the band (inf if it ends outside);
    and its overshoot, the largest excursion beyond the value, coming from zero, relative to the value's size.

    Parameters
    ----------
    truth : parameter -> value to converge to; None: the final estimate.  Parameters whose value is zero or not finite
        are left out.
    bands : half widths relative to |value|, > 0.

    Raises
    ------
    BadInput : the estimate has no trajectory, a band is not positive, or `truth` names no parameter of the model.
    """
    if estimate.trajectory is None or estimate.trajectory_time_s is None:
        raise BadInput(f"method {estimate.method} keeps no trajectory")
    if not all(band > 0.0 for band in bands):
        raise BadInput("bands are positive shares of the value")
    truth = estimate.parameters if truth is None else truth
    unknown = [name for name in truth if name not in estimate.parameters]
    if unknown:
        raise BadInput(f"no parameter {unknown[0]!r}", hint=f"known: {', '.join(estimate.parameters)}")
    paths = parameter_paths(estimate)
    return {
        name: (
            {band: settling_time(paths[name], estimate.trajectory_time_s, value, band) for band in bands},
            overshoot(paths[name], value),
        )
        for name, value in truth.items()
        if value and np.isfinite(value)
    }


def parameter_paths(estimate: Estimate) -> dict[str, np.ndarray]:
    """Published parameter -> its values (N,) along the trajectory; nan where the map has no real value."""
    model, path = estimate.model, estimate.trajectory
    if path is None:
        raise BadInput(f"method {estimate.method} keeps no trajectory")
    if model.kernels.PUBLISHED:
        with np.errstate(all="ignore"):
            path = np.array([model.to_parameters(row) for row in path]).reshape(len(path), -1)
    return dict(zip(model.parameter_names, path.T, strict=True))


def settling_time(path: np.ndarray, time_s: np.ndarray, value: float, band: float) -> float:
    """Time from which path (N,) at times (N,) stays within band |value| of the value; inf if it never does."""
    outside = np.flatnonzero(~(np.abs(path - value) <= band * abs(value)))
    if not outside.size:
        return float(time_s[0])
    last = int(outside[-1])
    return float(time_s[last + 1]) if last + 1 < len(path) else np.inf


def overshoot(path: np.ndarray, value: float) -> float:
    """Largest distance of path (N,) beyond the value, coming from zero, relative to |value|; 0 if there is none."""
    finite = path[np.isfinite(path)]
    beyond = (finite - value) * (1.0 if value >= 0.0 else -1.0)
    return float(max(beyond.max(initial=0.0), 0.0) / abs(value))
