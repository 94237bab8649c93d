"""Effects that act in a part of the run only: what a diagnosis should name, and where."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

from ..regimes import Regime
from ..ships import Ship
from .base import REGIME, EffectKind


class RegimeKind(EffectKind):
    """A kind that acts in a regime.

    right : groups of the base model's numbers and causes that name it.
    """

    group = REGIME
    right: ClassVar[tuple[str, ...]]

    @abstractmethod
    def regime(self, p: Mapping[str, Any], ship: Ship) -> Regime:
        """Where it acts."""
