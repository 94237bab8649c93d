"""What a measured set states: where it is published, its files, how they are read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..record import Record


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

    `read(content, name, manoeuvre)` turns the content of one stored file into a `Record`.  `convert(content)` turns
    the published file into the stored one (None: they are the same).  known : what is wrong with the records, found
    from the consistency of their channels.
    """

    url: str
    folder: str
    citation: str
    runs: Mapping[str, MeasuredRun]
    read: Callable[[bytes, str, str], Record]
    licence: str = "not stated; not redistributed here"
    known: str = ""
    convert: Callable[[bytes], bytes] | None = None

    def address(self, run: MeasuredRun) -> str:
        """Where the file of a run is published."""
        return "/".join(part for part in (self.url, run.below, run.published or run.file) if part)
