"""Kinds of suites: who plans and runs them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from ..runner import Selection, Spec
    from ..suites import Suite

IDENTIFICATION, DIAGNOSIS = "identification", "diagnosis"


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


MODULES = {IDENTIFICATION: "..runner", DIAGNOSIS: ".diagnosis.runner"}
"""Kind -> the module that plans and runs it."""


def runner_of(kind: str) -> Runner:
    """The runner module of a kind."""
    return cast(Runner, import_module(MODULES[kind], __package__))
