"""What files of priors, bounds and fixed values hold for each published parameter."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field, model_validator

from ....models.yaml_file import FileContent, Positive, Real, Text, needs

Bound = Annotated[float, Field(strict=True), needs("a number")]


class PriorEntry(FileContent):
    """Mean and standard deviation, [mean, sd] for short; without a unit in that of the parameter."""

    mean: Real
    sd: Positive
    unit: Text | None = None


class BoundsEntry(FileContent):
    """Low and high, [low, high] for short; null (or an infinite number) where there is no bound."""

    low: Bound | None = None
    high: Bound | None = None
    unit: Text | None = None

    @model_validator(mode="after")
    def _has_room(self) -> BoundsEntry:
        low, high = self.pair
        if not low < high:
            raise ValueError(f"{low!r} and {high!r}: the first must be below the second")
        return self

    @property
    def pair(self) -> tuple[float, float]:
        """Low and high, infinite where there is no bound."""
        low = float("-inf") if self.low is None else self.low
        return low, float("inf") if self.high is None else self.high


class FixedEntry(FileContent):
    """A value, or the number alone."""

    value: Real
    unit: Text | None = None


SHORT: dict[type[FileContent], tuple[str, ...]] = {
    PriorEntry: ("mean", "sd"),
    BoundsEntry: ("low", "high"),
    FixedEntry: ("value",),
}
"""Kind of entry -> the keys that a short form stands for."""


def written_out(kind: type[FileContent], value: Any) -> Any:
    """An entry with its keys, where it was given in the short form."""
    if isinstance(value, dict):
        return value
    parts = list(value) if isinstance(value, list | tuple) else [value]
    if len(parts) != len(SHORT[kind]):
        raise ValueError(f"{value!r} is not {'a pair of numbers' if len(SHORT[kind]) > 1 else 'a number'}")
    plain = [part.item() if hasattr(part, "item") else part for part in parts]
    return dict(zip(SHORT[kind], plain, strict=True))
