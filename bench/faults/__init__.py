"""The truth simulator that hides effects in records, for the benchmark of the diagnosis and for tests.

Shares no code with the kernels that the diagnosis fits: the equations are written by hand (`equations`), the rudder
moves inside the integration step (`integrate`), and only the numbers of the vessel files are read.

    planted = plant(Case("mariner", causes=("rudder_offset",), strength="faint"), rng)
    planted.train, planted.held_out, planted.truth
"""

from .case import GUSTS, SIZED, STRENGTHS, Case, Planted, draw_effect, noncentrality, plant
from .effects import ANTICIPATED, CAUSES, UNFORESEEN, Effect, carries
from .measured import SPOILERS, spoil
from .ships import VESSELS

__all__ = [
    "ANTICIPATED", "CAUSES", "GUSTS", "SIZED", "SPOILERS", "STRENGTHS", "UNFORESEEN", "VESSELS",
    "Case", "Effect", "Planted", "carries", "draw_effect", "noncentrality", "plant", "spoil",
]  # fmt: skip
