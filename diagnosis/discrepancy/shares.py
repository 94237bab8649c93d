"""What causes and the model's numbers take off the error of free runs, in records that were left out.

A record is simulated with the discrepancy and the causes that the other records give; quantities that belong to a
record, such as a current, are its own.  No random force acts after release.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..gain.free_runs import START_S
from .fit import Fitted
from .quadratic import Quadratic, mode
from .terms import FORCES

BLOCKS = 12
"""Blocks a record is cut into for the bootstrap."""
DRAWS = 300
LOST = np.array([10.0, 10.0, 10.0, 10.0, 1e4, 1e4])
"""Largest error (SI) of each channel; a run that is lost counts with it."""
CERTAIN = 0.01
"""Probability that a cause takes nothing off a channel, below which it matters there."""
TOLD = 0.5
"""Squared error over that of the sensor from which a channel counts."""


class Share(NamedTuple):
    """A share of the base model's squared free-run error with its 90 % interval."""

    value: float
    low: float
    high: float

    @property
    def text(self) -> str:
        """In percent; all of the error and more where the numbers alone would make it larger."""
        value, low, high = (f"{100.0 * min(max(part, -1.0), 1.0):.0f}" for part in self)
        return f"{'more than ' if self.value > 1.0 else ''}{value} % [{low}, {high}]"


class OfChannel(NamedTuple):
    """Shares of a channel's squared free-run error: taken off by numbers and causes, and by each cause beside them; of
    its sensor's noise."""

    both: float
    drops: tuple[float, ...]
    noise: float

    def explained(self, without: Sequence[int]) -> float:
        """Share of what can be explained that is, without some of the causes.

        Eq. 15 of docs/mathematics/default-route.md.
        """
        taken = self.both - sum(max(self.drops[j], 0.0) for j in without)
        return max(taken, 0.0) / max(1.0 - self.noise, 0.05)


@dataclass(frozen=True)
class Shares:
    """Shares of the base model's squared free-run error, mean over the channels that tell.

    numbers: taken off by the model's own numbers alone; beside: by these beside the causes; both: by all.
    drops: by each cause beside the numbers and the other causes; felt: whether it surely takes something off a channel.
    channels: those that tell.
    """

    numbers: Share
    beside: Share
    both: Share
    drops: tuple[Share, ...]
    felt: tuple[bool, ...]
    channels: tuple[OfChannel, ...]


@dataclass(frozen=True)
class _Errors:
    """Sums of squares (B, 6) above the sensors' by block, for one way to simulate, and known values (B, 6)."""

    square: np.ndarray
    count: np.ndarray


def shares(null: Fitted, final: Fitted, causes: Sequence[np.ndarray], rng: np.random.Generator) -> Shares:
    """Shares of the causes, whose parameters stand at `causes` among those of the fit.

    Eq. 14 of docs/mathematics/default-route.md.
    """
    base, q, hull = final.base, final.expansion, null.expansion
    sd = final.setting.noise.sensor_sd
    ways: dict[str, list[np.ndarray]] = {}
    for i, d in enumerate(base.est.segments):
        own = left_out(q, final, d.record, final.free)
        alone = left_out(hull, null, d.record, null.free)
        bare = np.zeros(final.x.size)
        runs = {
            "base": bare,
            "causes": without_numbers(final, final.x),
            "numbers": _numbers(null, alone, final),
            "both": own,
        }
        for j, places in enumerate(causes):
            less = own.copy()
            less[places] = 0.0
            runs[f"without {j}"] = less
        for name, x in runs.items():
            ways.setdefault(name, []).append(simulated_error(final, x, i))
    errors = {name: _sums(found, sd) for name, found in ways.items()}
    return _shares(errors, len(causes), base.est.channels, sd, rng)


def without_numbers(final: Fitted, x: np.ndarray) -> np.ndarray:
    """The causes' parameters alone."""
    out = x.copy()
    out[: len(final.base.terms.parameters)] = 0.0
    return out


def _numbers(null: Fitted, x: np.ndarray, final: Fitted) -> np.ndarray:
    return np.concatenate([x[: len(null.base.terms.parameters)], np.zeros(len(final.variant))])


def left_out(q: Quadratic, found: Fitted, record: int | None, kept: np.ndarray) -> np.ndarray:
    """Parameters that a simulation can carry, by the records other than one (None: by all); those that belong to a
    record are its own.

    kept : places of the causes' parameters that are not zero.
    """
    if record is None and found.base.est.model.is_3dof and kept.size == len(found.variant):
        return _simulating(found, found.x)
    variances = simulating_variances(found)
    use = np.ones(q.record.size, bool) if record is None else q.record != record
    if not use.any():
        return _simulating(found, found.x)
    records = [(place, p.record) for place, p in zip(found.free, found.variant, strict=True) if place in kept]
    x = mode(q, variances, [place for place, r in records if record is None or r != record], use).x
    own = [place for place, r in records if r == record and record is not None]
    x[own] = found.x[own]
    return _simulating(found, found.base.bounded(x, found.variant))


def simulating_variances(found: Fitted) -> np.ndarray:
    """The variances, of a response model without those of forces that no simulation carries: beside these, its numbers
    alone are not what fits."""
    variances = found.variances.copy()
    if not found.base.est.model.is_3dof:
        variances[FORCES:] = 0.0
    return variances


def _simulating(found: Fitted, x: np.ndarray) -> np.ndarray:
    """Without terms that no simulation carries."""
    out = x.copy()
    held = len(found.base.terms.parameters)
    out[:held] = np.where(found.base.terms.simulating, out[:held], 0.0)
    return out


def simulated_error(found: Fitted, x: np.ndarray, segment: int) -> np.ndarray:
    """Measured minus simulated channels (T, 6) of a segment; nan before release and at gaps."""
    base = found.base
    est, d = base.est, base.est.segments[segment]
    start = base.origin if np.any(x) else est.start()
    s = base.at(x, found.variant, est.start()) if np.any(x) else start
    free = max(int(np.searchsorted(d.time, min(START_S * est.clock, 0.2 * d.time[-1]))), 2)
    e = d.measured - est.free_run(s, segment, free)
    e[:, 0] = np.mod(e[:, 0] + np.pi, 2.0 * np.pi) - np.pi
    e = np.clip(np.where(np.isfinite(e) | ~np.isfinite(d.measured), e, LOST), -LOST, LOST)
    e[:free] = np.nan
    return e


def _sums(errors: Sequence[np.ndarray], sd: np.ndarray) -> _Errors:
    square, count = [], []
    for e in errors:
        for part in np.array_split(e, BLOCKS):
            known = np.isfinite(part)
            count.append(known.sum(axis=0))
            square.append(np.nansum(part**2, axis=0) - sd**2 * count[-1])
    return _Errors(np.array(square), np.array(count))


def _shares(
    errors: Mapping[str, _Errors], n_causes: int, channels: np.ndarray, sd: np.ndarray, rng: np.random.Generator
) -> Shares:
    base = errors["base"]
    told = channels & (base.square.sum(axis=0) > TOLD * sd**2 * np.maximum(base.count.sum(axis=0), 1))
    if not told.any():
        nothing = Share(0.0, 0.0, 0.0)
        return Shares(nothing, nothing, nothing, (nothing,) * n_causes, (False,) * n_causes, ())

    def ratios(pick: np.ndarray) -> np.ndarray:
        """(3 + causes, channels) shares over some blocks."""
        sums = {name: e.square[pick].sum(axis=0)[told] for name, e in errors.items()}
        whole = np.maximum(sums["base"], 1e-300)
        rows = [(sums["base"] - sums["numbers"]) / whole, (sums["causes"] - sums["both"]) / whole]
        rows += [(sums["base"] - sums["both"]) / whole]
        rows += [(sums[f"without {j}"] - sums["both"]) / whole for j in range(n_causes)]
        return np.array(rows)

    count = len(base.square)
    middle = ratios(np.arange(count))
    draws = np.array([ratios(rng.integers(0, count, count)) for _ in range(DRAWS)])
    low, high = np.quantile(draws.mean(axis=2), [0.05, 0.95], axis=0)
    certain = np.asarray(np.quantile(draws[:, 3:], CERTAIN, axis=0)) > 0.0
    felt = tuple(bool(np.any(row)) for row in certain)
    found = [Share(*map(float, one)) for one in zip(middle.mean(axis=1), low, high, strict=True)]
    noise = (sd**2 * base.count.sum(axis=0))[told] / np.maximum(base.square.sum(axis=0)[told], 1e-300)
    of_channels = tuple(
        OfChannel(float(column[2]), tuple(map(float, column[3:])), float(share / (1.0 + share)))
        for column, share in zip(middle.T, noise, strict=True)
    )
    return Shares(found[0], found[1], found[2], tuple(found[3:]), felt, of_channels)
