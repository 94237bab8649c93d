"""Diagnoser `nothing`: the base model is right."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .conclusion import OfFreeRuns

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from .conclusion import Chosen
    from .output_error import FilterRuns


class Nothing(OfFreeRuns):
    """Always says that nothing is wrong: what the others are compared with where most records are clean."""

    name = "nothing"
    title = "naive: nothing is wrong, whatever the records say"

    def choose(
        self, runs: FilterRuns, model: Model, train: Sequence[Record], options: Options
    ) -> tuple[Sequence[Chosen], str, str]:
        """Name nothing."""
        return [], "adequate", "nothing was looked for"
