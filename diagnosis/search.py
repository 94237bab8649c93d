"""Forward selection over the bank: screen, refit the leaders, rank, accept, delete, screen again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..methods.innovations.estimator import SYMBOLS, Estimator, Innovations, Parameter, Setting
from ..models.model import CHANNELS
from . import unknown
from .causes import CAUSES, Cause, Variant, starts
from .evidence import Projector, Score, canonical_correlation, effective_number, independent, log_tail
from .unknown import Feature

if TYPE_CHECKING:
    from ..datasets.record import Record

LEADERS = 6
QUICK = 2
"""Steps of every leader's refit; those near the best go on."""
RACE_NATS, RACE_SHARE = 10.0, 0.3
"""How far behind the best a candidate may be, in nats or as a share of the best, and still be refitted to the end."""
TIE_NATS = 4.6
MOST_TIED = 2
TIE_CORRELATION = 0.5
"""Canonical correlation of their projected sensitivities below which two causes are no tie."""
FAULT_GRID = 12
SHARE_FIRST, SHARE_LATER, SHARE_UNKNOWN = 0.5, 0.2, 0.3
"""How the family-wise level is spent: first cause, later ones, effects outside the bank."""
IN_SPAN = 1e-3
"""Share of a cause's information that must survive the nuisance, else it is not testable."""
MIMICRY = 4e-4
"""Share of the accepted causes' strength that further ones must exceed: 2 % of their effect, as no cause (a rudder's
corners between samples, a limit's onset) is described to better than that."""
DEGREE = np.pi / 180.0


@dataclass(frozen=True)
class Screened:
    """One cause's best variant by its score."""

    cause: str
    variant: Variant
    log_p: float
    score: Score
    start: tuple[float, ...] = ()
    tests: float = 1.0


@dataclass(frozen=True)
class Candidate:
    """A cause after refitting it with the noise: twice the gain in log likelihood and its log p-value."""

    cause: str
    variant: Variant
    log_p: float
    statistic: float
    setting: Setting
    now: Innovations
    feature: bool = False
    tests: float = 1.0
    k: int = 0
    """Number of variants or starts that were tried, and degrees of freedom."""


@dataclass
class Search:
    """The state of the selection."""

    est: Estimator
    start: Setting
    setting: Setting
    now: Innovations
    bank: dict[str, list[Variant]]
    rng: np.random.Generator
    alpha: float
    nuisance: tuple[Parameter, ...] = ()
    prior: np.ndarray | None = None
    accepted: list[Candidate] = field(default_factory=list)
    ties: dict[str, tuple[str, ...]] = field(default_factory=dict)
    n_effective: float = 25.0
    first_screen: dict[str, Screened] = field(default_factory=dict)
    first_candidates: list[Candidate] = field(default_factory=list)
    rival: Candidate | None = None
    in_span: set[str] = field(default_factory=set)
    n_features: float = 100.0

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All that a refit moves: free coefficients, then those of the accepted causes."""
        return (*self.nuisance, *(p for a in self.accepted for p in a.variant))

    def precisions(self, extra: int) -> np.ndarray | None:
        """Prior precisions of the parameters followed by `extra` more, None without a prior."""
        if self.prior is None:
            return None
        return np.concatenate([self.prior, np.zeros(len(self.parameters) - len(self.nuisance) + extra)])

    def refit(self, s: Setting, extra: Variant = (), most: int = 6) -> tuple[Setting, Innovations]:
        """Parameters and noise of largest likelihood, from the gusts at hand and, if any are left, from none.

        Gusts that were fitted while an effect was missing hide how far the effect's size still is from its best.
        """
        moved = [*self.parameters, *extra]
        found, now = self.est.refit(s, moved, most, self.precisions(len(extra)))
        if moved and found.noise[6 : 6 + self.est.n_forces].any():
            still, calm = self.est.refit(self.quiet(found), moved, most, self.precisions(len(extra)))
            if calm.log_likelihood > now.log_likelihood:
                return still, calm
        return found, now

    def quiet(self, s: Setting) -> Setting:
        """The setting under the sensors' noise alone."""
        return replace(s, noise=self.start.noise.copy())


# ---- screening
def screen(search: Search, s: Setting, now: Innovations, count: bool = False) -> list[Screened]:
    """Score of every cause not accepted yet, best variant each, best first; `count`: find the effective number."""
    est = search.est
    fixed = est.column(s, now, search.parameters) if search.parameters else np.zeros((0, now.e.size))
    projector = Projector(now, fixed, search.precisions(0))
    used = {a.cause for a in search.accepted}
    out, families = [], []
    for name, variants in search.bank.items():
        if name in used or name == "rudder_fault" or name in ATTEMPTS:
            continue
        if CAUSES[name].profile:
            out.append(_screen_profile(search, s, now, projector, name))
            continue
        columns = _variant_columns(est, s, now, variants)
        scores = [projector.score(c) for c in columns]
        if all(score.share < IN_SPAN for score in scores):
            search.in_span.add(name)
            continue
        families.append(columns)
        ranked = [
            log_tail(score.statistic, len(v)) + np.log(len(variants)) for score, v in zip(scores, variants, strict=True)
        ]
        best = int(np.argmin(ranked))
        out.append(Screened(name, variants[best], float(ranked[best]), scores[best]))
    if "rudder_fault" in search.bank and "rudder_fault" not in used:
        out.append(_screen_fault(search, s, now, projector))
    if count:
        scored = effective_number(projector, families, search.rng) if families else 0.0
        search.n_effective = scored + 1.0
    return sorted(out, key=lambda c: c.log_p)


def _variant_columns(est: Estimator, s: Setting, now: Innovations, variants: Sequence[Variant]) -> list[np.ndarray]:
    """Columns (k, n) of each variant; a parameter that stands in several is run once."""
    unique: dict[tuple, Parameter] = {}
    for variant in variants:
        for p in variant:
            unique.setdefault((p.name, p.slots, p.record), p)
    rows = dict(zip(unique, est.scores(s, now, list(unique.values())), strict=True))
    return [np.stack([rows[p.name, p.slots, p.record] for p in variant]) for variant in variants]


def _screen_fault(search: Search, s: Setting, now: Innovations, projector: Projector) -> Screened:
    """Loss of effectiveness from a change time on, over a grid of times, in all records or one."""
    est = search.est
    longest = max(d.time[-1] for d in est.data)
    at = est.index["fault_time"]
    columns, places = [], []
    owners = [None, *range(len(est.data))] if len(est.data) > 1 else [0]
    for t in np.linspace(0.0, longest, FAULT_GRID + 2)[1:-1]:
        p = s.p.copy()
        p[:, at] = t
        column = est.column(replace(s, p=p), now, fault_variant(est, None)[:1])[0].reshape(-1, 6)
        for record in owners:
            rows = slice(None) if record is None else slice(est.edges[record], est.edges[record + 1])
            part = np.zeros_like(column)
            part[rows] = column[rows]
            columns.append(part.ravel())
            places.append((record, float(t)))
    best, score, tests = _supremum(search, projector, np.stack(columns))
    record, t = places[best]
    log_p = log_tail(score.statistic, 1) + np.log(tests)
    start = (float(score.step[0]), t)
    return Screened("rudder_fault", fault_variant(est, record), log_p, score, start, tests)


def _supremum(search: Search, projector: Projector, columns: np.ndarray) -> tuple[int, Score, float]:
    """The column (m, n) of largest score, and how many independent tests the choice among them amounts to.

    What a change time or a time constant is under the null is not identified: the largest score over its values is
    calibrated by multiplier bootstrap of all scores together (the recorded rudder is used again).
    """
    scores = [projector.score(column[None]) for column in columns]
    best = int(np.argmax([score.statistic for score in scores]))
    return best, scores[best], independent(search.rng, projector.project(columns), projector.residual)


def _screen_profile(search: Search, s: Setting, now: Innovations, projector: Projector, name: str) -> Screened:
    """The first parameter's score over values of the second, which means nothing while the first is zero."""
    est, (variant,) = search.est, search.bank[name]
    first, second = variant
    values = [x * est.clock - est.base[second.slots[0][0]] for x in CAUSES[name].profile]
    columns = np.vstack([est.column(est.at(s, second, value), now, (first,)) for value in values])
    best, score, tests = _supremum(search, projector, columns)
    log_p = log_tail(score.statistic, 1) + np.log(tests)
    return Screened(name, variant, log_p, score, (float(score.step[0]), values[best]), tests)


def fault_variant(est: Estimator, record: int | None) -> Variant:
    """Effectiveness 1 + e from time t0 (s) on."""
    e = Parameter("e", "1", ((est.index["fault"], 1.0),), record, -1.0, 1.0, 0.02)
    return (e, Parameter("t0", "s", ((est.index["fault_time"], 1.0),), record, 0.0, float(est.data[0].time[-1]), 1.0))


# ---- refitting
def refit_cause(search: Search, item: Screened, before: float) -> Candidate:
    """The cause with parameters and noise refitted from the best of its starts."""
    est, s = search.est, search.setting
    entry, variant = CAUSES[item.cause], item.variant
    tests = float(len(search.bank[item.cause]))
    if item.cause == "rudder_fault":
        found, now = _refit_fault(search, item)
        k, tests = 2, item.tests
    elif entry.profile:
        first, second = variant
        s = est.at(est.at(s, second, item.start[1]), first, item.start[0])
        s, _ = search.refit(s, (first,), 2)
        found, now = search.refit(s, variant, QUICK)
        k = 2
    else:
        if entry.rings:
            s = _ring_start(est, s, entry, variant)
        elif entry.scan:
            options = list(starts(est, s, entry, variant))
            s = options[int(np.argmax([n.log_likelihood for n in est.many(options)]))]
        found, now = search.refit(s, variant, QUICK)
        k = len(variant)
    return _candidate(item.cause, variant, k, tests, before, found, now)


def _candidate(
    cause: str, variant: Variant, k: int, tests: float, before: float, setting: Setting, now: Innovations
) -> Candidate:
    statistic = 2.0 * (now.log_likelihood - before)
    return Candidate(cause, variant, log_tail(statistic, k) + np.log(tests), statistic, setting, now, tests=tests, k=k)


def refined(search: Search, found: Sequence[Candidate], before: float) -> list[Candidate]:
    """The leaders among candidates refitted to the end; what is far behind after the first steps stays as it is."""
    best = max((c.statistic for c in found), default=0.0)
    out = []
    for c in found:
        if c.statistic > best - max(2.0 * RACE_NATS, RACE_SHARE * best):
            setting, now = search.est.refit(
                c.setting, [*search.parameters, *c.variant], 8, search.precisions(len(c.variant))
            )
            c = _candidate(c.cause, c.variant, c.k, c.tests, before, setting, now)
        out.append(c)
    return out


def _ring_start(est: Estimator, s: Setting, entry: Cause, variant: Variant) -> Setting:
    """Each record's (north, east) pair at the best of several sizes and eight directions."""
    clock = est.clock if entry.id != "wave_drift" else 1.0
    trials = [(0.0, 0.0)] + [
        (ring * clock * np.cos(a), ring * clock * np.sin(a)) for ring in entry.rings for a in np.arange(8) * np.pi / 4.0
    ]
    settings = []
    for north, east in trials:
        moved = s
        for j, p in enumerate(variant):
            moved = est.at(moved, p, north if j % 2 == 0 else east)
        settings.append(moved)
    found = est.many(settings)
    for i in range(len(est.data)):
        rows = slice(est.edges[i], est.edges[i + 1])
        gains = [-np.sum(n.log_s[rows]) - 0.5 * np.sum(n.e[rows] ** 2) for n in found]
        north, east = trials[int(np.nanargmax(gains))]
        own = [p for p in variant if p.record == i]
        s = est.at(est.at(s, own[0], north), own[1], east)
    return s


def _refit_fault(search: Search, item: Screened) -> tuple[Setting, Innovations]:
    est, (e, t0) = search.est, item.variant
    s = est.at(est.at(search.setting, t0, item.start[1]), e, float(np.clip(item.start[0], -0.8, 0.8)))
    s, _ = search.refit(s, (e,), 2)
    width = est.data[0].time[-1] / FAULT_GRID
    shifts = [est.at(s, t0, item.start[1] + share * width) for share in (-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6)]
    s = shifts[int(np.argmax([n.log_likelihood for n in est.many(shifts)]))]
    return search.refit(s, (e, t0), QUICK)


def refit_features(search: Search, features: Sequence[Feature], before: float, tests: float) -> Candidate:
    """Unknown forces or sensor shifts, refitted with the noise."""
    variant = tuple(f.parameter(search.est) for f in features)
    found, now = search.refit(search.setting, variant, 3)
    statistic = 2.0 * (now.log_likelihood - before)
    k = len(variant)
    name = " + ".join(f"{f.name}" for f in features)
    return Candidate(
        f"unknown:{name}", variant, log_tail(statistic, k) + k * np.log(tests), statistic, found, now, True
    )


def try_waves(search: Search, before: float) -> Candidate | None:
    """Narrow-band motion on heading and yaw rate: scanned, then refined by a bounded simplex search."""
    from scipy.optimize import minimize

    est, s = search.est, search.setting
    if not est.channels[:2].any():
        return None
    clock = est.clock
    slots = [est.index[n] for n in ("wave_frequency", "wave_damping", "wave_rms")]
    low = np.log([0.25 / clock, 0.02, 1e-5])
    high = np.log([2.2 / clock, 0.5, 0.2])

    def at(base: Setting, values: Sequence[float] | np.ndarray) -> Setting:
        p = base.p.copy()
        p[:, slots] = values
        return replace(base, p=p)

    quiet = s.noise.copy()
    quiet[:6] = np.minimum(quiet[:6], 1.05 * search.start.noise[:6])
    options = []
    for gusts in (1.0, 0.0):
        noise = quiet.copy()
        noise[6 : 6 + est.n_forces] *= gusts
        for omega in (0.4, 0.55, 0.75, 1.0):
            for rms in (0.03 * DEGREE, 0.12 * DEGREE, 0.5 * DEGREE):
                options.append(at(replace(s, noise=noise), (omega / clock, 0.1, rms)))
        if not s.noise[6 : 6 + est.n_forces].any():
            break
    gains = [n.log_likelihood for n in est.many(options)]
    best = int(np.argmax(gains))
    if gains[best] < before + 4.0:
        return None
    s = options[best]
    x = np.log(s.p[0, slots])
    for _ in range(3):
        s, _ = est.fit_noise(s, 3)

        def cost(y: np.ndarray, base: Setting = s) -> float:
            inside = np.clip(y, low, high)
            return -est.evaluate(at(base, np.exp(inside))).log_likelihood + 10.0 * float(np.sum((y - inside) ** 2))

        simplex = x + np.vstack([np.zeros(3), 0.15 * np.eye(3)])
        x = np.clip(
            minimize(cost, x, method="Nelder-Mead", options={"maxfev": 35, "initial_simplex": simplex}).x, low, high
        )
        s = at(s, np.exp(x))
    s, now = search.refit(s, (), 3)
    return _candidate("wave_motion", (), 3, 4.0, before, s, now)


def try_jitter(search: Search, before: float) -> Candidate | None:
    """Errors of the sampling instants: scanned if squared innovations grow with the channels' rates of change."""
    if unknown.rate_statistic(search.est, search.now) < 2.5:
        return None
    step = float(np.median(np.diff(search.est.data[0].time)))
    return _scanned(search, "clock_jitter", "clock", [share * step for share in (0.03, 0.1, 0.3)], before)


def try_limit(search: Search, cause: str, slot: str, before: float) -> Candidate | None:
    """A limit on the command's rate or angle: scanned below the largest value seen."""
    d = search.est.data
    quiet = [unknown.lagged(x.rudder, x.time, 1.5 * float(np.median(np.diff(x.time)))) for x in d]
    if slot == "rudder_rate":
        seen = max(float(np.max(np.abs(np.diff(q) / np.diff(x.time)))) for q, x in zip(quiet, d, strict=True))
    else:
        seen = max(float(np.max(np.abs(q))) for q in quiet)
    return _scanned(search, cause, slot, [share * seen for share in (0.97, 0.9, 0.8, 0.6, 0.4, 0.2)], before)


def _scanned(search: Search, cause: str, slot: str, values: Sequence[float], before: float) -> Candidate | None:
    """The best value of one entry of the parameter vector, scanned and then refined in its logarithm."""
    from scipy.optimize import minimize_scalar

    est, s = search.est, search.setting
    index = est.index[slot]

    def at(value: float) -> tuple[Setting, Innovations]:
        p = s.p.copy()
        p[:, index] = value
        return est.fit_noise(replace(s, p=p), 2)

    gains = [at(value)[1].log_likelihood for value in values]
    best = int(np.argmax(gains))
    if gains[best] < before + 2.0:
        return None
    ends = np.log([values[max(best - 1, 0)], values[min(best + 1, len(values) - 1)]])
    low, high = min(ends) - 0.3 * (best == 0), max(ends) + 0.3 * (best == len(values) - 1)
    found: Any = minimize_scalar(
        lambda x: -at(float(np.exp(x)))[1].log_likelihood, bounds=(low, high), options={"xatol": 0.01, "maxiter": 14}
    )
    (variant,) = search.bank[cause]
    setting, now = search.refit(at(float(np.exp(found.x)))[0], variant, 2)
    return _candidate(cause, variant, 1, 2.0, before, setting, now)


# ---- unknown effects
GUST_LEVELS = (0.0, 0.03, 0.2, 1.0)
"""Shares of the fitted gusts' sd at which features are tried: what explains their motion needs none."""


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


NOT_GUSTS = "unknown:a force that does not act on surge, sway and yaw at once, as gusts do"
GUST_X, GUST_Y = (1.0, 2.7), (2.2, 12.0)
"""Range of the sd of gusts in surge and in sway over that in yaw (moment over L), from hulls and superstructures."""


def gust_like(search: Search) -> float:
    """Log likelihood of the best noise whose forces are in the proportions of gusts."""
    est, s, now = search.est, search.setting, search.now
    sd = s.noise[6 : 6 + est.n_forces]
    if est.n_forces != 3 or not sd.any():
        return now.log_likelihood
    largest = max(sd[2], sd[1] / GUST_Y[0], sd[0] / GUST_X[0])
    settings = []
    for yaw in np.geomspace(0.02 * largest, 1.5 * largest, 14):
        noise = s.noise.copy()
        noise[6:9] = [np.clip(sd[0], *np.multiply(GUST_X, yaw)), np.clip(sd[1], *np.multiply(GUST_Y, yaw)), yaw]
        settings.append(replace(s, noise=noise))
    still = s.noise.copy()
    still[6:9] = 0.0
    settings.append(replace(s, noise=still))
    found = max(n.log_likelihood for n in est.many(settings))
    return min(found, now.log_likelihood)


def try_features(search: Search, before: float) -> list[Tried]:
    """Features, sets of them and pulses by the likelihood that one step and a level of gusts give, best first."""
    est, s = search.est, search.setting
    found = unknown.features(est, s, search.now, est.clock)
    windows = [(axis, w) for axis in range(est.n_forces) for w in unknown.pulses(est, axis)]
    axes = [f.axis for f in found] + [axis for axis, _ in windows]
    series = [f.series for f in found] + [w[2] for _, w in windows]
    n = len(found)
    gusty = bool(s.noise[6 : 6 + est.n_forces].any())
    best: dict[tuple[str, ...], Tried] = {}
    for level in GUST_LEVELS if gusty else (1.0,):
        noise = np.where(level == 0.0, search.start.noise, s.noise)
        noise[6 : 6 + est.n_forces] = level * s.noise[6 : 6 + est.n_forces]
        noise[6 + est.n_forces] = s.noise[6 + est.n_forces]
        at = replace(s, noise=noise)
        now = search.now if level == 1.0 else est.evaluate(at)
        if now.log_likelihood <= -1e299 or np.abs(now.e).max() > 1e4:
            continue
        fixed = est.column(at, now, search.parameters) if search.parameters else np.zeros((0, now.e.size))
        projector = Projector(now, fixed, search.precisions(0))
        if level < 1.0:
            projector.residual = now.e.ravel()
        columns = est.responses(at, axes, series)
        left = projector.project(columns)
        told = np.einsum("ij,ij->i", left, left) > IN_SPAN * np.maximum(np.einsum("ij,ij->i", columns, columns), 1e-300)
        if level == 1.0:
            search.n_features = independent(search.rng, left[:n][told[:n]], projector.residual)
        loss = 2.0 * (now.log_likelihood - before)
        for t in [
            *_sets(found, left[:n], projector.residual, told[:n]),
            *_bursts(est, windows, left[n:], projector.residual),
        ]:
            key = tuple(f"{f.name}:{f.axis}" for f in t.features)
            gain = t.gain + loss
            if key not in best or gain > best[key].gain:
                best[key] = replace(t, gain=gain)
    out = [replace(t, tests=search.n_features) if t.features[0].family != "pulse" else t for t in best.values()]
    return sorted(out, key=lambda t: t.log_p)


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


def _bursts(est: Estimator, windows, left: np.ndarray, residual: np.ndarray) -> list[Tried]:
    """The best force that acts for one to eight windows of one record, on each axis."""
    gradient = -left @ residual
    out = []
    for axis in range(est.n_forces):
        best: tuple[float, list[int]] = (0.0, [])
        for i in range(len(est.data) + 1):  # the last: all records at the same time
            own = [j for j, (a, w) in enumerate(windows) if a == axis and w[0] == i]
            slope, cross = gradient[own], left[own] @ left[own].T
            for a in range(len(own)):
                for b in range(a + 1, min(a + 9, len(own) + 1)):
                    information = cross[a:b, a:b].sum()
                    if information > 0.0:
                        gain = float(slope[a:b].sum() ** 2 / information)
                        best = max(best, (gain, own[a:b]), key=lambda z: z[0])
        if best[1]:
            arrays = tuple(np.sum([windows[j][1][2][r] for j in best[1]], axis=0) for r in range(len(est.data)))
            tests = 3.0 * len(windows)
            record = windows[best[1][0]][1][0]
            place = est.data[record].name if record < len(est.data) else "every record"
            out.append(
                Tried(
                    (Feature(f"pulse in {place}", axis, arrays, "pulse"),),
                    best[0],
                    tests,
                )
            )
    return out


def best_unknown(search: Search, before: float, threshold: float) -> Candidate | None:
    """The unknown effect that gains most after a refit of the noise, if it passes the threshold (log p)."""
    gain = 2.0 * (before - gust_like(search))
    if log_tail(gain, 2) < threshold:
        found = [Candidate(NOT_GUSTS, (), log_tail(gain, 2), gain, search.setting, search.now, True)]
    else:
        found = []
    before -= 0.5 * gain
    chosen = [t for t in try_features(search, before)[:12] if t.log_p < threshold + 6.0][:2]
    found += [refit_features(search, t.features, before, t.tests) for t in chosen]
    least = mimicry(search)
    passed = [c for c in found if c.log_p < threshold and c.statistic > least]
    return min(passed, key=lambda c: c.log_p) if passed else None


# ---- selection
def select(search: Search, most: int) -> None:
    """Accept causes one after the other while they pass the family-wise level."""
    settle(search)
    for step in range(most):
        before = search.now.log_likelihood
        candidates = _candidates(search, step, before)
        share = SHARE_FIRST if step == 0 else SHARE_LATER / max(most - 1, 1)
        threshold = np.log(search.alpha * share / search.n_effective)
        candidates.sort(key=lambda c: c.log_p)
        if step == 0:
            search.first_candidates = candidates
            search.rival = best_unknown(search, before, np.log(search.alpha * SHARE_UNKNOWN))
        least = mimicry(search)
        passed = [c for c in candidates if c.log_p < threshold and c.statistic > least]
        if not passed:
            return
        accept(search, passed)


def mimicry(search: Search) -> float:
    """Evidence that the accepted causes leave behind because no cause describes a large effect exactly."""
    return MIMICRY * sum(strengths(search)) if search.accepted else 0.0


def strengths(search: Search) -> list[float]:
    """Squares of the accepted causes' sizes in units of their standard errors, or their statistics where larger."""
    found, spread, at = [], covariance(search), len(search.nuisance)
    for a in search.accepted:
        k = 1 if CAUSES[a.cause].profile or a.cause == "rudder_fault" else len(a.variant)
        size = np.array([search.est.value(search.setting, p) for p in a.variant[:k]])
        block = spread[at : at + k, at : at + k]
        wald = float(size @ np.linalg.pinv(block, hermitian=True) @ size) if a.variant else 0.0
        found.append(max(wald, a.statistic))
        at += len(a.variant)
    return found


def settle(search: Search) -> None:
    """Noise (and free coefficients) of largest likelihood at the present causes."""
    if search.parameters and not search.accepted:
        search.setting, search.now = search.refit(search.setting, (), 3)
    before = search.now.log_likelihood
    search.setting, search.now = search.est.settle(search.setting, search.start)
    if search.parameters and search.now.log_likelihood > before + 0.05:
        search.setting, search.now = search.refit(search.setting, (), 3)


def _candidates(search: Search, step: int, before: float) -> list[Candidate]:
    items = screen(search, search.setting, search.now, count=step == 0)
    if step == 0:
        search.first_screen = {i.cause: i for i in items}
    level = np.log(0.1 / search.n_effective)
    chosen = [i for i in items if i.log_p < level][:LEADERS]
    if search.setting.noise[6 : 6 + search.est.n_forces].any():
        bare = search.quiet(search.setting)
        now = search.est.evaluate(bare)
        if now.log_likelihood > -1e299 and np.abs(now.e).max() < 1e3:
            have = {i.cause for i in chosen}
            chosen += [i for i in screen(search, bare, now)[:3] if i.log_p < -25.0 and i.cause not in have]
    found = [refit_cause(search, item, before) for item in chosen]
    named = {a.cause for a in search.accepted}
    for name, attempt in ATTEMPTS.items():
        candidate = attempt(search, before) if name in search.bank and name not in named else None
        found += [candidate] if candidate is not None else []
    return refined(search, found, before)


ATTEMPTS: dict[str, Callable[[Search, float], Candidate | None]] = {
    "wave_motion": try_waves,
    "clock_jitter": try_jitter,
    "rudder_rate_limit": lambda search, before: try_limit(search, "rudder_rate_limit", "rudder_rate", before),
    "rudder_saturation": lambda search, before: try_limit(search, "rudder_saturation", "rudder_limit", before),
}
"""Causes that are scanned instead of scored: their derivative at the null says nothing."""


def accept(search: Search, passed: Sequence[Candidate]) -> None:
    """Enter the best candidate, note its ties, refit everything and drop earlier causes that lost their evidence."""
    best = passed[0]
    near = [c for c in passed[1:] if c.log_p - best.log_p < TIE_NATS]
    search.ties[best.cause] = tuple(c.cause for c in near if alike(search, best, c))[:MOST_TIED]
    search.setting, search.now = best.setting, best.now
    search.accepted.append(best)
    settle(search)
    _delete(search)


def alike(search: Search, first: Candidate, second: Candidate) -> bool:
    """Whether two causes move the innovations alike, each at its own size: else both may be true at once."""
    if not (first.variant and second.variant):
        return True
    est = search.est
    fixed = est.column(search.setting, search.now, search.parameters) if search.parameters else np.zeros((0, 1))
    projector = Projector(search.now, fixed, search.precisions(0))
    columns = [est.column(c.setting, c.now, c.variant) for c in (first, second)]
    return canonical_correlation(projector, *columns) > TIE_CORRELATION


def _delete(search: Search) -> None:
    """Backward deletion of causes other than the last that no longer gain significantly."""
    for old in search.accepted[:-1]:
        if not old.variant:
            continue
        bare = search.setting
        for p in old.variant:
            bare = search.est.at(bare, p, 0.0)
        kept = [a for a in search.accepted if a is not old]
        trial = replace(search, accepted=kept)
        setting, now = trial.refit(bare, (), 4)
        gain = 2.0 * (search.now.log_likelihood - now.log_likelihood)
        if log_tail(gain, len(old.variant)) > np.log(search.alpha / search.n_effective):
            search.accepted, search.setting, search.now = kept, setting, now
            search.ties.pop(old.cause, None)


def size_tests(search: Search) -> list[tuple[str, float]]:
    """Log p-values of the accepted causes having one size throughout."""
    est, at, own = search.est, len(search.nuisance), {}
    columns = est.column(search.setting, search.now, search.parameters) if search.parameters else np.zeros((0, 1))
    for a in search.accepted:
        if a.variant:
            own[a.cause] = columns[at : at + len(a.variant)]
        at += len(a.variant)
    projector = Projector(search.now, columns, search.precisions(0))
    return unknown.size_tests(est, search.now, projector, own) if own else []


def covariance(search: Search) -> np.ndarray:
    """Covariance of `search.parameters` at the present setting."""
    if not search.parameters:
        return np.zeros((0, 0))
    d = search.est.column(search.setting, search.now, search.parameters)
    fisher = d @ d.T
    prior = search.precisions(0)
    fisher += np.diag(prior) if prior is not None else 0.0
    scale = np.sqrt(np.diag(fisher)) + 1e-300
    return np.linalg.pinv(fisher / np.outer(scale, scale), rcond=1e-12, hermitian=True) / np.outer(scale, scale)


def channel_name(c: int) -> str:
    """Record channel of one of the filter's six."""
    return CHANNELS[SYMBOLS[c]]


def confirmed(search: Search, left: Candidate, records: Sequence[Record]) -> bool | None:
    """Whether unexplained terms, at the size found in training, raise the likelihood of held-out records too.

    None where a term belongs to one training record (a pulse) and says nothing about others.
    """
    est = search.est
    held = Estimator(est.model, records, est.unit)
    s = Setting(np.tile(search.setting.p[0], (len(held.data), 1)), search.setting.noise)
    now = held.evaluate(s)
    found = {(f.name, f.axis): f for f in unknown.features(held, s, now, held.clock)}
    for p in left.variant:
        name, _, axis = p.name.rpartition(":")
        feature = found.get((name, int(axis)))
        if feature is None:
            return None
        s = held.moved(s, feature.parameter(held), est.value(left.setting, p))
    return bool(held.evaluate(s).log_likelihood > now.log_likelihood + 2.0)
