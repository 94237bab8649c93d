"""Kinds of suites: who plans, runs and reports them.  A new kind is two modules and a line here."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from .store import DIAGNOSIS, IDENTIFICATION

if TYPE_CHECKING:
    from .report import Report
    from .runner import Selection, Spec
    from .suites import Suite


class Runner(Protocol):
    """What the runner module of a kind offers; `runner` says what each does."""

    LISTED: tuple[str, ...]
    settled: Callable[[Suite, Selection], Selection]
    plan: Callable[[Suite, Selection], Sequence[Spec]]
    check: Callable[[Iterable[Any]], None]
    facts: Callable[[Suite, Sequence[Any]], Mapping[str, Any]]
    warm: Callable[[Iterable[Any]], None]
    execute: Callable[[Any], dict[str, Any]]
    describe: Callable[[Mapping[str, Any]], str]


MODULES = {IDENTIFICATION: (".runner", ".report"), DIAGNOSIS: (".diagnosing.runner", ".diagnosing.page")}
"""Kind -> its runner and its report."""


def runner_of(kind: str) -> Runner:
    """The runner module of a kind."""
    return cast(Runner, import_module(MODULES[kind][0], __package__))


def write_report(directory: str | Path, timing: str | Path | None = None) -> Report:
    """Report a run directory by the kind of its suite; raises what the report of that kind does."""
    from .store import read_manifest

    kind = read_manifest(Path(directory)).get("kind", IDENTIFICATION)
    return import_module(MODULES[kind][1], __package__).write_report(directory, timing)
