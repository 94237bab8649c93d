"""Effects: the kinds that the files of this folder define, and a kind with its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ....models.discovery import by_name, classes_of, known, modules_in
from .base import EffectKind


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
