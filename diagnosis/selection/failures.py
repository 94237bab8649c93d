"""Candidates whose fit fails: the reason stands in the bank, and the selection goes on without them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from ..causes.base import Cause
    from ..state import State

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Failed:
    """A candidate that linear algebra or arithmetic gave no numbers for."""

    cause: Cause
    reason: str


def attempted(work: Callable[[T], R], cause_of: Callable[[T], Cause]) -> Callable[[T], R | Failed]:
    """Work on a candidate that says why it failed where a matrix is singular or a number not finite."""

    def guarded(item: T) -> R | Failed:
        try:
            return work(item)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            return Failed(cause_of(item), f"its fit fails: {error}")

    return guarded


def itself(cause: Cause) -> Cause:
    """The cause of work on a cause."""
    return cause


def sorted_out(state: State, found: Iterable[R | Failed]) -> tuple[State, list[R]]:
    """The state with what failed, and what did not."""
    every = list(found)
    failed = {one.cause: one.reason for one in every if isinstance(one, Failed)}
    kept = [one for one in every if not isinstance(one, Failed)]
    return (replace(state, failed={**state.failed, **failed}) if failed else state), kept
