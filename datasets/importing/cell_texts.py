"""Columns of texts, millions of cells in the memory of a file: stored as one array of numpy's variable-width texts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.dtypes import StringDType

CHUNK = 50_000
"""Cells that are made Python texts at a time."""


class Texts(Sequence[str]):
    """The texts (N,) of a column."""

    def __init__(self, cells: Iterable[str] | np.ndarray) -> None:
        """cells : texts in any sequence, or an array (N,) of them."""
        self.array: Any = np.asarray(cells if isinstance(cells, np.ndarray) else list(cells), dtype=StringDType())

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, index: Any) -> Any:
        """A text, or the texts of a slice."""
        return self.array[index].tolist() if isinstance(index, slice) else str(self.array[int(index)])

    def __iter__(self) -> Iterator[str]:
        return pieces(self.array)

    def take(self, rows: Any) -> Texts:
        """The texts of some rows."""
        return Texts(self.array[np.asarray(rows, dtype=np.int64)])

    @cached_property
    def trimmed(self) -> Any:
        """The array (N,) without white space around the texts."""
        found = np.strings.strip(self.array)
        return self.array if np.array_equal(found, self.array) else found

    def unique(self) -> list[str]:
        """The different texts, trimmed, in the order of their first rows."""
        return list(dict.fromkeys(pieces(self.trimmed)))

    def among(self, wanted: Iterable[str]) -> np.ndarray:
        """(N,) whether a text, trimmed and in lower case, is one of some."""
        known = frozenset(wanted)
        return self.tested(lambda text: text.lower() in known)

    def tested(self, function: Callable[[str], object]) -> np.ndarray:
        """(N,) whether a function of a text, trimmed, is true."""
        return np.fromiter(map(bool, map(function, pieces(self.trimmed))), dtype=bool, count=len(self))

    def coded(self) -> tuple[list[str], np.ndarray]:
        """(the different texts, trimmed; (N,) the place of each row's text among them)."""
        places: dict[str, int] = {}
        codes = (places.setdefault(text, len(places)) for text in pieces(self.trimmed))
        rows = np.fromiter(codes, dtype=np.int64, count=len(self))
        return list(places), rows

    def mapped(self, function: Callable[[str], float]) -> np.ndarray:
        """(N,) numbers that a function makes of the texts, trimmed; it is called once for equal texts."""
        texts, codes = self.coded()
        return np.array([function(text) for text in texts], dtype=float)[codes] if texts else np.zeros(0)


def pieces(array: Any) -> Iterator[str]:
    """The texts of an array (N,), made Python texts `CHUNK` at a time."""
    for start in range(0, len(array), CHUNK):
        yield from array[start : start + CHUNK].tolist()
