"""Records that hold samples of each other: a run given twice, or one that was cut out of another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations, product

import numpy as np

from ..models.errors import BadInput
from .record import Record
from .same_run import same_run

FEWEST, SHARE = 20, 2.0 / 3.0
"""Samples in turn, and their share of the shorter record, from which one record is a part of another: two noise-free
runs may begin alike."""
LIKE = "rounded, resampled, shifted or turned"
FACTORS = np.random.default_rng(0).integers(1, 2**63, 64, dtype=np.uint64) * np.uint64(2) + np.uint64(1)
"""Odd numbers by which the bits of a row's channels are multiplied to make one number of the row."""


def check_no_copies(records: Sequence[Record], others: Sequence[Record] | None = None) -> None:
    """Refuse records that hold samples of another one: they would count twice.

    others : held-out records, which are compared with the records; None: the records are compared with each other.

    Raises
    ------
    BadInput : naming both records.
    """
    for first, second in _suspects(records, others):
        shared = shared_samples(first, second)
        if shared < max(FEWEST, SHARE * min(first.n, second.n)):
            continue
        hint = "give every run once; a held-out record takes no part in training"
        if shared == first.n == second.n:
            repeated = f"holds the same samples as {first.name}"
            said = repeated if others is None else "is both a training record and held out"
        else:
            training = "" if others is None else "the training record "
            said = f"shares {shared} of its {second.n} samples with {training}{first.name}"
        raise BadInput(said, file=second.name, hint=hint)
    found = same_run(records, others)
    if found is not None:
        first, second, same = found
        how = f"mirrored, {LIKE}" if same.mirrored else LIKE
        when = f" {same.later_s:.3g} s on" if same.later_s else ""
        said = (
            f"is the run of {first.name} again{when}, {how}: the noise of {' and '.join(same.channels)} is the same "
            f"(correlation {same.correlation:.2f})"
        )
        raise BadInput(said, file=second.name, hint="give every run once; a held-out record takes no part in training")


def _suspects(records: Sequence[Record], others: Sequence[Record] | None) -> Iterable[tuple[Record, Record]]:
    """The pairs to compare: those with a sample in common, or all where the records' channels differ."""
    every = [*records, *(others or ())]
    if len({frozenset(record.channels) for record in every}) > 1:
        return combinations(records, 2) if others is None else product(records, others)
    pairs = sorted(_with_common_samples(every))
    if others is not None:
        pairs = [(i, j) for i, j in pairs if i < len(records) <= j]
    return [(every[i], every[j]) for i, j in pairs]


def _with_common_samples(records: Sequence[Record]) -> set[tuple[int, int]]:
    """Numbers (i, j), i < j, of records with the same channels that have at least one sample in common."""
    names = sorted(records[0].channels) if records else []
    rows = [_rows(record, names) for record in records]
    owner = np.repeat(np.arange(len(rows)), [row.size for row in rows])
    values = np.concatenate([np.zeros(0, dtype=np.uint64), *rows])
    order = np.lexsort((owner, values))
    values, owner = values[order], owner[order]
    starts = np.flatnonzero(np.append(True, values[1:] != values[:-1])) if values.size else np.zeros(0, dtype=int)
    ends = np.append(starts[1:], values.size)
    found: set[tuple[int, int]] = set()
    for start, end in zip(starts[ends - starts > 1].tolist(), ends[ends - starts > 1].tolist(), strict=True):
        found.update(combinations(np.unique(owner[start:end]).tolist(), 2))
    return found


def shared_samples(first: Record, second: Record) -> int:
    """Number of samples in turn that two records share in all channels that both have, whatever their names and times.

    Samples that repeat the one before do not count, unless the records are equal.  One record may hold every k-th
    sample of the other.
    """
    names = sorted(first.channels.keys() & second.channels.keys())
    if len(names) < 2:
        return 0
    if first.n == second.n and all(
        np.array_equal(first.channels[k], second.channels[k], equal_nan=True) for k in names
    ):
        return first.n
    one, other = _rows(first, names), _rows(second, names)
    return max(_in_turn(one, other), _in_turn(other, one))


def _rows(record: Record, names: Sequence[str]) -> np.ndarray:
    """A number (N,) for each sample, the same for equal samples."""
    out = np.zeros(record.n, dtype=np.uint64)
    for name, factor in zip(names, FACTORS, strict=False):
        bits = (record.channels[name] + 0.0).view(np.uint64)  # -0 becomes 0
        mixed = (bits ^ (bits >> np.uint64(29))) * factor
        out += mixed ^ (mixed >> np.uint64(32))
    return out


def _in_turn(dense: np.ndarray, thin: np.ndarray) -> int:
    """Number of changing samples of `thin` that stand in `dense` with one shift and one stride."""
    rows, inverse = np.unique(dense, return_index=True)
    place = np.minimum(np.searchsorted(rows, thin), rows.size - 1)
    found = np.flatnonzero(rows[place] == thin)
    found = found[np.diff(thin[found], prepend=np.uint64(0)) != 0]
    if found.size < FEWEST:
        return 0
    at = inverse[place[found]]
    stride = max(1, round(float(np.median(np.diff(at) / np.diff(found)))))
    shifts, counts = np.unique(at - stride * found, return_counts=True)
    shift = int(shifts[counts.argmax()])
    low, high = max(0, -(shift // stride)), min(thin.size, (dense.size - 1 - shift) // stride + 1)
    if high - low < 2:
        return 0
    thin = thin[low:high]
    equal = dense[shift + stride * np.arange(low, high)] == thin
    return int(equal[0]) + int(np.sum(equal[1:] & (np.diff(thin) != 0)))
