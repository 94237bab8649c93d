"""Effects outside the bank: features, sets of them and pulses tried by their likelihood; whether one stays unexplained
once causes are named, and whether held-out records confirm it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...checks.tails import log_tail
from ...estimation.filters.innovations.derivatives import responses, traces
from ...estimation.filters.innovations.estimator import Estimator, estimator
from ...estimation.filters.innovations.settings import Noise, Setting
from ...estimation.filters.innovations.vector import CHANNELS
from ...models.linear_algebra import pinv
from ..causes.sensors import HeadingDelay
from . import features, tests
from .features import YAW_RATE_IN_HEADING, Feature
from .gusts import gust_cost, penalised_likelihood
from .score_tests import cauchy_combination, independent_tests
from .state import IN_SPAN, Candidate, State, Unmodelled, candidate, exceeds_misfit, misfit_allowance

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations._arguments import Trace
    from .score_tests import Projector

    Series = tuple[np.ndarray, ...]


T = TypeVar("T")
GUST_LEVELS = (0.0, 0.03, 0.2, 1.0)
"""Shares of the fitted gusts' sd at which features are tried: what explains their motion needs none."""
NOT_GUSTS = Unmodelled("a force that does not act on surge, sway and yaw at once, as gusts do")
SEARCHES = 4
"""Searches that share the level: features, periodic moments, pulses, and forces unlike gusts."""
BLOCK, PAIRS, LONGEST_PULSE = 32, 16, 8
"""Features, and pairs of them, whose columns are held at once, and windows that a pulse may last."""
UNMODELLED = 0.3
"""Share of the family-wise level that effects outside the bank have."""
FURTHER_NATS = 12.0
"""Log likelihood, less the log of how many were tried, by which every named cause after the first must beat a single
unmodelled effect: that several act at once has to be worth more than that one is not known."""


@dataclass(frozen=True)
class Tried:
    """A set of features with their likelihood-ratio statistic, the gusts' level chosen along."""

    features: tuple[Feature, ...]
    gain: float
    tests: float

    @property
    def log_p(self) -> float:
        """Log p-value, the number of sets that were tried taken into account."""
        k = len(self.features)
        return log_tail(self.gain, k) + k * np.log(self.tests)


@dataclass(frozen=True)
class Linearised:
    """The filter's stored runs at a setting, and the projection of what is free there."""

    est: Estimator
    runs: list[Trace]
    projector: Projector

    def columns(self, axes: Sequence[int], series: Sequence[Series], into: np.ndarray | None = None) -> np.ndarray:
        """Columns (m, N*6) of added series; into : zeros that are filled, instead of new ones."""
        return responses(self.est, self.runs, axes, series, into)

    def projected(self, state: State, features: Sequence[Feature]) -> tuple[np.ndarray, np.ndarray]:
        """Projected columns (m, N*6) of features, and (m,) whether enough of each is left to be seen."""

        left = np.zeros((len(features), self.est.edges[-1] * CHANNELS))
        seen = np.empty(len(features), bool)

        def work(first: int) -> None:
            block = slice(first, min(first + BLOCK, len(features)))
            columns = self.columns([f.axis for f in features[block]], [f.series for f in features[block]], left[block])
            whole = np.einsum("ij,ij->i", columns, columns)
            left[block] = self.projector.project(columns)
            kept = np.einsum("ij,ij->i", left[block], left[block])
            seen[block] = kept > IN_SPAN * np.maximum(whole, 1e-300)

        state.in_threads(work, range(0, len(features), BLOCK))
        return left, seen


def try_features(state: State, before: float, rng: np.random.Generator) -> list[Tried]:
    """Features, sets of them and pulses by the likelihood that one step and a level of gusts give, best first."""
    est, s = state.est, state.setting
    every, bursts = features.features(est, state.now), features.pulses(est)
    waves = features.lines(est, state.now)
    best: dict[tuple[str, ...], Tried] = {}
    tests = float(len(every))
    for level in GUST_LEVELS if s.noise.has_forces else (1.0,):
        sensors = state.start.noise.sensor_sd if level == 0.0 else s.noise.sensor_sd
        at = replace(s, noise=Noise(sensors, level * s.noise.force_sd, s.noise.correlation_time_s))
        now = state.now if level == 1.0 else est.evaluate(at)
        if now.diverged or np.abs(now.e).max() > 1e4:
            continue
        project = state.point.projector
        if level < 1.0:
            project = state.at(at, now).point.projector.with_residual(now)
        here = Linearised(est, traces(est, at), project)
        of_sets, terms = _of_sets(state, every, here, level == 1.0)
        if terms is not None:
            tests = independent_tests(rng, terms)
        cost = gust_cost(est) if s.noise.has_forces and level > 0.0 else 0.0
        loss = 2.0 * (now.log_likelihood - before - cost)
        for t in [*of_sets, *_periodic(state, waves, here), *_bursts(state, bursts, here)]:
            key = tuple(f.key for f in t.features)
            gain = t.gain + loss
            if key not in best or gain > best[key].gain:
                best[key] = replace(t, gain=gain)
    out = [replace(t, tests=tests) if t.tests == 1.0 else t for t in best.values()]
    return sorted(out, key=lambda t: t.log_p)


def _of_sets(
    state: State, features: Sequence[Feature], here: Linearised, with_terms: bool
) -> tuple[list[Tried], np.ndarray | None]:
    """Features and sets of them, and what each sample adds (m, N) to the scores of those that are seen, if asked for;
    the columns of all features are held meanwhile."""
    left, seen = here.projected(state, features)
    sets = _sets(features, left, here.projector.residual, seen)
    if not with_terms:
        return sets, None
    terms = np.empty((np.count_nonzero(seen), left.shape[1] // CHANNELS))
    for own, j in zip(terms, np.flatnonzero(seen).tolist(), strict=True):
        own[:] = here.projector.terms(left[j : j + 1])[0]
    return sets, terms


def _blocks(items: Sequence[T]) -> list[Sequence[T]]:
    return [items[i : i + PAIRS] for i in range(0, len(items), PAIRS)]


def _sets(
    features: Sequence[Feature], left: np.ndarray, residual: np.ndarray, seen: np.ndarray, most: int = 3
) -> list[Tried]:
    """Every feature alone, and greedy sets of two and three of them."""
    information = np.einsum("ij,ij->i", left, left)
    gain = np.where(seen, (left @ residual) ** 2 / np.maximum(information, 1e-300), 0.0)
    out = [Tried((features[j],), float(gain[j]), 1.0) for j in np.flatnonzero(seen).tolist()]
    slope, size = left @ residual, information.copy()
    chosen, units, total = [], np.zeros((0, residual.size)), 0.0
    for _ in range(most):
        open_ = seen & (size > 0.02 * np.maximum(information, 1e-300))
        gain = np.where(open_, slope**2 / np.maximum(size, 1e-300), 0.0)
        j = int(np.argmax(gain))
        if gain[j] <= 0.0:
            break
        total += float(gain[j])
        chosen.append(features[j])
        unit = left[j] - (units @ left[j]) @ units
        unit /= np.linalg.norm(unit)
        units = np.vstack([units, unit])
        along = left @ unit
        size, slope = size - along**2, slope - along * (unit @ residual)
        if len(chosen) > 1:
            out.append(Tried(tuple(chosen), total, 1.0))
    return out


def _periodic(state: State, lines: tuple[Sequence[tuple[Feature, Feature]], int], here: Linearised) -> list[Tried]:
    """The moment at a fixed frequency, of any phase, that gains most; lines: those tried, and of how many."""
    waves, of = lines

    def gains(block: Sequence[tuple[Feature, Feature]]) -> np.ndarray:
        both = [f for pair in block for f in pair]
        columns = here.columns([f.axis for f in both], [f.series for f in both])
        information, slope = here.projector.products(columns.reshape(len(block), 2, -1))
        return np.einsum("ij,ijk,ik->i", slope, pinv(information, hermitian=True), slope)

    if not waves:
        return []
    gain = np.concatenate(state.in_threads(gains, _blocks(waves)))
    best = int(np.argmax(gain))
    return [Tried(waves[best], float(gain[best]), np.sqrt(of))]  # one choice for both features


def _bursts(state: State, bursts: Sequence[Sequence[Series]], here: Linearised) -> list[Tried]:
    """The best force that acts for one to eight windows of one record (or of all at the same time), on each axis."""
    windows, est = len(bursts[0]), here.est
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

    axes = range(est.n_forces)
    of_axes = state.in_threads(gains, [(axis, series) for axis in axes for series in bursts])
    gain = np.stack(of_axes).reshape(len(axes), -1)
    out = []
    for axis in axes:
        owner, k = divmod(int(np.argmax(gain[axis])), first.size)
        arrays = tuple(np.sum(parts, axis=0) for parts in zip(*bursts[owner][first[k] : last[k]], strict=True))
        place = est.segments[owner].name if owner < len(est.segments) else "every record"
        pulse = Feature(f"pulse in {place}", axis, arrays, "pulse")
        out.append(Tried((pulse,), float(gain[axis].max()), float(gain.size)))
    return out


def best_unmodelled(state: State, threshold: float, rng: np.random.Generator) -> Candidate | None:
    """The effect outside the bank that gains most after a refit of the noise, if it passes the threshold (log p)."""
    s, now = state.setting, state.now
    threshold -= np.log(SEARCHES)
    gusts = state.point.gusts
    before, gain = gusts.penalised, 2.0 * (now.log_likelihood - gusts.gusty)
    effects = [Candidate(NOT_GUSTS, (), log_tail(gain, 2), gain, s, now, penalised=before)]
    chosen = [t for t in try_features(state, before, rng)[:12] if t.log_p < threshold + 6.0][:2]
    effects += state.in_threads(lambda t: refit_features(state, t, before), chosen)
    effects.sort(key=lambda c: c.log_p)
    return next((c for c in effects if c.log_p < threshold and exceeds_misfit(state, c)), None)


def margin_over_unmodelled(state: State) -> float:
    """Nats by which all that was named beats the best unmodelled effect of the first step; infinite without one."""
    rival = state.rival
    if rival is None or not state.accepted:
        return np.inf
    cost = sum(np.log(a.tests * state.n_effective) + FURTHER_NATS for a in state.accepted) - FURTHER_NATS
    return state.point.gusts.penalised - cost - (rival.penalised - np.log(rival.tests))


def refit_features(state: State, tried: Tried, before: float) -> Candidate:
    """Unmodelled forces or sensor shifts, refitted with the noise; before: penalised likelihood without them."""
    variant = tuple(f.parameter() for f in tried.features)
    setting, now = state.refit(state.setting, variant, 3)
    label = Unmodelled(" + ".join(f.name for f in tried.features))
    refitted = candidate(label, variant, len(variant), tried.tests ** len(variant), before, setting, now)
    left = penalised_likelihood(state.est, setting, now)
    return replace(refitted.with_statistic(2.0 * (left - before)), penalised=left)


def confirmed(state: State, left: Candidate, records: Sequence[Record]) -> bool | None:
    """Whether unmodelled terms, at the size found in training, raise the likelihood of held-out records too.

    None where a term belongs to one training record (a pulse) and says nothing about others.
    """
    est = state.est
    held = estimator(est.model, records, est.unit, est.threads, est.terms)
    s = Setting(np.tile(left.setting.vectors[0], (len(held.segments), 1)), left.setting.noise)
    now = held.evaluate(s)
    by_key = {f.key: f for f in features.features(held, now)}
    for p in left.variant:
        if p.name not in by_key:
            return None
        s = held.moved(s, by_key[p.name].parameter(), est.value(left.setting, p))
    return bool(held.evaluate(s).log_likelihood > now.log_likelihood + 2.0)


RIVALLED_NATS, RIVALLED_LEVEL = 30.0, 0.05
"""How near an unmodelled effect may come to what was named before its sizes are tested at a level of their own, and
that level: right names stand so near where effects are faint, and faint ones' small faults of description do not
show."""


def unexplained(state: State, rng: np.random.Generator) -> Candidate | None:
    """An effect outside the bank that the innovations still show, or that alone beats all that was named.

    What an unmodelled effect comes near to must be the same throughout the records at a level of its own.
    """
    threshold = float(np.log(state.alpha * UNMODELLED))
    effect = best_unmodelled(state, threshold, rng) if state.accepted else state.rival
    if effect is not None and not _is_small_delay(state, effect):
        return effect
    margin = margin_over_unmodelled(state)
    if margin < 0.0:
        return state.rival
    own = {cause: rows for cause, rows in state.effects.items() if len(rows)}
    sizes = tests.size_tests(state.est, state.now, state.point.projector, own) if own else []
    if margin < RIVALLED_NATS and sizes:
        log_p = cauchy_combination([p for _, p in sizes])
        if log_p < np.log(RIVALLED_LEVEL):
            return _without_form(state, smallest(sizes)[0], log_p)
    line = tests.line_test(state.est, state.now)
    label, log_p = smallest(
        [
            *tests.activity_tests(state.est, state.now),
            *tests.whiteness_tests(state.est, state.now),
            *sizes,
            (f"a periodic error at {line[1]:.3g} rad/s", line[0]),
        ]
    )
    allowed = min(threshold, -0.5 * float(misfit_allowance(state).sum()))
    return _without_form(state, label, log_p) if log_p < allowed else None


def _is_small_delay(state: State, candidate: Candidate) -> bool:
    """Whether an unmodelled effect is a heading that is late, or early, by less than the cause of that name counts,
    where the sensors' channels have decided on that cause."""
    tested = any(isinstance(cause, HeadingDelay) for cause in state.bank)
    if tested or [p.name.split(":")[0] for p in candidate.variant] != [YAW_RATE_IN_HEADING]:
        return False
    est = state.est
    rate = state.now.states[:, est.kernels.STATES.index("r")]
    late_s = est.value(candidate.setting, candidate.variant[0]) / float(np.sqrt(np.mean(rate**2)))
    delay = HeadingDelay()
    return not delay.matters(est, delay.variants(est)[0], np.array([late_s]))


def smallest(rows: Sequence[tuple[str, float]]) -> tuple[str, float]:
    """Label of the most significant test, and its log p-value, their number taken into account."""
    label, log_p = min(rows, key=lambda t: t[1])
    return label, log_p + float(np.log(len(rows)))


def _without_form(state: State, label: str, log_p: float) -> Candidate:
    """An effect that shows in a test and has no form of its own."""
    return Candidate(Unmodelled(label), (), log_p, -2.0 * log_p, state.setting, state.now)
