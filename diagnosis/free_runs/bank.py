"""What numbers of a fit move, and the bank that holds them.

place      what a number moves
model      a number of the model, or of a term that it lacks (`models.coefficient_groups`)
steering   a number of the rudder's linkage (`models.instruments`), or the inverse of a limit
flow       a steady current or wind, or a steady force in body axes, of all records or of one
term       a force in body axes along the measured motion (`Bank.series`)
windage    a coefficient of the wind force, as a share of the stated or else of a usual one, beside
           `Bank.wind_share`
window     a force in body axes over one of so many windows of a piece (entries: its number, their count)
sensor     numbers of instruments that show the motion
regime     a number of the model inside a regime only
drift      a sensor's error: what it grows by in a second (column 0), or what it is at the record's start (1)
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.number import Number
from ...models.coefficient_groups import names_of, values_of
from ...models.model import WIND_COEFFICIENTS
from ..causes.base_coefficients import BaseCoefficients

if TYPE_CHECKING:
    from ...estimation.selection.number import Candidate
    from ...models.coefficient_groups import Group
    from ...models.model import Model
    from ...models.regimes import Regime
    from .motion import Series


class Place(NamedTuple):
    """What a number moves.

    kind : see above.  entries : names of instruments; of a term, its own.  column : of the environment's inputs
    (current, wind, forces), or of the model's numbers.  record : the one that it belongs to, None: all.
    inside : places among the model's numbers, and by how much these change for a number of one.  regime : where.
    fixed : further instruments and their values.
    """

    kind: str
    entries: tuple[str, ...] = ()
    column: int = -1
    record: int | None = None
    inverse: bool = False
    inside: tuple[tuple[int, float], ...] = ()
    regime: Regime | None = None
    fixed: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Bank:
    """All candidates for a model.

    model : with the terms that it lacks, at zero.  own : its own numbers under their priors.  places : number -> what
    it moves.  causes : id of a candidate's `of` -> cause that it is told as.  titles : the same -> words.
    series : number of a term -> its force along a motion.  windage : what wind acts on (`Model.windage`): the model's
    own, or a usual one.  wind_share : the share of it that wind acts on without a number: nearly none where the
    model states no windage and the wind is measured.  outside : candidates that are not tried, as whole records are
    predicted worse with them.
    """

    model: Model
    candidates: tuple[Candidate, ...]
    own: tuple[Number, ...]
    places: Mapping[str, Place]
    causes: Mapping[str, str]
    titles: Mapping[str, str] = field(default_factory=dict)
    series: Mapping[str, Series] = field(default_factory=dict)
    windage: Mapping[str, float] | None = None
    wind_share: float = 1.0
    outside: tuple[Candidate, ...] = ()

    def without(self, ids: Collection[str]) -> Bank:
        """The bank without candidates (`Candidate.of`)."""
        kept = tuple(c for c in self.candidates if c.of not in ids)
        return replace(self, candidates=kept, outside=(*self.outside, *(c for c in self.candidates if c.of in ids)))

    def windage_with(self, numbers: Mapping[str, float]) -> dict[str, float] | None:
        """What wind acts on with numbers (name -> value) of coefficients of the wind force."""
        if self.windage is None:
            return None
        own = {self.places[name].entries[0]: x for name, x in numbers.items()}
        shares = {n: self.wind_share + own.get(n, 0.0) for n in WIND_COEFFICIENTS}
        return {name: x * shares.get(name, 1.0) for name, x in self.windage.items()}

    def cause_of(self, candidate: Candidate) -> str:
        """The cause of the taxonomy that a candidate is told as."""
        return self.causes.get(candidate.of, BaseCoefficients.id)

    @cached_property
    def values(self) -> dict[str, float]:
        """Number of the model -> its value before any fit."""
        return values_of(self.model)


def numbers_of(group: Group, values: Mapping[str, float]) -> list[Number]:
    """The numbers of a group with their priors, as differences from their values, within what ships have."""
    low = {n: s.low for n, s in group.scope.items()} | group.low
    high = {n: s.high for n, s in group.scope.items()} | group.high
    own = [(n, sd, values.get(n, 0.0)) for n, sd in group.sd.items()]
    return [Number(n, sd, low.get(n, -np.inf) - x, high.get(n, np.inf) - x) for n, sd, x in own]


def places_of(model: Model) -> dict[str, Place]:
    """The places of the numbers of a model."""
    return {name: Place("model", column=i) for i, name in enumerate(names_of(model))}


def of_numbers(model: Model) -> Bank:
    """A bank that holds the model's numbers, and no candidate."""
    return Bank(model, (), (), places_of(model), {}, windage=model.windage)
