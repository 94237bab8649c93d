"""A data set of identibench in a folder of its own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import identibench


@dataclass(frozen=True)
class Folder(identibench.Dataset):
    """The data set `dataset_id` in the folder `root`, wherever identibench's own data are."""

    root: Path = Path()

    @property
    def path(self) -> Path:
        """The data set's folder."""
        return self.root / self.dataset_id
