"""The biases of every log: a neutral rudder angle, and the zero of the yaw rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...checks.result import Size


@dataclass(frozen=True)
class Biases:
    """Biases that would clearly lower the errors of a model that was identified without them.

    sizes : of each bias, SI, with 90 % intervals; `parameter` is `rudder_offset` (the acting rudder angle is the
    recorded one plus this, in the model's sign, rad) or `yaw_rate_bias` (the sensor shows so much too much, rad/s).
    parameters : published parameters of the model when they are estimated along with the biases.
    before, after : channel -> root mean square error of free runs of whole records, SI, of the identified model, and
    of the model with these parameters behind the biases.
    """

    sizes: tuple[Size, ...]
    parameters: Mapping[str, float]
    before: Mapping[str, float]
    after: Mapping[str, float]

    def to_json(self) -> dict[str, Any]:
        """Plain values for identification.json."""
        return {
            "sizes": [vars(size) for size in self.sizes],
            "parameters": dict(self.parameters),
            "rmse_before": dict(self.before),
            "rmse_after": dict(self.after),
        }
