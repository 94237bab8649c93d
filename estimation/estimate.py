"""The result of one fit."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..models.model import Model
    from .predictor import Predictor


@dataclass(frozen=True)
class Estimate:
    """The result of one fit; SI units and radians throughout.

    `coefficients` (p,) and `covariance` (p, p) are in the model's coordinates, `parameters` and `stderr` are the
    published parameters and their standard errors (delta method; inf where the records do not tell, nan where no
    error is known).  `trajectory` (N, p) holds the recursion of a recursive method.
    """

    method: str
    variant: str
    model: Model
    coefficients: np.ndarray
    covariance: np.ndarray | None
    parameters: dict[str, float]
    stderr: dict[str, float]
    trajectory: np.ndarray | None = None
    trajectory_time_s: np.ndarray | None = None
    converged: bool = True
    message: str = ""
    n_iterations: int = 1
    wall_s: float = 0.0
    cpu_s: float = 0.0
    extra: dict[str, Any] = field(default_factory=dict)
    predictor: Predictor | None = None

    def save(self, path: str | Path) -> None:
        """Write the model with the estimated coefficients, as `--model` reads it back.

        Raises
        ------
        BadInput : if the file cannot be written, or the estimate is a black box.
        """
        if self.predictor is not None:
            raise BadInput(f"{self.method} has no coefficients to write as a model file", file=path)
        from ..models.model import model_to_json

        model_to_json(self.model, path)
