"""What methods share that take prior knowledge of the published parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..estimation.methods_only.likelihood import options
from .base import Method

if TYPE_CHECKING:
    from ..estimation.likelihood.unknowns import Unknowns
    from ..models.model import Model


class PriorMethod(Method):
    """Base class of methods with the options `prior`, `bounds` and `fixed` (see `output-error`)."""

    prior: Any
    bounds: Any
    fixed: Any

    def check_options(self) -> None:
        super().check_options()
        options.check(self.prior, self.bounds, self.fixed)

    def visible(self, model: Model) -> Model:
        return model

    def unknowns(self, model: Model) -> Unknowns | None:
        """The parameters that are estimated of a model with the known values; None: all coefficients, freely."""
        return options.unknowns_of(model, self.prior, self.bounds, self.fixed)
