"""What a measured set states: where it is published, its files, how they are read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..record import Record, RecordMeta, Side

Columns = tuple[np.ndarray, dict[str, np.ndarray]]
"""Time (N,), s, and channels (N,) in SI units and radians."""


@dataclass(frozen=True)
class MeasuredRun:
    """One file of a measured set: its name and SHA-256 as stored, and the manoeuvre that it holds.

    below : folder below the set's address in which it is published.
    published : name of the published file where it is not `file`.
    """

    file: str
    sha256: str
    manoeuvre: str
    below: str = ""
    published: str = ""


@dataclass(frozen=True)
class Dataset:
    """A measured set: public address, folder below `data_dir()`, runs by stem, reader of the raw bytes.

    `read(content)` gives the columns of one stored file; positions are those of midship.  `convert(content)` turns
    the published file into the stored one (None: they are the same).  vessel, positive_rudder, notes : as in the
    metadata of a record.  known : what is wrong with the records, found from the consistency of their channels.
    """

    url: str
    folder: str
    citation: str
    runs: Mapping[str, MeasuredRun]
    read: Callable[[bytes], Columns]
    notes: str
    positive_rudder: Side
    vessel: str | None = None
    licence: str = "not stated; not redistributed here"
    known: str = ""
    convert: Callable[[bytes], bytes] | None = None

    def record(self, content: bytes, stem: str) -> Record:
        """One run, from the content of its stored file."""
        time, channels = self.read(content)
        meta = RecordMeta(
            vessel=self.vessel,
            reference_point="midship",
            source=self.citation,
            licence=self.licence,
            positive_rudder=self.positive_rudder,
            manoeuvre=self.runs[stem].manoeuvre,
            notes=self.notes,
        )
        return Record(time, channels, name=stem, meta=meta)

    def address(self, run: MeasuredRun) -> str:
        """Where the file of a run is published."""
        return "/".join(part for part in (self.url, run.below, run.published or run.file) if part)
