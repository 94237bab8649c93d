"""Noise, discrepancy and the parameters of causes fitted together, the scales of the discrepancy estimated along."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.filters.innovations.derivatives import columns
from ...estimation.filters.innovations.noise_fit import fit_noise
from ...estimation.likelihood.minimiser import Damping, Trial, try_steps
from .quadratic import MOST, START, Quadratic, quadratic, scales, towards_mode
from .terms import NUMBERS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator, Innovations
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Variant
    from .terms import Terms

BLOCK_S = 50.0
"""Length of a block, s of a 160 m ship."""
ROUNDS, ENOUGH, MOVING = 8, 0.3, 3.0
"""Most rounds of a fit, and the rise of the marginal likelihood (nats) below which it ends, or the variances are let
free."""
LOST = 100.0
"""Nats by which a fit must be sure to stay behind another one to end early."""
STATED = np.minimum(MOST, 1.0)
"""Variances that hold first, those of the priors as stated: from far off a fit would be led astray."""
RULE = Damping(growth=10.0, least=0.01, trials=5)
"""Shares of the diagonal of the normal matrix that are added to it: 0, then 0.01 and tenfold each time."""
GOOD, NOTHING = 0.5, 0.1
"""Share of the predicted rise that a good step has, and predicted rise (nats) below which no further one is tried."""
REDUCED, SETTLED = 0.1, 0.01
"""Factor on the damping after a good step at the first trial, and the most of it with which a step counts as
whole."""
BOUND = 0.98
"""Share of the largest variance of the model's numbers from which they are further off than their priors hold."""
FORCE = 3e-5
"""Random forces, in force units, at which the fit of the noise starts: without any, it ends far from the best where the
base model is far off."""
ROUGH = 0.2
"""Nats per step at which the noise counts as fitted within a round."""


@dataclass(frozen=True)
class Base:
    """What all fits share: the records under the filter, the discrepancy, the blocks.

    origin : the setting at which all parameters are zero (it may hold waves or the time of a change).
    """

    est: Estimator
    terms: Terms
    origin: Setting

    @cached_property
    def blocks(self) -> list[tuple[int, int, int]]:
        """(record, first sample, end) of each block."""
        found, est = [], self.est
        for i, d in enumerate(est.segments):
            count = max(3, round(float(d.time[-1]) / (BLOCK_S * est.clock)))
            cuts = (np.linspace(0, d.time.size, count + 1).astype(int) + int(est.edges[i])).tolist()
            found += [(d.record, a, b) for a, b in pairwise(cuts) if b > a]
        return found

    def group(self, variant: Variant) -> np.ndarray:
        """Group of the discrepancy's terms and of further parameters without prior."""
        return np.concatenate([self.terms.group, np.full(len(variant), -1)])

    def bounded(self, x: np.ndarray, variant: Variant) -> np.ndarray:
        """Values with those of the causes inside their bounds."""
        free = len(self.terms.parameters)
        low, high = (np.array([getattr(p, end) for p in variant], float) for end in ("low", "high"))
        return np.concatenate([x[:free], np.clip(x[free:], low, high)])

    def at(self, x: np.ndarray, variant: Variant, like: Setting) -> Setting:
        """The setting with all parameters at x, with the noise of another."""
        est, origin = self.est, self.origin
        vectors, amounts = origin.vectors.copy(), {}
        added: list[np.ndarray] | None = None
        for p, value in zip((*self.terms.parameters, *variant), x.tolist(), strict=True):
            if value == 0.0:
                continue
            if p.series is not None:
                added = added or [np.zeros((d.time.size, est.n_forces + 6)) for d in est.segments]
                for a, series in zip(added, p.series[1], strict=True):
                    a[:, p.series[0]] += value * series
                continue
            weights = [value] * len(p.slots) if p.law is None else p.law(value)
            if p.law is not None:
                amounts[p.name] = value
            for (entry, weight), own in zip(p.slots, weights, strict=True):
                vectors[est.rows(p.record), entry] += own * weight
        return replace(like, vectors=vectors, added=None if added is None else tuple(added), amounts=amounts)


@dataclass(frozen=True)
class Fitted:
    """A fit: values x of the terms and of the causes' parameters, variances of the groups, marginal likelihood."""

    base: Base
    variant: Variant
    setting: Setting
    now: Innovations
    x: np.ndarray
    variances: np.ndarray
    evidence: float

    @property
    def free(self) -> np.ndarray:
        """Places of the causes' parameters."""
        held = len(self.base.terms.parameters)
        return np.arange(held, held + len(self.variant))

    @property
    def sizes(self) -> np.ndarray:
        """Values of the causes' parameters."""
        return self.x[self.free]

    @property
    def at_bound(self) -> bool:
        """Whether the model's numbers are further off than their priors hold: no cause can be told beside them, and
        free runs have to say more."""
        return bool(self.variances[NUMBERS] >= BOUND * MOST[NUMBERS])

    @cached_property
    def expansion(self) -> Quadratic:
        """The quadratic at the fit."""
        return expanded(self.base, self.setting, self.now, self.x, self.variant)


def expanded(
    base: Base, s: Setting, now: Innovations, x: np.ndarray, variant: Variant, more: np.ndarray | None = None
) -> Quadratic:
    """The quadratic at a setting; more : columns of the last of the variant's parameters, where they are known."""
    known = 0 if more is None else len(more)
    told = [*base.terms.parameters, *variant[: len(variant) - known]]
    rows = columns(base.est, s, told)
    rows = rows if more is None else np.vstack([rows, more])
    group, least = base.group(variant), base.terms.least_side
    return quadratic(rows, now.e, x, base.blocks, group, now.log_likelihood, least)


def fit(
    base: Base,
    s: Setting,
    variant: Variant = (),
    start: np.ndarray | None = None,
    variances: np.ndarray | None = None,
    rounds: int = ROUNDS,
    terms: np.ndarray | None = None,
    rival: float = -np.inf,
) -> Fitted:
    """Noise, discrepancy and parameters of causes of largest marginal likelihood.

    Eq. 9 of docs/mathematics/default-route.md.

    s : its noise is where the noise's fit starts.  start, terms : values of the causes' parameters and of the
    discrepancy's, zero unless given.  rival : marginal likelihood of another fit: this one ends where it would stay
    behind that by LOST even if each further round gained as much as the last.
    """
    est, free = base.est, len(base.terms.parameters)
    x = np.concatenate([np.zeros(free) if terms is None else terms, np.zeros(len(variant)) if start is None else start])
    s, now = fit_noise(est, base.at(x, variant, with_forces(s)), 4, ROUGH)
    causes = np.arange(free, x.size)
    variances = START if variances is None else variances
    best: Fitted | None = None
    settled, before, most = True, -np.inf, STATED if np.all(variances <= STATED) else MOST
    damping = 0.0
    for left in reversed(range(rounds)):
        q = expanded(base, s, now, x, variant)
        if settled:  # far from the mode the quadratic says nothing of the variances
            variances = np.minimum(scales(q, causes, (variances, START))[0], most)
        trial, damping = _stepped(base, s, now, x, q, variances, variant, damping)
        if trial.better:
            x, s, now = trial.point.x, trial.point.setting, trial.point.now
            settled = trial.damping <= SETTLED
            s, now = fit_noise(est, s, 2, ROUGH)
            evidence = _evidence(q, x, variances, now.log_likelihood)
            if best is None or evidence > best.evidence:
                best = Fitted(base, variant, s, now, x, variances, evidence)
            rise, before = evidence - before, evidence
            if evidence + left * rise < rival - LOST:
                break
            if rise > (ENOUGH if most is MOST else MOVING):
                continue
        if most is MOST or not np.any(variances == most):
            break
        settled, most = True, MOST
    if best is None:
        evidence = _evidence(expanded(base, s, now, x, variant), x, variances, now.log_likelihood)
        best = Fitted(base, variant, s, now, x, variances, evidence)
    return best


def with_forces(s: Setting) -> Setting:
    """A setting with random forces in every axis."""
    noise = s.noise
    return s if noise.has_forces else replace(s, noise=replace(noise, force_sd=np.full(noise.force_sd.size, FORCE)))


class _Point(NamedTuple):
    """Values, the setting there, and its innovations; cost : negative penalised log likelihood."""

    x: np.ndarray
    setting: Setting
    now: Innovations
    cost: float


def _stepped(
    base: Base, s: Setting, now: Innovations, x: np.ndarray, q: Quadratic, variances: np.ndarray, variant: Variant,
    damping: float,
) -> tuple[Trial[_Point], float]:  # fmt: skip
    """The last of the steps towards the mode, damped until the penalised likelihood rises, and the damping of the next.

    Where it falls the noise is fitted before it counts: another inertia makes other motions of the same random forces.
    """
    held = len(base.terms.parameters)
    weight = 1.0 / variances[base.terms.group]

    def cost(at: np.ndarray, found: Innovations) -> float:
        return 0.5 * float(np.sum(weight * at[:held] ** 2)) - found.log_likelihood

    here = cost(x, now)

    def reached(change: np.ndarray) -> _Point:
        trial = base.bounded(x + change, variant)
        there = base.at(trial, variant, s)
        found = base.est.evaluate(there, traced=True)  # the noise is fitted from there in any case
        if not cost(trial, found) < here:
            there, found = fit_noise(base.est, there, 2, ROUGH)
        return _Point(trial, there, found, cost(trial, found))

    step = partial(towards_mode, q, variances, np.arange(held, x.size), x)
    trial = try_steps(step, reached, here - 1e-6, damping, NOTHING, RULE)
    good = trial.number == 0 and here - trial.point.cost > GOOD * trial.predicted
    return trial, trial.damping * (REDUCED if good else 1.0)


def _evidence(q: Quadratic, x: np.ndarray, variances: np.ndarray, log_likelihood: float) -> float:
    """Marginal log likelihood at values that were reached: Laplace's formula with the curvature of q.

    Eq. 9 of docs/mathematics/default-route.md.
    """
    held = np.flatnonzero(q.group >= 0)
    root = np.sqrt(variances[q.group[held]])
    matrix = np.eye(held.size) + np.outer(root, root) * q.total[0][np.ix_(held, held)]
    penalty = 0.5 * float(np.sum((x[held] / root) ** 2))
    return log_likelihood - penalty - 0.5 * float(np.linalg.slogdet(matrix)[1])
