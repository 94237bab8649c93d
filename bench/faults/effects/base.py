"""What a kind of effect states, and an effect: a kind with its parameters.

A kind is a class, or a row of a table `ROWS` where it differs from others of its class by numbers and a function. The
files of this folder are by where an effect acts; unforeseen effects have a file each. A kind states as which cause it
should be diagnosed, how it is drawn, where it acts (ship, rudder, forces, wave motion or sensors) and how a size that a
diagnosis states is compared with the true one. Methods that a kind does not override leave everything as it is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from ....models.discovery import by_name, classes_of, known, modules_in
from ..regimes import TrueRegime
from ..ships import TrueShip

TAXONOMY, ANTICIPATED, UNFORESEEN, REGIME = "causes", "anticipated", "unforeseen", "regime"
"""Groups: causes of the taxonomy, unknown effects that a diagnosis may have a test for, other unknown effects, and
effects that act in a part of the run only."""
LAST = 10_000
Rows = dict[str, np.ndarray]
"""Columns of a record by channel."""


@dataclass(frozen=True)
class Setting:
    """What a draw may look at: the ship, the records' duration in s and their numbers.

    `place()` draws a place (north, east), in ship lengths, that a training record passes without effects.
    """

    ship: TrueShip
    duration_s: float
    train: int
    held_out: int
    place: Callable[[], tuple[float, float]]

    @property
    def records(self) -> int:
        """Number of records."""
        return self.train + self.held_out


class EffectKind(ABC):
    """One kind of effect.

    Attributes
    ----------
    id : the cause that a diagnosis should name (an unknown effect: its own name).
    group : `TAXONOMY`, `ANTICIPATED`, `UNFORESEEN` or `REGIME`.
    rank : place in the order in which a suite draws; a kind without one comes last, so that a new kind leaves the
        cases of the others as they are.
    units : parameter -> unit.
    sized : the parameters that grow with the strength, up to `cap` in absolute value.
    inverse : the size is a limit: it falls with the strength, down to `cap`.
    whole : parameters that are tuples but do not differ by record, and are no numbers to be found.
    directions : parameters that are angles on the full circle.
    variance_only : it only adds variance; command : records hold the rudder command instead of its angle.
    three_dof, response : which ships can carry it; of response ships also some, by their ids.
    """

    id: ClassVar[str]
    group: ClassVar[str] = TAXONOMY
    rank: ClassVar[int] = LAST
    units: ClassVar[Mapping[str, str]] = {}
    sized: ClassVar[tuple[str, ...]] = ()
    cap: ClassVar[float] = np.inf
    inverse: ClassVar[bool] = False
    whole: ClassVar[tuple[str, ...]] = ()
    directions: ClassVar[tuple[str, ...]] = ()
    variance_only: ClassVar[bool] = False
    command: ClassVar[bool] = False
    three_dof: ClassVar[bool] = True
    response: ClassVar[bool | tuple[str, ...]] = False

    def __init__(self, **row: Any) -> None:
        """A kind whose attributes and functions, by name, are those of a row where there is one."""
        vars(self).update(row)

    def variables(self, p: Mapping[str, Any]) -> frozenset[str]:
        """Variables that an unknown effect with these parameters depends on, as a diagnosis tells them; one of them is
        enough."""
        return frozenset()

    def carried_by(self, ship: TrueShip) -> bool:
        """Whether a ship can carry it."""
        if ship.is_3dof:
            return self.three_dof
        return self.response if isinstance(self.response, bool) else ship.id in self.response

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        """Parameters of about faint size; tuples hold one value per record, training records first."""
        return {}

    def noncentrality(self, p: Mapping[str, Any]) -> float | None:
        """Non-centrality of the best test where it is known without a filter; None: computed (`strength`)."""
        return None

    def changed_ship(self, ship: TrueShip, p: Mapping[str, Any]) -> TrueShip:
        """The ship with other coefficients."""
        return ship

    def rudder(self, p: Mapping[str, Any]) -> dict[str, float]:
        """Values of the rudder chain, by the names of `integrate.CHAIN`."""
        return {}

    def forces(self, p: Mapping[str, Any]) -> dict[str, float]:
        """Values of the equations' own force terms, by the names of `equations.DYNAMIC`."""
        return {}

    def wave(self, p: Mapping[str, Any]) -> tuple[float, float, float] | None:
        """Wave motion: rms rad, peak rad/s, damping ratio."""
        return None

    def truths(self, p: Mapping[str, Any], ship: TrueShip, details: Mapping[str, Any]) -> dict[str, float]:
        """True sizes in one record, by the names under which a finding with these `details` states them."""
        return numbers(p)


def numbers(p: Mapping[str, Any]) -> dict[str, float]:
    """The parameters that are numbers."""
    return {name: float(value) for name, value in p.items() if isinstance(value, int | float)}


class RecordEffect(EffectKind):
    """A kind that can also be injected in a measured record, since it only changes columns."""

    @abstractmethod
    def change_record(self, rows: Rows, time: np.ndarray, p: Mapping[str, Any], rng: np.random.Generator) -> None:
        """Change the columns in place; time (n,) s; KeyError for a missing column.

        The rudder at the hull is (1 + e) recorded(t - tau) + delta0: an injected offset takes delta0 out of the
        recorded column, and an injected delay moves the column forward in time.
        """


def random_sign(rng: np.random.Generator, negative: float = 0.5) -> float:
    """-1 with that probability, else 1."""
    return -1.0 if rng.random() < negative else 1.0


class RegimeKind(EffectKind):
    """A kind that acts in a part of the run only.

    right : groups of the base model's numbers and causes that name it.
    """

    group = REGIME
    right: ClassVar[tuple[str, ...]]

    def regime(self, p: Mapping[str, Any], ship: TrueShip) -> TrueRegime:
        """Where it acts."""
        raise NotImplementedError(f"{self.id} has no regime")


class ScalarKind(EffectKind):
    """A kind with one number: `size` times exp of -.5 to .5, negative with the probability `negative`.

    chain, terms : values of the rudder chain and of the equations' force terms that are this number.
    """

    parameter: ClassVar[str]
    unit: ClassVar[str]
    negative: ClassVar[float] = 0.5
    chain: ClassVar[tuple[str, ...]] = ()
    terms: ClassVar[tuple[str, ...]] = ()

    def __init__(self, **row: Any) -> None:
        super().__init__(**row)
        vars(self).update(units={self.parameter: self.unit}, sized=(self.parameter,))

    def size(self, ship: TrueShip) -> float:
        """About the faint size for a ship."""
        raise NotImplementedError(f"{self.id} has no size")

    def rudder(self, p: Mapping[str, Any]) -> dict[str, float]:
        return dict.fromkeys(self.chain, p[self.parameter])

    def forces(self, p: Mapping[str, Any]) -> dict[str, float]:
        return dict.fromkeys(self.terms, p[self.parameter])

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        sign = random_sign(rng, self.negative)
        return {self.parameter: sign * self.size(s.ship) * float(np.exp(rng.uniform(-0.5, 0.5)))}


class WeatherKind(EffectKind):
    """A speed or height and a direction, the two names of `units`, drawn anew for each record."""

    def __init__(self, **row: Any) -> None:
        super().__init__(**row)
        size, direction = self.units
        vars(self).update(sized=(size,), directions=(direction,))

    def size(self, ship: TrueShip) -> float:
        """About the faint speed or height for a ship."""
        raise NotImplementedError(f"{self.id} has no size")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        sizes = self.size(s.ship) * rng.uniform(0.7, 1.3, s.records)
        angles = rng.uniform(-np.pi, np.pi, s.records)
        return {self.sized[0]: tuple(map(float, sizes)), self.directions[0]: tuple(map(float, angles))}


# ---- Kinds that the files of this folder define, and a kind with its parameters.


@lru_cache(maxsize=1)
def kinds() -> dict[str, EffectKind]:
    """Identifier -> every kind of effect, in the order in which a suite draws."""
    found = [cls() for cls in classes_of(__package__, EffectKind)]
    found += [row for module in modules_in(__package__) for row in getattr(module, "ROWS", ())]
    return dict(sorted(by_name("effect", found).items(), key=lambda item: (item[1].rank, item[0])))


def kind_of(name: str) -> EffectKind:
    """The kind of an identifier; `BadInput` if there is none."""
    return known("effect", name, kinds())


def names_of(group: str) -> tuple[str, ...]:
    """Identifiers of the kinds of a group."""
    return tuple(name for name, kind in kinds().items() if kind.group == group)


@dataclass(frozen=True)
class Effect:
    """A kind of effect with its parameters; tuples hold one value per record (training records first)."""

    cause: str
    parameters: Mapping[str, Any]

    @property
    def kind(self) -> EffectKind:
        """The kind of effect; `BadInput` if there is none of that name."""
        return kind_of(self.cause)

    def scaled(self, factor: float) -> Effect:
        """The effect with its size multiplied (a limit: divided), within its cap."""
        kind = self.kind

        def grown(value: Any) -> Any:
            if isinstance(value, tuple):
                return tuple(grown(one) for one in value)
            if kind.inverse:
                return max(value / factor, kind.cap)
            return float(np.clip(value * factor, -kind.cap, kind.cap))

        return Effect(self.cause, {k: grown(v) if k in kind.sized else v for k, v in self.parameters.items()})

    def spread(self, share: float, records: int, rng: np.random.Generator) -> Effect:
        """The effect with a size of its own in each record, of this relative standard deviation about the common one;
        itself where it has none, or sizes by record already."""
        kind = self.kind
        shared = [k for k in kind.sized if isinstance(self.parameters.get(k), float) and k not in kind.whole]
        if not share or not shared:
            return self
        factors = 1.0 + share * np.clip(rng.standard_normal(records), -2.0, 2.0)
        own = {k: tuple(float(self.parameters[k] * f) for f in factors) for k in shared}
        return Effect(self.cause, {**self.parameters, **own})

    def at(self, record: int) -> dict[str, Any]:
        """The parameters in one record."""
        whole = self.kind.whole
        return {k: v[record] if isinstance(v, tuple) and k not in whole else v for k, v in self.parameters.items()}

    def count(self, records: int) -> int:
        """How many numbers of the effect act on the first `records` records."""
        values = [v for k, v in self.parameters.items() if k not in self.kind.whole and not isinstance(v, str)]
        return sum(min(len(v), records) if isinstance(v, tuple) else 1 for v in values)
