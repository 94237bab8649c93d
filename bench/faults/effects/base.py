"""Kinds of effects, and an effect: a kind with its parameters.

A kind is a row of a table `ROWS` of a file of this folder; the files are by where an effect acts, and all unforeseen
forces are in one.  A row states as which cause the effect should be diagnosed, how it is drawn, where it acts (ship,
rudder, forces, wave motion or sensors) and how a size that a diagnosis states is compared with the true one.  What it
leaves out changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import lru_cache
from typing import Any

import numpy as np

from ....models.discovery import by_name, known, modules_in
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


class Stage(IntEnum):
    """Order in which sensor effects act; white noise comes between `OFFSET` and `GROSS_ERROR`.

    Other effects have the stage `NONE`."""

    NONE = -1
    ALIGNMENT = 0
    FRAME = 1
    SCALE = 2
    OFFSET = 3
    GROSS_ERROR = 4
    COLUMN = 5


def three_dof(ship: TrueShip) -> bool:
    """Whether surge, sway and yaw of a ship move."""
    return ship.is_3dof


def any_ship(ship: TrueShip) -> bool:
    """Every ship, response ships too."""
    return True


def numbers(p: Mapping[str, Any]) -> dict[str, float]:
    """The parameters that are numbers."""
    return {name: float(value) for name, value in p.items() if isinstance(value, int | float)}


def unchanged(rows: Rows, time: np.ndarray, p: Mapping[str, Any], noise_sd: Mapping[str, float], rng: object) -> None:
    """Leaves the columns of a record as they are."""


@dataclass(frozen=True, eq=False, kw_only=True)
class EffectKind:
    """One kind of effect.  Its functions take the effect's parameters in one record, p.

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
    carried_by : whether a ship can carry it.
    draw : parameters of about faint size; tuples hold one value per record, training records first.
    variables : what an unknown effect depends on, as a diagnosis tells it; one of them is enough.
    noncentrality : that of the best test where it is known without a filter; None: computed (`injected`).
    truths : true sizes, by the names under which a finding with `details` states them.

    changed_ship : the ship with other coefficients.
    rudder, forces : values of the rudder chain (`integrate.Chain`) and of the equations' own terms
        (`equations.Terms`).
    force : a function of its own that adds forces, see `forces`.
    wave : wave motion: rms rad, peak rad/s, damping ratio.
    stage : when an effect on a sensor acts.
    apply : change columns (n,) in place; time (n,) s, noise_sd of the channels in their own units.
    delay_s, jitter_s : delay of a channel and standard deviation of the sampling times of a simulated record, s.
    regime : where it acts, of a kind that acts in a part of the run only; right : groups of the base model's numbers
        and causes that name it then.
    """

    id: str
    group: str = TAXONOMY
    rank: int = LAST
    units: Mapping[str, str] = field(default_factory=dict)
    sized: tuple[str, ...] = ()
    cap: float = np.inf
    inverse: bool = False
    whole: tuple[str, ...] = ()
    directions: tuple[str, ...] = ()
    variance_only: bool = False
    command: bool = False
    carried_by: Callable[[TrueShip], bool] = three_dof
    draw: Callable[[Setting, np.random.Generator], dict[str, Any]] = lambda s, rng: {}
    variables: Callable[[Mapping[str, Any]], frozenset[str]] = lambda p: frozenset()
    noncentrality: Callable[[Mapping[str, Any]], float | None] = lambda p: None
    truths: Callable[[Mapping[str, Any], TrueShip, Mapping[str, Any]], dict[str, float]] = lambda p, ship, details: (
        numbers(p)
    )
    changed_ship: Callable[[TrueShip, Mapping[str, Any]], TrueShip] = lambda ship, p: ship
    rudder: Callable[[Mapping[str, Any]], dict[str, float]] = lambda p: {}
    forces: Callable[[Mapping[str, Any]], dict[str, float]] = lambda p: {}
    force: Callable[..., None] | None = None
    wave: Callable[[Mapping[str, Any]], tuple[float, float, float] | None] = lambda p: None
    stage: Stage = Stage.NONE
    apply: Callable[..., None] = unchanged
    delay_s: Callable[[str, Mapping[str, Any]], float] = lambda channel, p: 0.0
    jitter_s: Callable[[Mapping[str, Any]], float] = lambda p: 0.0
    regime: Callable[[Mapping[str, Any], TrueShip], TrueRegime] | None = None
    right: tuple[str, ...] = ()

    @property
    def on_sensor(self) -> bool:
        """Whether it acts on a sensor."""
        return self.stage is not Stage.NONE


def random_sign(rng: np.random.Generator, negative: float = 0.5) -> float:
    """-1 with that probability, else 1."""
    return -1.0 if rng.random() < negative else 1.0


def scalar(
    parameter: str,
    unit: str,
    size: Callable[[TrueShip], float],
    negative: float = 0.5,
    chain: tuple[str, ...] = (),
    terms: tuple[str, ...] = (),
    **row: Any,
) -> EffectKind:
    """A kind with one number: `size` of the ship times exp of -.5 to .5, negative with the probability `negative`.

    chain, terms : values of the rudder chain and of the equations' force terms that are this number.
    """

    def draw(s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        sign = random_sign(rng, negative)
        return {parameter: sign * size(s.ship) * float(np.exp(rng.uniform(-0.5, 0.5)))}

    acting: dict[str, Any] = {
        "rudder": lambda p: dict.fromkeys(chain, p[parameter]),
        "forces": lambda p: dict.fromkeys(terms, p[parameter]),
    }
    return EffectKind(units={parameter: unit}, sized=(parameter,), draw=draw, **acting, **row)


# ---- Kinds that the files of this folder define, and a kind with its parameters.


@lru_cache(maxsize=1)
def kinds() -> dict[str, EffectKind]:
    """Identifier -> every kind of effect, in the order in which a suite draws."""
    found = [row for module in modules_in(__package__) for row in getattr(module, "ROWS", ())]
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
