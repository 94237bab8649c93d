"""The truth simulator that injects effects in records, for the benchmark of the diagnosis and for tests.

Shares no code with the kernels that the diagnosis fits: the equations are written by hand (`equations`), the rudder
moves inside the integration step (`integrate`), and only the numbers of the vessel files are read.

    injected = inject(FaultCase("mariner", causes=("rudder_offset",), strength="faint"), rng)
    injected.train, injected.held_out, injected.truth

A kind of effect is a row of a table in `effects/`.
"""

from .effects.base import ANTICIPATED, REGIME, TAXONOMY, UNFORESEEN, Effect, EffectKind, kind_of, kinds, names_of
from .frames import GUSTS, SIZED, STRENGTHS, FaultCase
from .injected import Injected, inject, noncentrality
from .ships import VESSELS

__all__ = [
    "ANTICIPATED", "GUSTS", "REGIME", "SIZED", "STRENGTHS", "TAXONOMY", "UNFORESEEN", "VESSELS", "Effect", "EffectKind",
    "FaultCase", "Injected", "inject", "kind_of", "kinds", "names_of", "noncentrality",
]  # fmt: skip
