"""What a measured set states: where it is published, its files, how they are read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ..record import Record


@dataclass(frozen=True)
class Run:
    """One file of a measured set: its name, its SHA-256, the manoeuvre that it holds, and the folder below the set's
    address in which it is published."""

    file: str
    sha256: str
    manoeuvre: str
    below: str = ""


@dataclass(frozen=True)
class Dataset:
    """A measured set: public address, folder below `data_dir()`, runs by stem, reader of the raw bytes.

    `read(content, name, manoeuvre)` turns the content of one file into a `Record`.  known : what is wrong with the
    records, found from the consistency of their channels.
    """

    url: str
    folder: str
    citation: str
    runs: Mapping[str, Run]
    read: Callable[[bytes, str, str], Record]
    licence: str = "not stated; not redistributed here"
    known: str = ""
