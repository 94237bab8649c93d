"""Choices of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..models.errors import BadInput
from .causes.registry import cause

if TYPE_CHECKING:
    from ..checks.base import Check
    from ..models.model import Model


THREADS = 2


@dataclass(frozen=True)
class Options:
    """Choices of a diagnosis, as `helmbench.diagnose` takes and explains them.

    channels : columns of the records.  only : its `causes`.
    threads : threads that run the filter; the results do not depend on them.
    """

    base_parameters: str | None = None
    coefficient_sd: float | None = None
    channels: tuple[str, ...] | None = None
    max_effects: int = 3
    alpha: float = 0.01
    seed: int = 0
    only: tuple[str, ...] | None = None
    threads: int = THREADS

    def checked(self, model: Model) -> Options:
        """The options with defaults for a model; BadInput for a value that cannot be."""
        base = self.base_parameters or ("file" if model.known else "identify")
        if base not in ("file", "identify"):
            raise BadInput(f"base parameters {base!r}", hint="file or identify")
        if base == "file" and not model.known:
            raise BadInput(f"model {model.id} carries no coefficients", hint="use --base-parameters identify")
        if not 0.0 < self.alpha < 0.5 or self.max_effects < 1 or (self.coefficient_sd or 0.0) < 0.0 or self.threads < 1:
            hint = "alpha lies in 0 .. 0.5, max effects and threads are at least 1, coefficient sd at least 0"
            raise BadInput("an option is out of its range", hint=hint)
        self.causes()
        return replace(self, base_parameters=base)

    def causes(self) -> frozenset[Check] | None:
        """The causes that the bank is restricted to; BadInput for an unknown one."""
        if self.only is None:
            return None
        return frozenset(map(cause, self.only))
