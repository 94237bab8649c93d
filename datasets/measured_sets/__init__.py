"""Measured sets, one file for each ship."""

from .base import Dataset
from .blueboat import BLUEBOAT
from .esso_osaka import ESSO_OSAKA
from .kvlcc2 import KVLCC2_HSVA, KVLCC2_MARIN

DATASETS: dict[str, Dataset] = {
    "kvlcc2-hsva": KVLCC2_HSVA,
    "kvlcc2-marin": KVLCC2_MARIN,
    "esso-osaka": ESSO_OSAKA,
    "blueboat": BLUEBOAT,
}
"""Name -> measured set."""
