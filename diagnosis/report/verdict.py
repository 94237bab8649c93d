"""From evidence to a verdict, in words: what is decided, what is not, and which manoeuvre to run next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..result import Diagnosis, Finding, Trace

if TYPE_CHECKING:
    from ...models.model import Model
    from ..options import Options
    from ..result import Entry

FOLLOWED = 0.5
"""Share of the squared yaw motion that free runs must hold for a cause to be named: nonsense is not followed."""
MOST = 10.0
"""Largest error that is told, as a share of the motion."""
NAMED, PARTLY = 0.8, 0.2
"""Shares of the squared free-run error from which it counts as named, and as partly named."""


def of_motion(error: float) -> str:
    """An error that is a share of the motion, in words: `0.12 %`, `84 %`, `more than 1000 %`."""
    if error > MOST:
        return f"more than {100.0 * MOST:.0f} % of the motion"
    return f"{100.0 * error:.{0 if error > 0.1 else 1}f} % of the motion"


def without_motion(traces: Sequence[Trace]) -> str | None:
    """Why nothing can be named although causes fit: free runs of the training records with all that is named do not
    follow the yaw motion; None where they do."""
    share = motion_explained([t for t in traces if t.role == "train"])
    if share is None or share >= FOLLOWED:
        return None
    said = f"hold {100.0 * share:.0f} %" if share > 0.0 else "hold nothing"
    return f"free runs with all that is named {said} of the yaw motion: the rudder of the records does not explain it"


def motion_explained(traces: Sequence[Trace]) -> float | None:
    """1 - squared error of the free runs after extension over the squared yaw motion: of the yaw rate or of the heading
    about its mean, whichever they follow better, as one of both sensors may fail; None without a known value."""
    shares = []
    for channel in ("yaw_rate_rad_s", "heading_rad"):
        error = motion = 0.0
        for t in traces:
            y = t.measured.get(channel, np.zeros(0))
            lost = y - t.after[channel] if y.size else y
            known = np.isfinite(lost)
            error += float(np.sum(lost[known] ** 2))
            middle = float(np.mean(y[known])) if channel == "heading_rad" and known.any() else 0.0
            motion += float(np.sum((y[known] - middle) ** 2))
        if motion > 0.0:
            shares.append(1.0 - error / motion)
    return max(shares, default=None)


def next_manoeuvre(poor: str | None, findings: Sequence[Finding]) -> str | None:
    """What to run next: excitation where there was none, else what would break a tie."""
    if poor is not None:
        return (
            "a 20/20 zigzag to both sides and a 25 deg turning circle, rudder, heading and yaw rate at 2 Hz or faster"
        )
    said = [f.separate_by for f in findings if f.tied_with and f.separate_by]
    return "; ".join(said) or None


def where(traces: Sequence[Trace]) -> list[dict[str, Any]]:
    """In which conditions the base model's free-run yaw rate or heading goes wrong: share of the squared error."""
    rows = (where_wrong(channel, traces, lambda t: t.before) for channel in ("yaw_rate_rad_s", "heading_rad"))
    return next(filter(None, rows), [])


def where_wrong(
    channel: str, traces: Sequence[Trace], run: Callable[[Trace], Mapping[str, np.ndarray]]
) -> list[dict[str, Any]]:
    """Conditions with their shares of a channel's squared error and of the time; none where there is no error.

    run : of a trace, the one whose errors count.
    """
    parts = [t for t in traces if channel in t.measured]
    if not parts:
        return []
    error = np.concatenate([t.measured[channel] - run(t)[channel] for t in parts])
    rudder = np.abs(np.concatenate([t.rudder for t in parts]))
    rate = np.concatenate([t.measured.get("yaw_rate_rad_s", np.gradient(t.measured[channel], t.time)) for t in parts])
    late = np.concatenate([t.time / t.time[-1] for t in parts])
    seen = np.isfinite(error)
    square = np.where(seen, error**2, 0.0)
    if not square.any():
        return []
    conditions = {
        "large rudder angles (above the median)": rudder > np.median(rudder[seen]),
        "turns to starboard": rate > 0.0,
        "the second half of a record": late > 0.5,
    }
    return [
        {
            "channel": channel,
            "condition": condition,
            "share_of_error": float(square[chosen & seen].sum() / square.sum()),
            "share_of_time": float(np.mean(chosen[seen])),
        }
        for condition, chosen in conditions.items()
    ]


def diagnosis_of(
    models: tuple[Model, Model],
    options: Options,
    decided: tuple[str, str],
    findings: Sequence[Finding],
    bank: Sequence[Entry],
    *,
    noise: Mapping[str, Any],
    poor: str | None = None,
    hypothesis: dict[str, Any] | None = None,
    doubts: tuple[str, ...] = (),
) -> Diagnosis:
    """The diagnosis without the names of its records, its gain (`gain.runs`) and its cost, which `diagnose` knows.

    models : base and extended.  decided : verdict and reason.  poor : why the records cannot decide anything; then no
    cause is told.
    """
    return Diagnosis(
        *models,
        base_parameters=str(options.base_parameters),
        records=(),
        alpha=options.alpha,
        seed=options.seed,
        threads=options.threads,
        verdict=decided[0],
        reason=decided[1],
        causes=tuple(findings) if poor is None else (),
        bank=tuple(bank),
        gain={},
        hypothesis=hypothesis,
        noise=dict(noise),
        traces=(),
        where=(),
        next_manoeuvre=next_manoeuvre(poor, findings),
        wall_s=0.0,
        cpu_s=0.0,
        doubts=doubts,
    )
