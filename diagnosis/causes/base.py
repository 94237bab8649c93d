"""A cause of the taxonomy: one class whose body is a row of data, with methods only where it has a formula of its own.

The row says what it is (its docstring: the physics, as words and as an equation), which numbers it moves and in what
bounds, how it is looked for, how its sizes are told, and how it enters the extended model.  Where it acts it refers to,
and never repeats: a parameter of a model extension (`models.families.extensions`), a number of the rudder chain or of
an instrument (`models.instruments`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ...checks.base import Check
from ...checks.result import NORMAL_90, Size
from ...estimation.filters.innovations.settings import Parameter, Setting
from ...estimation.filters.innovations.vector import SENSORS, SYMBOLS

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..innovations.searches import Search
    from ..innovations.state import Candidate, State, Variant

DEGREE = np.pi / 180.0
DESCRIBED = 1e-3
"""Share of a size by which it may be off because samples are joined and equations stepped: what the truth simulator's
records in calm show beyond the noise (107 sizes of the benchmark known to better than 1 %)."""
NEEDS_3DOF = "needs a model with surge, sway and yaw"
WHERE = ("rudder", "sensor", "hull", "environment", "sampling")


class NotTestable(Exception):
    """The model or the channels cannot carry a cause; the message says why."""


class Number(NamedTuple):
    """A number that moves entries of the vector alike: its name, the entries, the size of a first step, and bounds."""

    name: str
    entries: tuple[str, ...]
    scale: float
    low: float = -np.inf
    high: float = np.inf

    def variant(self, est: Estimator, unit: str) -> Variant:
        """The number as all that a cause moves."""
        slots = tuple((est.index[entry], 1.0) for entry in self.entries)
        return (Parameter(self.name, unit, slots, None, self.low, self.high, self.scale),)


class Cause(Check):
    """Base class of all causes; subclasses set the class attributes, and those of more than one number `variants`.

    id : public identifier.  where : one of WHERE.  unit : of its sizes.  search : how it is looked for.
    extension : id of the model extension that it becomes, None for one that stays a number of rudder or sensors.
    number : what it moves, in its unit; None: its search holds it in entries of the vector (`Search.entries`).
    channels : psi, r, u, v, x, y that must be measured.  A class with `variants` of its own says both there.
    power_size : size of the first parameter whose detection the stated power is for, None where none is stated.
    separate_by : what would tell it from its rivals.
    smallest : size of the first parameter (length of a pair; seconds are those of a 160 m ship) from which it matters;
    None where none is stated.
    beside_numbers : whether it is tried beside a base model whose own numbers are uncertain: not where these take its
    place, or where it feeds on what they leave.
    """

    search: ClassVar[Search]
    number: ClassVar[Number | None] = None
    channels: ClassVar[tuple[str, ...]] = ()
    extension: ClassVar[str | None] = None
    power_size: ClassVar[float | None] = None
    smallest: ClassVar[float | None] = None
    beside_numbers: ClassVar[bool] = True

    def variants(self, est: Estimator) -> Sequence[Variant]:
        """Ways in which the cause may act, each as parameters that are zero where it is absent.

        Raises
        ------
        NotTestable : the model or the channels cannot carry it.
        """
        require_channels(est, *self.channels)
        return [()] if self.number is None else [self.number.variant(est, self.unit)]

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        """`beside_numbers`, for a cause that is not the same in every model."""
        return self.beside_numbers

    def strength(self, est: Estimator, variant: Variant, values: np.ndarray) -> float:
        """What is compared with `smallest`: the first of the values (k,), or the longest of pairs."""
        if not variant:
            return 0.0
        if len(variant) > 1 and variant[0].record is not None and len(values) % 2 == 0:
            return float(np.max(np.hypot(values[0::2], values[1::2])))
        return abs(float(values[0]))

    def matters(self, est: Estimator, variant: Variant, values: np.ndarray) -> bool:
        """Whether sizes (k,) are above the cause's floor: for a delay also half a sample."""
        if not variant or self.smallest is None:
            return True
        floor = self.smallest * self._unit(est, variant)
        if variant[0].unit == "s":
            floor = max(floor, 0.5 * est.segments[0].step_s)
        return self.strength(est, variant, values) > floor

    def _unit(self, est: Estimator, variant: Variant) -> float:
        """Seconds and speeds of a ship against those of a 160 m ship; 1 for other units."""
        return est.clock if variant[0].unit in ("s", "m/s") else 1.0

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, Any]:
        """What a finding says beside its sizes: which coefficient, which channels."""
        return {}

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """Sizes with 90 % intervals from the covariance (k, k) of the variant's parameters."""
        values = np.array([est.value(s, p) for p in variant])
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0) + (DESCRIBED * values) ** 2)
        halves = (NORMAL_90 * spread).tolist()
        return tuple(plain_size(est, p, v, half) for p, v, half in zip(variant, values.tolist(), halves, strict=True))

    def simpler(self, state: State, candidate: Candidate, before: float, rng: np.random.Generator) -> Candidate | None:
        """A simpler cause that describes the same motion, refitted; None where there is none.

        before : log likelihood without either.
        """
        return None


class StageCause(Cause):
    """Base class of causes that a stage of its own looks for, in the records before the bank or in the base model after
    it; the bank does not hold them.

    stage : where it is looked for, as a reason why the bank does not test it.
    """

    unit = "1"
    stage: ClassVar[str]

    def variants(self, est: Estimator) -> Sequence[Variant]:
        raise NotTestable(self.stage)


def plain_size(est: Estimator, p: Parameter, value: float, half: float) -> Size:
    """A size between its bounds, told from its origin."""
    low, high = max(value - half, p.low), min(value + half, p.high)
    name = None if p.record is None else est.record_names[p.record]
    return Size(p.name, value + p.origin, low + p.origin, high + p.origin, p.unit, name)


def term(est: Estimator, name: str, unit: str, entry: str, weight: float = 1.0, scale: float = 1e-5) -> Parameter:
    """A parameter that is a weighted entry of the vector."""
    return Parameter(name, unit, ((est.index[entry], weight),), scale=scale / abs(weight))


def require_channels(est: Estimator, *symbols: str) -> None:
    """Raise NotTestable unless all channels (psi, r, u, v, x, y) are measured and in the model."""
    names = dict(zip(SYMBOLS, SENSORS, strict=True)) | {"x": "position", "y": "position"}
    missing = [names[s] for s in symbols if not est.channels[SYMBOLS.index(s)]]
    if missing:
        said = " and ".join(dict.fromkeys(missing)).replace("_", " ")
        raise NotTestable(f"needs measured {said} that the model has")


def require_3dof(est: Estimator, why: str = NEEDS_3DOF) -> None:
    """Raise NotTestable, and say why, for a response model."""
    if not est.model.is_3dof:
        raise NotTestable(why)
