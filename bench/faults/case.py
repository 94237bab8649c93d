"""Cases: which ship, which effects of which strength, under which gusts and sensors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...models.errors import BadInput
from . import sensing
from .effects.base import Effect, EffectKind, kind_of
from .ships import TrueShip, ship

#: Correlation times of zero-mean gusts on a full-scale ship, s
GUSTS = {"none": None, "fast": (3.0, 10.0), "slow": (30.0, 60.0)}
GUST_LEVEL = np.deg2rad(0.4)
#: Non-centrality of a strength: drawn uniformly in its logarithm; 29.3 is power .99 at level .001 (one size)
STRENGTHS = {
    "undetectable": (1.0, 3.0),
    "detectable": (30.0, 60.0),
    "faint": (60.0, 120.0),
    "medium": (400.0, 800.0),
    "gross": (4e3, 8e3),
}
#: Strengths by size: factors on the size that a kind draws (an offset near .1 deg, a delay near .2 s, a current near
#: 3 cm/s), increased where that would not be detectable
SIZED = {"small": 1.0, "moderate": 3.0, "large": 10.0, "largest": 60.0}
TRAIN = ("zigzag:20/20", "turn:25:port", "steps:25deg/{:g}s")
HELD_OUT = ("zigzag:10/10:port", "sine:15deg/{:g}s")


@dataclass(frozen=True)
class FaultCase:
    """What to inject.

    Parameters
    ----------
    vessel : one of `ships.VESSELS`.
    causes : kinds of effects, drawn at `strength` (none: a clean case); `effects` are injected as they are.
    strength : a key of `STRENGTHS` or `SIZED`, or a non-centrality.
    gusts : 'none', 'fast' or 'slow'; gust_level : yaw moment of a gust (sd) as a rudder angle, rad.
    train, held_out : manoeuvres (default: three and two of mixed kinds); `{:g}` stands for 40 and 120 s, in the ship's
        own time scale.
    duration_s, dt_s : of each record (default 600 s at 0.5 s, a fifth of it or so for a model).
    noise : factor on the sensors' noise; gaps : share of samples lost; channels : which are kept (default: all).
    command : the records hold the rudder's command instead of its angle.
    noise_time_s : correlation time of the sensors' noise, s of a 160 m ship (0: white).
    spread : relative standard deviation of an effect's size between records.
    factors : (name, factor) of numbers in which the ship differs from the published one (`ships.sister_numbers`).
    beside : relative standard deviation of the ship's own numbers beside which the effects have to be told, from
        innovations that are correlated as errors of free runs are (`strength.own_numbers`); 0: all is known.
    foreign : the effects' forces are those of another record, so that no cause of the motion explains them
        (`frames.foreign_forces`).
    """

    vessel: str = "mariner"
    causes: tuple[str, ...] = ()
    strength: str | float = "medium"
    effects: tuple[Effect, ...] = ()
    gusts: str = "none"
    gust_level: float = GUST_LEVEL
    train: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    duration_s: float | None = None
    dt_s: float | None = None
    noise: float = 1.0
    gaps: float = 0.0
    channels: tuple[str, ...] = ()
    command: bool = False
    wrap: bool = True
    noise_time_s: float = 0.0
    spread: float = 0.0
    beside: float = 0.0
    foreign: bool = False
    factors: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        for kind in self.kinds:
            if not kind.carried_by(self.ship):
                raise BadInput(f"{self.vessel} cannot carry {kind.id}")
        if isinstance(self.strength, str) and self.strength not in STRENGTHS | SIZED:
            raise BadInput(f"strength {self.strength!r}", hint=f"a number or {', '.join(STRENGTHS | SIZED)}")
        if self.foreign and (self.gusts != "none" or any(kind.on_sensor for kind in self.kinds)):
            raise BadInput("planted nulls are forces, in calm", hint="no effects of sensors, gusts 'none'")
        if self.gusts not in GUSTS:
            raise BadInput(f"gusts {self.gusts!r}", hint="none, fast or slow")

    @property
    def kinds(self) -> list[EffectKind]:
        """Kinds of the effects."""
        return [*map(kind_of, self.causes), *(effect.kind for effect in self.effects)]

    @property
    def ship(self) -> TrueShip:
        """The ship without effects."""
        return ship(self.vessel, self.factors)

    def completed(self) -> FaultCase:
        """The case with its defaults filled in."""
        clock = self.ship.clock
        times = 40.0 * clock, 120.0 * clock
        facts: dict[str, Any] = {
            "train": tuple(text.format(times[0]) for text in self.train or TRAIN),
            "held_out": tuple(text.format(times[1]) for text in self.held_out or HELD_OUT),
            "duration_s": self.duration_s or (600.0 if clock > 0.5 else 150.0),
            "dt_s": self.dt_s or (0.5 if clock > 0.5 else 0.1),
            "channels": self.channels or (sensing.CHANNELS if self.ship.is_3dof else sensing.RESPONSE_CHANNELS),
            "command": self.command or any(kind.command for kind in self.kinds),
        }
        return replace(self, **facts)
