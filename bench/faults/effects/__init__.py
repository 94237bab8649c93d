"""Effects that the truth simulator injects, found by the registry: files by where they act."""

from .base import (
    ANTICIPATED,
    REGIME,
    TAXONOMY,
    UNFORESEEN,
    Effect,
    EffectKind,
    RegimeKind,
    Setting,
    kind_of,
    kinds,
    names_of,
)  # fmt: skip

__all__ = [
    "ANTICIPATED", "REGIME", "TAXONOMY", "UNFORESEEN", "Effect", "EffectKind", "RegimeKind", "Setting", "kind_of",
    "kinds", "names_of",
]  # fmt: skip
