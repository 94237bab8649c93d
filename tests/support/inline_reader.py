"""Binary logs are read in this process: where it is not the subject, a process for each takes most of a test's time."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from helmbench.datasets.importing import contained
from helmbench.datasets.importing.raw import RawTable
from helmbench.models.errors import BadInput


@contextmanager
def without_processes(but_first: bool = False) -> Iterator[None]:
    """Logs are read here; `but_first`: the first of each kind is read in a process of its own, as in use."""
    in_process = set(contained.READERS) if but_first else set()

    def read(kind: str, data: bytes, path: Path) -> list[RawTable]:
        if kind in in_process:
            in_process.remove(kind)
            return contained.read_contained(kind, data, path)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = contained.answer(kind, data, path)
        if isinstance(found, BadInput):
            raise found
        return found

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("helmbench.datasets.importing.sources.read_contained", read)
        yield
