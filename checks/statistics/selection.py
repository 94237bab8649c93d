"""One forward selection for every criterion: screen, refit the leaders, accept the best, go on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, TypeVar

S = TypeVar("S")
C = TypeVar("C")


class Criterion(Protocol[S, C]):
    """A way to judge candidates, of type C, beside what has entered a state, of type S."""

    def tried(self, now: S, step: int) -> tuple[S, Sequence[C]]:
        """The leaders of a screen of all candidates, refitted, and the state with what the screen says."""
        ...

    def entered(self, now: S, tried: Sequence[C], step: int) -> S | None:
        """The state with the candidate that enters, everything refitted; None where none does."""
        ...


def grown(criterion: Criterion[S, C], start: S, most: int) -> S:
    """The state after at most `most` steps, in each of which a candidate enters."""
    now = start
    for step in range(most):
        now, tried = criterion.tried(now, step)
        further = criterion.entered(now, tried, step)
        if further is None:
            break
        now = further
    return now
