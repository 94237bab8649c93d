"""Effects that the truth simulator injects: one file per kind, found by the registry."""

from .base import ANTICIPATED, TAXONOMY, UNFORESEEN, EffectKind, Setting
from .effect import Effect
from .registry import kind_of, kinds, names_of

__all__ = [
    "ANTICIPATED", "TAXONOMY", "UNFORESEEN", "Effect", "EffectKind", "Setting", "kind_of", "kinds", "names_of",
]  # fmt: skip
