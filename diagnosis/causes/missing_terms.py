"""Causes in the equations: terms that the model lacks, in the vessel's own prime system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ...estimation.filters.innovations.settings import Parameter
from ...estimation.filters.innovations.vector import SYMBOLS
from ..innovations.searches import ByProfile, ByScore
from .base import NEEDS_3DOF, Cause, NotTestable, require_3dof, term

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.segments import Segment
    from ..free_runs.motion import Motion
    from ..innovations.state import Variant

HEADING, YAW_RATE = SYMBOLS.index("psi"), SYMBOLS.index("r")


class Term(NamedTuple):
    """A term of the equations: its name as a size, its entry in the filter's vector, which is the parameter of the
    extension, the standard deviation of its prior in the prime system, and its unit.

    factors : of v' = v/U and r' = r L/U, whose product it is along the measured motion (`Motion.product`); none of a
    constant one.
    """

    name: str
    entry: str
    sd: float
    factors: tuple[str, ...] = ()
    unit: str = "1"

    @property
    def axis(self) -> str:
        """X, Y or N."""
        return self.entry.partition("_")[2][0]

    def along(self, motion: Motion) -> np.ndarray:
        """Force, N, or moment, N m, (N,) along a motion, for a parameter of one: F = F' rho/2 A U^2 and
        N = N' rho/2 A L U^2, A = L d where the family knows d, as `models.families.extensions` has them."""
        return motion.unit(self.axis) * motion.product(self.factors)


class MissingTerm(Cause):
    """Base class of terms that act each by itself or all together.

    in_response : why a response model has no place for them; empty where it has.
    """

    where = "hull"
    search = ByScore()
    terms: ClassVar[tuple[Term, ...]]
    in_response: ClassVar[str] = ""

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if self.in_response:
            require_3dof(est, self.in_response)
        if not {one.entry for one in self.terms} <= set(est.index):
            raise NotTestable("the model has this term already, or no place for it")
        single = [self.parameter(est, one) for one in self.terms]
        return [*((p,) for p in single), *([tuple(single)] if len(single) > 1 else [])]

    def parameter(self, est: Estimator, one: Term) -> Parameter:
        """One of the terms; of a response model as a term of the highest derivative."""
        return term(est, one.name, one.unit, one.entry, _yaw_weight(est))

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, list[str]]:
        return {"components": [p.name for p in variant]} if len(self.terms) > 1 else {}


def _yaw_weight(est: Estimator) -> float:
    """What turns alpha of T r_dot + r + alpha d(r) = K delta into a term of the highest derivative; 1 for 3-DOF."""
    if est.model.is_3dof:
        return 1.0
    c = dict(zip(est.model.coordinates, est.model.coefficients, strict=True))
    return float(c.get("a2", c.get("a", -1.0)))


class YawDampingQuadratic(MissingTerm):
    """Yaw moment N r|r| (bilge keels, skeg separation), in the vessel's own prime system; for a response model
    alpha r|r| beside r, in s/rad."""

    id, unit, extension = "yaw_damping_quadratic", "1 (prime) or s/rad", "yaw_damping_quadratic"
    terms = (Term("Nrr", "added_Nr_absr", 0.02, ("r", "absr")),)
    separate_by = "turning circles at several rudder angles, to both sides"


class YawDampingCubic(MissingTerm):
    """Yaw moment N r^3, in the vessel's own prime system; for a response model alpha r^3 beside r, in s2/rad2."""

    id, unit, extension = "yaw_damping_cubic", "1 (prime) or s2/rad2", "yaw_damping_cubic"
    terms = (Term("Nrrr", "added_Nrrr", 0.02, ("r", "r", "r")),)
    separate_by = "turning circles at several rudder angles, to both sides"


class SwayDampingQuadratic(MissingTerm):
    """Cross-flow drag Y v|v|, in the vessel's own prime system."""

    id, unit, extension = "sway_damping_quadratic", "1", "sway_damping_quadratic"
    terms, in_response = (Term("Yvv", "added_Yv_absv", 0.5, ("v", "absv")),), NEEDS_3DOF
    separate_by = "hard turns with sway measured, or an oblique towing test"


class CrossflowCoupling(MissingTerm):
    """Coupled cross-flow terms in a turn: Y r|v|, Y v|r|, N v|r|, N r|v|, in the vessel's own prime system."""

    id, unit, extension = "crossflow_coupling", "1", "crossflow_coupling"
    terms = (
        Term("Yrv", "added_Yr_absv", 0.3, ("r", "absv")),
        Term("Yvr", "added_Yv_absr", 0.3, ("v", "absr")),
        Term("Nvr", "added_Nv_absr", 0.1, ("v", "absr")),
        Term("Nrv", "added_Nr_absv", 0.1, ("r", "absv")),
    )
    in_response = NEEDS_3DOF
    separate_by = "turns with sway measured at several drift angles"


class ConstantForce(MissingTerm):
    """Constant force in body axes, X and Y in N and N in N m (a towed sonar, a bent fin, asymmetric thrust)."""

    id, unit, extension = "constant_force", "N, N m", "constant_force"
    terms = (
        Term("X", "constant_X", 2e-3, unit="N"),
        Term("Y", "constant_Y", 2e-3, unit="N"),
        Term("N", "constant_N", 5e-4, unit="N m"),
    )
    in_response = "in a response model a constant moment is a rudder offset"
    separate_by = "straight runs at two speeds: a constant force does not grow with the speed"

    def parameter(self, est: Estimator, one: Term) -> Parameter:
        scale = 1e-6 * est.unit["XYN".index(one.axis)]
        return Parameter(one.name, one.unit, ((est.index[one.entry], 1.0),), scale=scale)


class SecondOrderLead(Cause):
    """Second time constant T2 and lead T3 that a first-order Nomoto model lacks: rudder through
    (1 + T3 s)/(1 + T2 s), T3 = T2 (1 - lead)."""

    id, where, unit = "second_order_lead", "hull", "s"
    search, extension = ByProfile((0.5, 1.5, 5.0, 15.0, 45.0)), "second_order_lead"
    separate_by = "rudder steps with the yaw rate sampled fast"
    beside_numbers = False

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if "lead" not in est.index:
            raise NotTestable("only for first-order response models: others have it")
        lead = Parameter("lead", "1", ((est.index["lead"], 1.0),), scale=0.02, low=-20.0, high=5.0)
        base = float(est.base[est.index["lead_T2"]])
        shortest = est.segments[0].step_s - base  # what is faster than the sampling is not seen
        slots = ((est.index["lead_T2"], 1.0),)
        return [(lead, Parameter("T2", "s", slots, scale=0.2, low=shortest, high=200.0, origin=base))]


class SpeedLoss(Cause):
    """Speed lost in the turn, for response models: U = U0 (1 - loss), T_u loss_dot = k r^2 - loss, and every term of
    the yaw equation keeps its prime value at the speed U (damping falls with U, the rudder's moment with U^2)."""

    id, where, unit = "speed_loss", "hull", "s2/rad2"
    search, extension = ByProfile((10.0, 30.0, 100.0, 300.0)), "speed_loss"
    smallest = 0.001
    separate_by = "record the speed through the water"
    beside_numbers = False

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if "loss_gain" not in est.index:
            raise NotTestable("surge is a state of the model already")
        base = float(est.base[est.index["loss_time"]])
        slots, low, high = ((est.index["loss_time"], 1.0),), 3.0 * est.clock - base, 300.0 * est.clock - base
        time = Parameter("recovery", "s", slots, scale=1.0, low=low, high=high, origin=base)
        gain = replace(term(est, "loss_gain", "s2/rad2", "loss_gain", scale=10.0), low=0.0)
        return [(gain, time)]

    def strength(self, est: Estimator, variant: Variant, values: np.ndarray) -> float:
        """Share of the speed that is lost at the rms yaw rate of the records."""
        rates = est.joined(lambda d: d.measured[:, YAW_RATE] if est.channels[YAW_RATE] else _slope(d))
        return abs(float(values[0])) * float(np.nanmean(rates**2))


def _slope(d: Segment) -> np.ndarray:
    return np.gradient(d.measured[:, HEADING], d.time)
