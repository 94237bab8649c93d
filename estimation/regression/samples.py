"""What the linear regression y = Phi c of a model is evaluated at: states, accelerations and inputs of one record."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ...models.errors import CannotFit
from ...models.model import Model
from ..numerics import factors

Columns = Mapping[str, np.ndarray]
"""Symbol of a state or input -> its samples (N,)."""
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
    start: np.ndarray | None = None
    """(N, n) what the initial state of a filter can add to each row, zero once it has decayed: it is projected out."""

    @classmethod
    def of(
        cls, model: Model, states: Columns, slopes: Columns, inputs: Columns, time_s: np.ndarray, **facts: Any
    ) -> Self:
        """The samples of columns (N,) by symbol, slopes being those of the states that have an acceleration.

        Heading and position are zero where they are left out: no equation depends on them.

        Raises
        ------
        CannotFit : the model's regression has a state without a column.
        """
        known = {**dict.fromkeys(("psi", "x", "y"), np.zeros(len(time_s))), **states}
        if unknown := [symbol for symbol in model.regression_states if symbol not in known]:
            raise CannotFit(f"model {model.id} has the state {unknown[0]!r}, for which records have no channel")
        x, u = table(known, model.regression_states), table(inputs, model.regression_inputs)
        return cls(x, table(slopes, model.regression_states[: n_accelerations(model)]), u, time_s, **facts)

    def at(self, rows: slice | np.ndarray) -> Self:
        """The samples of some rows."""
        states, accelerations, inputs = (
            np.ascontiguousarray(part[rows]) for part in (self.states, self.accelerations, self.inputs)
        )
        own = {"time_s": self.time_s[rows], "start": None if self.start is None else self.start[rows]}
        return replace(self, states=states, accelerations=accelerations, inputs=inputs, **own)

    def blocks(self, model: Model, size: int = factors.BLOCK) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Pieces (y (n, k), phi (n, k, p)) of the regression in order, at most `size` samples each; the first is as
        long as the effect of a filter's initial state, which is removed from it."""
        from ...models.simulate import regression

        head = 0 if self.start is None else int(np.count_nonzero(self.start.any(axis=1)))
        cuts = [slice(start, start + size) for start in range(head, len(self.time_s), size)]
        for cut in [slice(head), *cuts] if head else cuts:
            y, phi = regression(model, self.states[cut], self.accelerations[cut], self.inputs[cut])
            if self.start is not None and cut.start is None:
                basis, _ = np.linalg.qr(self.start[cut])
                y, phi = y - basis @ (basis.T @ y), phi - np.tensordot(basis, np.tensordot(basis.T, phi, 1), 1)
            yield y * self.scale, phi * self.scale


def n_accelerations(model: Model) -> int:
    """Number k of the regression's states, counted from the first, whose acceleration stands on the left side."""
    return 3 if model.is_3dof else 1


def check_enough_rows(n: int, model: Model) -> None:
    """Refuse n regression rows if they are no more than the model's coefficients.

    Raises
    ------
    CannotFit : naming both numbers.
    """
    if n <= len(model.coordinates):
        raise CannotFit(f"{n} usable regression rows for {len(model.coordinates)} coefficients")


def table(columns: Columns, names: tuple[str, ...]) -> np.ndarray:
    """Columns (N, len(names)) in the order of the names."""
    return np.column_stack([columns[name] for name in names])
