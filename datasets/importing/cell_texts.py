"""Columns of texts, millions of cells in the memory of a file: stored as one array of numpy's variable-width texts, or
of Arrow's where the file is plain (`plain_text`).  Both give the same; Arrow's functions take a tenth of the time.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.dtypes import StringDType

from ..arrow_csv import arrow_mask, arrow_texts, compute, mask_of_arrow, numbers_of_arrow

CHUNK = 50_000
"""Cells that are made Python texts at a time."""


class Texts(Sequence[str]):
    """The texts (N,) of a column.

    arrow : the same, trimmed, as an array of Arrow's, of ASCII characters without line breaks; None: not of Arrow.
    """

    def __init__(self, cells: Iterable[str] | np.ndarray) -> None:
        """cells : texts in any sequence, or an array (N,) of them."""
        self.arrow: Any = None
        self._stored: Any = None
        self.array: Any = np.asarray(cells if isinstance(cells, np.ndarray) else list(cells), dtype=StringDType())

    @classmethod
    def of_arrow(cls, cells: Any) -> Texts:
        """The texts (N,) of an array of Arrow's, of ASCII characters without line breaks; none is null."""
        self = cls.__new__(cls)
        self._stored, self.arrow = cells, compute().ascii_trim_whitespace(cells)
        return self

    @cached_property
    def array(self) -> Any:
        """The array (N,) of numpy's texts."""
        return np.array(self._stored.to_pylist(), dtype=StringDType())

    def __len__(self) -> int:
        return len(self.array if self.arrow is None else self.arrow)

    def __getitem__(self, index: Any) -> Any:
        """A text, or the texts of a slice."""
        if self.arrow is not None:
            return self._stored[index].to_pylist() if isinstance(index, slice) else self._stored[int(index)].as_py()
        return self.array[index].tolist() if isinstance(index, slice) else str(self.array[int(index)])

    def __iter__(self) -> Iterator[str]:
        return pieces(self.array if self.arrow is None else self._stored)

    def take(self, rows: Any) -> Texts:
        """The texts of some rows."""
        at = np.asarray(rows, dtype=np.int64)
        return Texts(self.array[at]) if self.arrow is None else Texts.of_arrow(self._stored.take(at))

    @cached_property
    def trimmed(self) -> Any:
        """The array (N,) without white space around the texts."""
        found = np.strings.strip(self.array)
        return self.array if np.array_equal(found, self.array) else found

    def trimmed_texts(self) -> Iterator[str]:
        """The texts without white space around them."""
        return pieces(self.trimmed if self.arrow is None else self.arrow)

    def unique(self) -> list[str]:
        """The different texts, trimmed, in the order of their first rows."""
        return list(dict.fromkeys(self.trimmed_texts())) if self.arrow is None else self.arrow.unique().to_pylist()

    def among(self, wanted: Iterable[str]) -> np.ndarray:
        """(N,) whether a text, trimmed and in lower case, is one of some."""
        known = frozenset(wanted)
        if self.arrow is None:
            return self.tested(lambda text: text.lower() in known)
        return mask_of_arrow(compute().is_in(compute().ascii_lower(self.arrow), value_set=arrow_texts(sorted(known))))

    def tested(self, function: Callable[[str], object]) -> np.ndarray:
        """(N,) whether a function of a text, trimmed, is true."""
        return np.fromiter(map(bool, map(function, self.trimmed_texts())), dtype=bool, count=len(self))

    def matched(self, pattern: re.Pattern[str]) -> np.ndarray:
        """(N,) whether a text, trimmed, is of a form as a whole: without look-around; its possessive quantifiers may be
        greedy ones without another result."""
        if self.arrow is None:
            return self.tested(pattern.fullmatch)
        return mask_of_arrow(compute().match_substring_regex(self.arrow, _as_re2(pattern)))

    @property
    def longest(self) -> int:
        """Characters of the longest of Arrow's texts."""
        return compute().max(compute().binary_length(self._stored)).as_py() or 0

    def moments(self) -> np.ndarray | None:
        """Seconds since 1970 (N,) of Arrow's texts of ISO 8601, in UTC where they state no zone; None where one is no
        such moment, or some state a zone."""
        import pyarrow

        for zone in (None, "UTC"):
            with contextlib.suppress(pyarrow.ArrowInvalid):
                kind = pyarrow.timestamp("ns", zone)
                self.arrow[:1].cast(kind)  # a refusal of all takes long
                whole, rest = np.divmod(np.from_dlpack(self.arrow.cast(kind).cast(pyarrow.int64())), 10**9)
                return whole + rest / 1e9
        return None

    def replaced(self, old: str, new: str) -> Texts:
        """Arrow's texts with one sign replaced by another."""
        return Texts.of_arrow(compute().replace_substring(self.arrow, old, new))

    def floats(self, which: np.ndarray) -> np.ndarray | None:
        """The numbers (N,) of those of Arrow's texts, which (N,), nan elsewhere; None where one is no number."""
        import pyarrow

        wanted = self.arrow if which.all() else compute().if_else(arrow_mask(which), self.arrow, None)
        try:
            return numbers_of_arrow(wanted.cast(pyarrow.float64()))
        except pyarrow.ArrowInvalid:
            return None

    def coded(self) -> tuple[list[str], np.ndarray]:
        """(the different texts, trimmed; (N,) the place of each row's text among them)."""
        if self.arrow is not None:
            found = self.arrow.dictionary_encode()
            return found.dictionary.to_pylist(), np.from_dlpack(found.indices).astype(np.int64)
        places: dict[str, int] = {}
        codes = (places.setdefault(text, len(places)) for text in self.trimmed_texts())
        rows = np.fromiter(codes, dtype=np.int64, count=len(self))
        return list(places), rows

    def mapped(self, function: Callable[[str], float]) -> np.ndarray:
        """(N,) numbers that a function makes of the texts, trimmed; it is called once for equal texts."""
        texts, codes = self.coded()
        return np.array([function(text) for text in texts], dtype=float)[codes] if texts else np.zeros(0)


def _as_re2(pattern: re.Pattern[str]) -> str:
    """A pattern of a whole text, as Arrow's engine (RE2) writes it: without possessive quantifiers, group names, and
    numbered characters."""
    text = re.sub(r"(?<=[*+])\+|\?P<\w+>", "", pattern.pattern)
    text = re.sub(r"\\u([\da-f]{4})", lambda found: chr(int(found[1], 16)), text)
    return f"{'(?i)' if pattern.flags & re.IGNORECASE else ''}^(?:{text})$"


def pieces(array: Any) -> Iterator[str]:
    """The texts of an array (N,), numpy's or Arrow's, made Python texts `CHUNK` at a time."""
    for start in range(0, len(array), CHUNK):
        yield from array[start : start + CHUNK].tolist()
