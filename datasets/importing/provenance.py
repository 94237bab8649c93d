"""Of every channel of a record: from which columns it is, and whether they are stated, told or assumed."""

from __future__ import annotations

from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import dataclass

from .draft import DraftColumn, Sure
from .finding import LEVELS

TOLD: dict[Sure, str] = {
    "stated": "stated", "other channel": "told by another channel", "physics": "told by physics", "guess": "assumed",
}  # fmt: skip
"""How surely a column is known, in words."""


@dataclass(frozen=True)
class ChannelSource:
    """A channel of a record, the columns that it is made of, and how surely: the least sure of them."""

    record: str
    channel: str
    columns: tuple[str, ...]
    sure: str
    why: str


def channel_sources(
    record: str, channels: Sequence[str], sources: Dict[str, Sequence[str]], columns: Sequence[DraftColumn]
) -> list[ChannelSource]:
    """The sources of the channels of a record.

    sources : channel -> quantities that it is made of.  columns : of the tables of the record.
    """
    own = {channel: [c for c in columns if c.quantity in sources.get(channel, ())] for channel in channels}
    return [_source(record, channel, found) for channel, found in own.items()]


def _source(record: str, channel: str, columns: Sequence[DraftColumn]) -> ChannelSource:
    least = max((c.sure for c in columns), key=LEVELS.index, default="guess")
    why = "; ".join(dict.fromkeys(f"{c.column}: {c.why}" for c in columns))
    return ChannelSource(record, channel, tuple(c.column for c in columns), TOLD[least], why)
