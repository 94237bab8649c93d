"""What the runner, the store and the command line know of suites and their kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar

from ...models.errors import BadInput

if TYPE_CHECKING:
    from ...models.yaml_file import FileContent

TIMES = {"wall_s": "float", "cpu_s": "float", "peak_memory_mib": "float"}
"""The last columns of a table of runs, and the only ones in which two equal runs may differ."""


MOST_RUNS = 100_000
"""Runs of a suite beyond which it is refused: it would not end."""

Planned = TypeVar("Planned")


def limited(specs: Iterable[Planned], suite: str) -> list[Planned]:
    """The planned runs as a list; BadInput where there are too many."""
    found = list(islice(specs, MOST_RUNS + 1))
    if len(found) > MOST_RUNS:
        hint = "take fewer seeds, methods or conditions"
        raise BadInput(f"plans more than {MOST_RUNS} runs", file=f"suite {suite}", hint=hint)
    return found


class Spec(Protocol):
    """One planned run: plain data that can be named in a row and sent to a worker."""

    @property
    def key(self) -> str:
        """Identifier that is the same in every process and session."""
        ...

    def row_key(self) -> dict[str, Any]:
        """The key columns of the tables."""
        ...


@dataclass(frozen=True)
class RunSelection:
    """What of a suite is run; empty and None mean what the suite says.

    `methods` not named by an open entry are added to it; `vessels` also selects measured sets by their names.
    `seed` is where a suite that draws its cases starts from.
    """

    suite: str = "quick"
    methods: tuple[str, ...] = ()
    vessels: tuple[str, ...] = ()
    seeds: int | None = None
    seed: int | None = None


@dataclass(frozen=True)
class Suite:
    """A named list of entries; `digest` changes with the file's content.

    `folder` is that of the file; names of files in it may be relative to it.  `head` holds the keys beside the entries;
    it and the entries are instances of the models of the suite's kind.
    """

    name: str
    digest: str
    kind: str
    head: Any = field(repr=False)
    entries: tuple[Any, ...] = field(repr=False)
    folder: Path = field(repr=False)

    @property
    def title(self) -> str:
        """The suite in a few words; the file's name where it has no title."""
        return self.head.title or self.name

    @property
    def texts(self) -> tuple[str, ...]:
        """Every text that the file holds, such as those of methods."""
        return tuple(_texts_in([part.model_dump() for part in (self.head, *self.entries)]))


def _texts_in(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict | list | tuple):
        for part in value.values() if isinstance(value, dict) else value:
            yield from _texts_in(part)


@dataclass(frozen=True)
class Tables:
    """The two tables of a kind: one row per run, and a long one with several rows per run.

    Columns are name -> type (string, int, float or bool).  Rows are sorted by `keys`, those of the long table also by
    `long_keys`.
    """

    keys: tuple[str, ...]
    wide_file: str
    wide: Mapping[str, str]
    long_file: str
    long: Mapping[str, str]
    long_keys: tuple[str, ...]


class RunKind(ABC):
    """What the runner executes and the store keeps.

    name : `kind` in manifests.
    """

    name: ClassVar[str]

    @property
    @abstractmethod
    def tables(self) -> Tables:
        """What is stored."""

    @abstractmethod
    def execute(self, spec: Any) -> dict[str, Any]:
        """One finished run, `{"key", "row", "parameters"}`, with built-in types only; failures become its row."""

    def content(self, spec: Any) -> str | None:
        """Digest of all that the result depends on, whatever the suite is called; None: it is always run anew."""
        return None


class Kind(RunKind):
    """A kind of suite; its name is the folder's, `kind` also in suite files.

    failure_columns : columns by which a failed run is listed.
    """

    failure_columns: ClassVar[tuple[str, ...]]

    @abstractmethod
    def suite_models(self) -> tuple[type[FileContent], type[FileContent]]:
        """What a suite file holds beside its entries, and an entry, as pydantic models."""

    @abstractmethod
    def with_seed(self, suite: Suite, selection: RunSelection) -> RunSelection:
        """The selection with the seed that the plan starts from; `BadInput` for one that cannot be used."""

    @abstractmethod
    def plan(self, suite: Suite, selection: RunSelection) -> Sequence[Spec]:
        """Every run, in order; `BadInput` for unknown methods or vessels, and where nothing is left to run."""

    @abstractmethod
    def facts(self, specs: Sequence[Any]) -> Mapping[str, Any]:
        """What the manifest says beside what it says of every suite."""

    @abstractmethod
    def describe(self, row: Mapping[str, Any]) -> str:
        """A failed run in words."""

    def check(self, specs: Iterable[Any]) -> None:
        """Raise `BadInput` where something that the runs need is missing on this machine."""
