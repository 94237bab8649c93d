"""What the linear regression y = Phi c of a model is evaluated at: states, accelerations and inputs of one record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ...models.errors import CannotFit
from ...models.model import Model
from ..numerics import factors

LONGEST_STEP = 3.0
"""Multiple of the median time step above which a step counts as a gap."""


@dataclass(frozen=True)
class RegressionSamples:
    """What the regression of one record is evaluated at, gaps left out.

    states (N, s), accelerations (N, k) and inputs (N, i) in the order of the model's regression, SI units and radians;
    time_s (N,); `scale` multiplies the rows.
    """

    states: np.ndarray
    accelerations: np.ndarray
    inputs: np.ndarray
    time_s: np.ndarray
    scale: float = 1.0
    source: str = ""
    """Channel that the yaw rate is taken from, where a record gives rows from several."""

    def at(self, rows: slice | np.ndarray) -> Self:
        """The samples of some rows."""
        states, accelerations, inputs = (
            np.ascontiguousarray(part[rows]) for part in (self.states, self.accelerations, self.inputs)
        )
        return replace(self, states=states, accelerations=accelerations, inputs=inputs, time_s=self.time_s[rows])

    def blocks(self, model: Model, size: int = factors.BLOCK) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Pieces (y (n, k), phi (n, k, p)) of the regression in order, at most `size` samples each."""
        from ...models.simulate import regression

        for start in range(0, len(self.time_s), size):
            cut = slice(start, start + size)
            y, phi = regression(model, self.states[cut], self.accelerations[cut], self.inputs[cut])
            yield y * self.scale, phi * self.scale


def n_accelerations(model: Model) -> int:
    """Number k of the regression's states, counted from the first, whose acceleration stands on the left side."""
    return 3 if model.is_3dof else 1


def check_states(model: Model, known: Sequence[str] = ("q", "r", "psi", "u", "v", "x", "y")) -> None:
    """Refuse a model whose regression has a state beside the known ones.

    Raises
    ------
    CannotFit : naming it.
    """
    for symbol in model.regression_states:
        if symbol not in known:
            raise CannotFit(f"model {model.id} has the state {symbol!r}, for which records have no channel")


def check_enough_rows(n: int, model: Model) -> None:
    """Refuse n regression rows if they are no more than the model's coefficients.

    Raises
    ------
    CannotFit : naming both numbers.
    """
    if n <= len(model.coordinates):
        raise CannotFit(f"{n} usable regression rows for {len(model.coordinates)} coefficients")


def table(columns: dict[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray:
    """Columns (N, len(names)) in the order of the names."""
    return np.column_stack([columns[name] for name in names])
