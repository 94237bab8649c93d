"""What the runner, the store and the command line know of suites and their kinds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

from ...models.errors import BadInput

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


@dataclass(eq=False, kw_only=True)
class RunKind:
    """What the runner executes and the store keeps.

    name : `kind` in manifests.  stored : gives the tables.
    execute : gives the finished run of a spec, `{"key", "row", "parameters"}`, with built-in types only; failures are
    in its row.
    content : gives a digest of what is run, whatever the suite is called, by which equal runs of the same code are
    known; None: it is always run anew.
    """

    name: str
    stored: Callable[[], Tables]
    execute: Callable[[Any], dict[str, Any]]
    content: Callable[[Any], str | None] = lambda spec: None

    @property
    def tables(self) -> Tables:
        """What is stored."""
        return self.stored()


@dataclass(eq=False, kw_only=True)
class Kind(RunKind):
    """A kind of suite; its name is the folder's, `kind` also in suite files.

    failure_columns : columns by which a failed run is listed.
    with_seed : gives the selection with the seed that the plan starts from; `BadInput` for one that cannot be used.
    plan : gives every run, in order; `BadInput` for unknown methods or vessels, and where nothing is left to run.
    facts : gives what the manifest of specs says beside what it says of every suite.
    describe : gives a failed run's row in words.
    check : raises `BadInput` where something that specs need is missing on this machine.
    """

    failure_columns: tuple[str, ...]
    with_seed: Callable[[Suite, RunSelection], RunSelection]
    plan: Callable[[Suite, RunSelection], Sequence[Any]]
    facts: Callable[[Sequence[Any]], Mapping[str, Any]]
    describe: Callable[[Mapping[str, Any]], str]
    check: Callable[[Iterable[Any]], object] = lambda specs: None
