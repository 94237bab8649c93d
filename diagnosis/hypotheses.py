"""Effects outside the bank: features, sets of them and pulses tried by their likelihood, and held-out proof."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..methods.innovations.estimator import Estimator, Setting
from . import unknown
from .evidence import independent, log_tail
from .gusts import cost, worth
from .search import IN_SPAN, Candidate, Search, T, candidate, on_both_threads, stands_out
from .unknown import Feature

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..methods.innovations.estimator import Trace
    from .evidence import Projector

    Series = tuple[np.ndarray, ...]

GUST_LEVELS = (0.0, 0.03, 0.2, 1.0)
"""Shares of the fitted gusts' sd at which features are tried: what explains their motion needs none."""
NOT_GUSTS = "unknown:a force that does not act on surge, sway and yaw at once, as gusts do"
SEARCHES = 4
BLOCK, LONGEST_PULSE = 192, 8
"""Features (or pairs of them) whose columns are held at once, and windows that a pulse may last."""
FURTHER_NATS = 12.0
"""Log likelihood, less the log of how many were tried, by which every named cause after the first must beat a single
unknown effect: that several act at once has to be worth more than that one is not known."""


@dataclass(frozen=True)
class Tried:
    """A set of features with twice its gain in log likelihood, the gusts' level chosen along."""

    features: tuple[Feature, ...]
    gain: float
    tests: float

    @property
    def log_p(self) -> float:
        """Log p-value, the number of sets that were tried taken into account."""
        k = len(self.features)
        return log_tail(self.gain, k) + k * np.log(self.tests)


def try_features(search: Search, before: float) -> list[Tried]:
    """Features, sets of them and pulses by the likelihood that one step and a level of gusts give, best first."""
    est, s = search.est, search.setting
    found, waves, bursts = unknown.features(est, s, search.now, est.clock), unknown.lines(est), unknown.pulses(est)
    gusty = bool(s.noise[6 : 6 + est.n_forces].any())
    best: dict[tuple[str, ...], Tried] = {}
    tests = float(len(found))
    for level in GUST_LEVELS if gusty else (1.0,):
        noise = np.where(level == 0.0, search.start.noise, s.noise)
        noise[6 : 6 + est.n_forces] = level * s.noise[6 : 6 + est.n_forces]
        noise[6 + est.n_forces] = s.noise[6 + est.n_forces]
        at = replace(s, noise=noise)
        now = search.now if level == 1.0 else est.evaluate(at)
        if now.log_likelihood <= -1e299 or np.abs(now.e).max() > 1e4:
            continue
        projector = search.present if level == 1.0 else search.projector(at, now)
        if level < 1.0:
            projector.residual = now.e.ravel()
        here = Here(est, est.traces(at), projector)
        left, told = here.projected(found)
        if level == 1.0:
            tests = independent(search.rng, projector.terms(left[told]))
        loss = 2.0 * (now.log_likelihood - before - (cost(est) if gusty and level > 0.0 else 0.0))
        for t in [*_sets(found, left, projector.residual, told), *_periodic(waves, here), *_bursts(bursts, here)]:
            key = tuple(f"{f.name}:{f.axis}" for f in t.features)
            gain = t.gain + loss
            if key not in best or gain > best[key].gain:
                best[key] = replace(t, gain=gain)
    out = [replace(t, tests=tests) if t.tests == 1.0 else t for t in best.values()]
    return sorted(out, key=lambda t: t.log_p)


@dataclass(frozen=True)
class Here:
    """The filter's runs at a setting, and the projection of what is free there."""

    est: Estimator
    traces: list[Trace]
    projector: Projector

    def columns(self, axes: Sequence[int], series: Sequence[Series]) -> np.ndarray:
        return self.est.responses(self.traces, axes, series)

    def projected(self, found: Sequence[Feature]) -> tuple[np.ndarray, np.ndarray]:
        """Projected columns (m, N*6) of features, and (m,) whether enough of each is left to be told."""

        def work(block: Sequence[Feature]) -> tuple[np.ndarray, np.ndarray]:
            columns = self.columns([f.axis for f in block], [f.series for f in block])
            left = self.projector.project(columns)
            whole = np.einsum("ij,ij->i", columns, columns)
            return left, np.einsum("ij,ij->i", left, left) > IN_SPAN * np.maximum(whole, 1e-300)

        left, told = zip(*on_both_threads(work, _blocks(found)), strict=True)
        return np.concatenate(left), np.concatenate(told)


def _blocks(items: Sequence[T]) -> list[Sequence[T]]:
    return [items[i : i + BLOCK] for i in range(0, len(items), BLOCK)]


def _sets(
    found: Sequence[Feature], left: np.ndarray, residual: np.ndarray, told: np.ndarray, most: int = 3
) -> list[Tried]:
    """Every feature alone, and greedy sets of two and three of them."""
    information = np.einsum("ij,ij->i", left, left)
    gain = np.where(told, (left @ residual) ** 2 / np.maximum(information, 1e-300), 0.0)
    out = [Tried((found[j],), float(gain[j]), 1.0) for j in np.flatnonzero(told).tolist()]
    slope, size = left @ residual, information.copy()
    chosen, units, total = [], np.zeros((0, residual.size)), 0.0
    for _ in range(most):
        open_ = told & (size > 0.02 * np.maximum(information, 1e-300))
        gain = np.where(open_, slope**2 / np.maximum(size, 1e-300), 0.0)
        j = int(np.argmax(gain))
        if gain[j] <= 0.0:
            break
        total += float(gain[j])
        chosen.append(found[j])
        unit = left[j] - (units @ left[j]) @ units
        unit /= np.linalg.norm(unit)
        units = np.vstack([units, unit])
        along = left @ unit
        size, slope = size - along**2, slope - along * (unit @ residual)
        if len(chosen) > 1:
            out.append(Tried(tuple(chosen), total, 1.0))
    return out


def _periodic(waves: Sequence[tuple[Feature, Feature]], here: Here) -> list[Tried]:
    """The moment at a fixed frequency, of any phase, that gains most."""

    def gains(block: Sequence[tuple[Feature, Feature]]) -> np.ndarray:
        both = [f for pair in block for f in pair]
        columns = here.columns([f.axis for f in both], [f.series for f in both])
        information, slope = here.projector.products(columns.reshape(len(block), 2, -1))
        return np.einsum("ij,ijk,ik->i", slope, np.linalg.pinv(information, hermitian=True), slope)

    gain = np.concatenate(on_both_threads(gains, _blocks(waves)))
    best = int(np.argmax(gain))
    return [Tried(waves[best], float(gain[best]), np.sqrt(len(waves)))]  # one choice for both features


def _bursts(bursts: Sequence[Sequence[Series]], here: Here) -> list[Tried]:
    """The best force that acts for one to eight windows of one record (or of all at the same time), on each axis."""
    windows = len(bursts[0])
    first, last = (i.ravel() for i in np.indices((windows + 1, windows + 1)))
    interval = (last - first >= 1) & (last - first <= LONGEST_PULSE)
    first, last = first[interval], last[interval]

    def gains(block: tuple[int, Sequence[Series]]) -> np.ndarray:
        axis, series = block
        information, slope = here.projector.products(here.columns([axis] * windows, series))
        whole, along = np.zeros((windows + 1, windows + 1)), np.zeros(windows + 1)
        whole[1:, 1:], along[1:] = information.cumsum(axis=0).cumsum(axis=1), slope.cumsum()
        own = whole[last, last] - whole[first, last] - whole[last, first] + whole[first, first]
        return np.where(own > 0.0, (along[last] - along[first]) ** 2 / np.where(own > 0.0, own, 1.0), 0.0)

    axes, data = range(here.est.n_forces), here.est.data
    found = on_both_threads(gains, [(axis, series) for axis in axes for series in bursts])
    gain = np.stack(found).reshape(len(axes), -1)
    out = []
    for axis in axes:
        owner, k = divmod(int(np.argmax(gain[axis])), first.size)
        arrays = tuple(np.sum(parts, axis=0) for parts in zip(*bursts[owner][first[k] : last[k]], strict=True))
        place = data[owner].name if owner < len(data) else "every record"
        pulse = Feature(f"pulse in {place}", axis, arrays, "pulse")
        out.append(Tried((pulse,), float(gain[axis].max()), float(gain.size)))
    return out


def best_unknown(search: Search, threshold: float) -> Candidate | None:
    """The unknown effect that gains most after a refit of the noise, if it passes the threshold (log p).

    Features, periodic moments, pulses and forces unlike gusts are four searches; each has its share.
    """
    s, now = search.setting, search.now
    threshold -= np.log(SEARCHES)
    here = search.judged
    before, gain = here.worth, 2.0 * (now.log_likelihood - here.gust_like)
    found = [Candidate(NOT_GUSTS, (), log_tail(gain, 2), gain, s, now, worth=before)]
    chosen = [t for t in try_features(search, before)[:12] if t.log_p < threshold + 6.0][:2]
    found += search.side_by_side(lambda own, t: refit_features(own, t.features, before, t.tests), chosen)
    found.sort(key=lambda c: c.log_p)
    return next((c for c in found if c.log_p < threshold and stands_out(search, c)), None)


def lead(search: Search) -> float:
    """Nats by which all that was named beats the best unknown effect of the first step alone; infinite without one."""
    rival = search.rival
    if rival is None or not search.accepted:
        return np.inf
    named = sum(np.log(a.tests * search.n_effective) + FURTHER_NATS for a in search.accepted) - FURTHER_NATS
    return search.judged.worth - named - (rival.worth - np.log(rival.tests))


def refit_features(search: Search, features: Sequence[Feature], before: float, tests: float) -> Candidate:
    """Unknown forces or sensor shifts, refitted with the noise; before: what the records are worth without them."""
    variant = tuple(f.parameter(search.est) for f in features)
    found, now = search.refit(search.setting, variant, 3)
    name = " + ".join(f.name for f in features)
    refitted = candidate(f"unknown:{name}", variant, len(variant), tests ** len(variant), before, found, now)
    left = worth(search.est, found, now)
    return replace(refitted.gaining(2.0 * (left - before)), worth=left)


def confirmed(search: Search, left: Candidate, records: Sequence[Record]) -> bool | None:
    """Whether unexplained terms, at the size found in training, raise the likelihood of held-out records too.

    None where a term belongs to one training record (a pulse) and says nothing about others.
    """
    est = search.est
    held = Estimator(est.model, records, est.unit)
    s = Setting(np.tile(left.setting.p[0], (len(held.data), 1)), left.setting.noise)
    now = held.evaluate(s)
    found = {(f.name, f.axis): f for f in unknown.features(held, s, now, held.clock)}
    for p in left.variant:
        name, _, axis = p.name.rpartition(":")
        feature = found.get((name, int(axis)))
        if feature is None:
            return None
        s = held.moved(s, feature.parameter(held), est.value(left.setting, p))
    return bool(held.evaluate(s).log_likelihood > now.log_likelihood + 2.0)
