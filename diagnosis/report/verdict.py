"""From evidence to a verdict, in words: what is decided, what is not, and which manoeuvre to run next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.statistics.tails import chi2_quantile, shifted_chi2_tail
from ..candidate import Unmodelled
from ..result import Finding

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Candidate
    from ..causes.base import Cause
    from ..state import State
    from ..trace import Trace

EXCITED = 8.0
"""Yaw motion over its sensor's noise (rms, smoothed) below which a record tells nothing about manoeuvring."""
RUDDER_MOVED = np.deg2rad(0.3)
FOLLOWED = 0.5
"""Share of the squared yaw motion that free runs must hold for a cause to be named: nonsense is not followed."""
FAINTEST = (1e-6, 1e-8)
"""Heading (rad) and yaw rate (rad/s) that no sensor resolves."""
NAMED, PARTLY = 0.8, 0.2
"""Shares of the explainable free-run error from which it counts as named, and as partly named."""
PLAIN = "the residuals are those of the model, its sensors' noise and zero-mean gusts"


def undecidable(est: Estimator, start: Setting) -> str | None:
    """Why the records cannot decide anything (too little motion, too few samples), None if they can."""
    moved = max(float(np.std(d.rudder)) for d in est.segments)
    strongest = 0.0
    for d in est.segments:
        for c in (0, 1):
            y = d.measured[:, c]
            y = y[np.isfinite(y)]
            if y.size < 20:
                continue
            size = max(1, y.size // 200)
            mean = y[: y.size // size * size].reshape(-1, size).mean(axis=1)
            if np.std(y) > FAINTEST[c]:
                strongest = max(strongest, float(np.std(mean) / (start.noise.sensor_sd[c] / np.sqrt(size))))
    if moved < RUDDER_MOVED or strongest < EXCITED:
        return (
            f"the rudder moves by {np.rad2deg(moved):.2f} deg (sd) and the yaw motion is {strongest:.1f} times its "
            "sensor's noise: the records hold no manoeuvre"
        )
    if est.n_values < 60:
        return f"{est.n_values} measured values are too few"
    return None


def decide(poor: str | None, left: Candidate | None, instead: bool, findings: Sequence[Finding]) -> tuple[str, str]:
    """The verdict by precedence, and the sentence that supports it.

    left : what is not explained; instead: it stands in the place of what was named, not beside it.
    """
    if poor is not None:
        return "inconclusive", poor
    if left is not None:
        effect = left.cause.label if isinstance(left.cause, Unmodelled) else left.cause.id
        if instead:
            return "unexplained", f"one other effect ({effect}) is as likely as all that is named"
        return "unexplained", f"an effect remains unexplained: {effect}"
    ties = [f for f in findings if f.tied_with]
    if ties:
        said = "; ".join(f"{f.cause} cannot be told from {' or '.join(f.tied_with)}" for f in ties)
        return "tied", said
    if findings:
        return "named", f"with what is named, {PLAIN}"
    return "adequate", PLAIN


def by_share(what: str, explained: float) -> tuple[str, str]:
    """The verdict by the share of the explainable free-run error that is explained, and the sentence that supports it.

    Eq. 4 of docs/mathematics/calibration.md.
    """
    said = f"{what} off {100.0 * min(explained, 1.0):.0f} % of what can be explained of the free-run error"
    if explained >= NAMED:
        return "named", said
    return ("partly_named" if explained >= PARTLY else "unexplained"), said


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


def power(state: State, cause: Cause) -> float | None:
    """Power of a cause's test at the size that its power is stated for, at the family-wise level; None without one."""
    screened = state.screened.get(cause)
    if screened is None or cause.power_size is None:
        return None
    p, k = screened.variant[0], len(screened.variant)
    size = cause.power_size * (state.est.clock if p.unit == "s" else 1.0)
    noncentrality = float(screened.score.information[0, 0]) * size**2
    threshold = chi2_quantile(state.alpha / state.n_effective, k)
    return shifted_chi2_tail(threshold, k, max(noncentrality, 1e-9))


def where(traces: Sequence[Trace]) -> list[dict[str, Any]]:
    """In which conditions the base model's free-run yaw rate or heading goes wrong: share of the squared error."""
    out = []
    for channel in ("yaw_rate_rad_s", "heading_rad"):
        parts = [t for t in traces if channel in t.measured]
        if not parts:
            continue
        error = np.concatenate([t.measured[channel] - t.before[channel] for t in parts])
        rudder = np.abs(np.concatenate([t.rudder for t in parts]))
        rate = np.concatenate(
            [t.measured.get("yaw_rate_rad_s", np.gradient(t.measured[channel], t.time)) for t in parts]
        )
        late = np.concatenate([t.time / t.time[-1] for t in parts])
        square = np.where(np.isfinite(error), error**2, 0.0)
        total = square.sum()
        if not total > 0.0:
            continue
        seen = np.isfinite(error)
        for label, chosen in {
            "large rudder angles (above the median)": rudder > np.median(rudder[seen]),
            "turns to starboard": rate > 0.0,
            "the second half of a record": late > 0.5,
        }.items():
            share, time = float(square[chosen & seen].sum() / total), float(np.mean(chosen[seen]))
            out.append({"channel": channel, "condition": label, "share_of_error": share, "share_of_time": time})
        break
    return out
