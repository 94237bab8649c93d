"""Effects that the truth simulator injects: one file per kind, found by the registry."""

from ._regime import RegimeKind
from .base import ANTICIPATED, REGIME, TAXONOMY, UNFORESEEN, EffectKind, Setting
from .effect import Effect
from .registry import kind_of, kinds, names_of

__all__ = [
    "ANTICIPATED", "REGIME", "TAXONOMY", "UNFORESEEN", "Effect", "EffectKind", "RegimeKind", "Setting", "kind_of",
    "kinds", "names_of",
]  # fmt: skip
