"""Effects that the truth simulator injects, found by the registry: files by where they act."""

from .base import ANTICIPATED, REGIME, TAXONOMY, UNFORESEEN, EffectKind, RegimeKind, Setting
from .effect import Effect, kind_of, kinds, names_of

__all__ = [
    "ANTICIPATED", "REGIME", "TAXONOMY", "UNFORESEEN", "Effect", "EffectKind", "RegimeKind", "Setting", "kind_of",
    "kinds", "names_of",
]  # fmt: skip
