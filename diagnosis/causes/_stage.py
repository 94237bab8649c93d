"""Causes that a stage of its own looks for: in the records before the bank, or in the base model after it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class StageCause(Cause):
    """Base class of causes that a stage of its own looks for; the bank does not hold them.

    stage : where it is looked for, as a reason why the bank does not test it.
    """

    unit = "1"
    stage: ClassVar[str]

    def variants(self, est: Estimator) -> Sequence[Variant]:
        raise NotTestable(self.stage)
