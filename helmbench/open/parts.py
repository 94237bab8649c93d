"""Parts of records that are proposed for an analysis: such as the analyses themselves take."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from ..datasets.columns import RUDDERS, TWIN
from ..datasets.copies import check_no_copies
from ..datasets.io import MIN_SAMPLES
from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..datasets.record import Record

TRAIN, HELD_OUT, UNUSED = "train", "held_out", "unused"
SHARE = 0.6
"""Share of a single manoeuvre that is for training."""
SHORTEST = 0.2
"""Share of the longest manoeuvre below which another one is a scrap."""
TESTS = 5 * MIN_SAMPLES
"""Samples of a single manoeuvre below which nothing of it is held out."""

Span = tuple[int, int, int, str, int]
"""Number of the record, its samples start:stop, what it is, and the how manieth of the record."""


def proposed(records: Sequence[Record], again: Collection[int]) -> list[dict[str, Any]]:
    """Parts that suit an identification: the manoeuvres, the last of them held out; of a single one its last 40 %.

    No two parts share samples, and none is a scrap.  Of records without what steers nothing is held out.

    again : numbers of the records that are the run of an earlier one again, as `copies` tells: they are not used.
    """
    spans = [span for number, record in enumerate(records) if number not in again for span in _spans(number, record)]
    longest = max((_seconds(records, span) for span in spans), default=0.0)
    spans = [span for span in spans if _seconds(records, span) >= SHORTEST * longest]
    found = [_part(records, span, TRAIN) for span in spans]
    if len(spans) == 1:
        found = _halves(records, spans[0])
    elif all(not lacks(records[span[0]]) for span in spans):
        found = [*found[:-1], *(part | {"role": HELD_OUT} for part in found[-1:])]
    rest = [_part(records, (number, 0, records[number].n, "record", 1), UNUSED) for number in sorted(again)]
    return found + rest


def copies(records: Sequence[Record]) -> dict[int, str]:
    """Number of each record that is the run of an earlier one again -> what says so."""
    if not _refusal(records):
        return {}
    found: dict[int, str] = {}
    for number, record in enumerate(records):
        why = _refusal([records[i] for i in range(number) if i not in found], [record])
        found |= {number: why} if why else {}
    return found


def _refusal(records: Sequence[Record], others: Sequence[Record] | None = None) -> str:
    """Why an analysis refuses the records, some of which are the run of others again; '' where it does not."""
    try:
        check_no_copies(records, others)
    except BadInput as error:
        return str(error)
    return ""


def lacks(record: Record) -> list[str]:
    """What a record has not got that a model of its ship needs."""
    steered = any(map(record.has, RUDDERS)) or record.has(*TWIN)
    turning = record.has("heading_rad") or record.has("yaw_rate_rad_s")
    return [
        *([] if steered else ["a rudder angle, measured or ordered, or the thrusts of two propellers"]),
        *([] if turning else ["a heading or a yaw rate"]),
    ]


def _spans(number: int, record: Record) -> list[Span]:
    """The manoeuvres of a record that share no sample; all of it where there is none."""
    from ..datasets.importing.segments import find_segments

    found: list[Span] = []
    for one in find_segments(record):
        start = max(one.start, found[-1][2] if found else 0)
        if one.kind != "straight" and one.stop - start >= MIN_SAMPLES:
            found.append((number, start, one.stop, one.kind, len(found) + 1))
    return found or [(number, 0, record.n, "record", 1)]


def _seconds(records: Sequence[Record], span: Span) -> float:
    number, start, stop, _, _ = span
    return float(records[number].time_s[stop - 1] - records[number].time_s[start])


def _part(records: Sequence[Record], span: Span, role: str) -> dict[str, Any]:
    number, start, stop, kind, place = span
    time = records[number].time_s
    return {"record": number, "name": f"{records[number].name}-{kind}-{place}", "role": role,
            "from": float(time[start]), "to": float(time[stop - 1])}  # fmt: skip


def _halves(records: Sequence[Record], span: Span) -> list[dict[str, Any]]:
    """A single manoeuvre, its end held out where both are long enough."""
    number, start, stop, kind, place = span
    whole = _part(records, span, TRAIN)
    if stop - start < TESTS or lacks(records[number]):
        return [whole]
    middle = start + round(SHARE * (stop - start))
    end = _part(records, (number, middle, stop, kind, place), HELD_OUT)
    return [_part(records, (number, start, middle, kind, place), TRAIN), end | {"name": f"{whole['name']}-end"}]
