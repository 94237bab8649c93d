"""Columns of texts, millions of cells in the memory of a file: stored as one Arrow array."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np

CHUNK = 50_000
"""Cells that are made Python texts at a time."""


def compute() -> Any:
    """Arrow's functions, which are made when it is imported: type checkers do not know them."""
    return import_module("pyarrow.compute")


class Texts(Sequence[str]):
    """The texts (N,) of a column."""

    def __init__(self, cells: Any) -> None:
        """cells : texts in any sequence, or an Arrow array of texts without nulls."""
        import pyarrow as pa

        chunked = isinstance(cells, pa.ChunkedArray)
        whole = cells.combine_chunks() if chunked else cells if isinstance(cells, pa.Array) else pa.array(list(cells))
        self.array: Any = whole.cast(pa.large_string())

    def __len__(self) -> int:
        return len(self.array)

    def __getitem__(self, index: Any) -> Any:
        """A text, or the texts of a slice."""
        if isinstance(index, slice):
            return self.array[index].to_pylist()
        return self.array[int(index)].as_py()

    def __iter__(self) -> Iterator[str]:
        for start in range(0, len(self.array), CHUNK):
            yield from self.array[start : start + CHUNK].to_pylist()

    def take(self, rows: Any) -> Texts:
        """The texts of some rows."""
        return Texts(self.array.take(np.asarray(rows, dtype=np.int64)))

    @cached_property
    def trimmed(self) -> Any:
        """The Arrow array without white space around the texts."""
        pc = compute()

        return pc.utf8_trim_whitespace(self.array)

    def unique(self) -> list[str]:
        """The different texts, trimmed, in the order of their first rows."""
        return self.trimmed.unique().to_pylist()

    def among(self, wanted: Iterable[str]) -> np.ndarray:
        """(N,) whether a text, trimmed and in lower case, is one of some."""
        import pyarrow as pa

        pc = compute()

        known = pa.array(sorted(wanted), pa.large_string())
        return pc.is_in(pc.utf8_lower(self.trimmed), value_set=known).to_numpy(zero_copy_only=False)

    def like(self, pattern: str) -> np.ndarray:
        """(N,) whether a text, trimmed, fits a pattern of Arrow's regular expressions."""
        pc = compute()

        return pc.match_substring_regex(self.trimmed, pattern).to_numpy(zero_copy_only=False)

    def coded(self) -> tuple[list[str], np.ndarray]:
        """(the different texts, trimmed; (N,) the place of each row's text among them)."""
        coded = self.trimmed.dictionary_encode()
        return coded.dictionary.to_pylist(), coded.indices.to_numpy(zero_copy_only=False)

    def mapped(self, function: Callable[[str], float]) -> np.ndarray:
        """(N,) numbers that a function makes of the texts, trimmed; it is called once for equal texts."""
        texts, codes = self.coded()
        return np.array([function(text) for text in texts], dtype=float)[codes] if texts else np.zeros(0)
