"""What stands in the filter's parameter vector: a model's own numbers, then rudder, environment and sensors.

`[coefficients and constants of the model's bank variant, OUTER]`.  The names of OUTER are those of
`models.instruments` (rudder chain, sensors, waves) and of the parameters of `models.families.extensions`
(environment), so that a cause, an extension and an instrument mean the same number.  All values are SI, 0 where an
effect is absent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....models.extend import NEUTRAL
from ....models.instruments import RUDDER
from ....models.kernels import Kernels
from ....models.model import Model

SYMBOLS = ("psi", "r", "u", "v", "x", "y")
"""States that the six channels of the filter measure."""
SENSORS = ("heading", "yaw_rate", "surge", "sway", "north", "east")
"""Names of these channels in the instruments of a model."""
CHANNELS = len(SYMBOLS)
ENVIRONMENT = (
    *("current_towards_north", "current_towards_east", "wind_towards_north", "wind_towards_east"),
    *("constant_X", "constant_Y", "constant_N", "wave_drift_north", "wave_drift_east"),
)
"""Steady current and wind (m/s), constant force (N, N, N m) and mean wave drift (N), earth-fixed but for the force."""
OUTER = (
    *RUDDER,
    *ENVIRONMENT,
    *(f"{name}_scale" for name in SENSORS),
    *(f"{name}_bias" for name in SENSORS),
    *(f"{name}_delay" for name in SENSORS),
    *("axis_misalignment", "earth_frame_velocity", "wave_frequency", "wave_damping", "wave_rms"),
    *("clock_jitter", "reference_speed"),
)
"""Numbers behind the model's own.  reference_speed (m/s) is the speed on a straight course of response models, whose
surge channel shows reference_speed (1 - speed loss)."""
PLACE = {name: index for index, name in enumerate(OUTER)}
N_CHAIN = len(RUDDER)
CURRENT, FORCE, DRIFT = (PLACE[name] for name in ("current_towards_north", "constant_X", "wave_drift_north"))
SCALE, BIAS, DELAY = PLACE["heading_scale"], PLACE["heading_bias"], PLACE["heading_delay"]
MISALIGNMENT, EARTH, OMEGA, ZETA, RMS, JITTER, SPEED = (
    PLACE[name]
    for name in (
        *("axis_misalignment", "earth_frame_velocity", "wave_frequency", "wave_damping", "wave_rms"),
        *("clock_jitter", "reference_speed"),
    )
)
WAVES_WITHOUT_EFFECT = {"wave_frequency": 0.7, "wave_damping": 0.1}
"""Frequency (rad/s) and damping of waves whose rms is zero: they must not be zero themselves."""
DEFAULT_WINDAGE = {
    **{"rho_air": 1.225, "A_F": 450.0 / 160.93**2, "A_L": 1800.0 / 160.93**2},
    **{"wind_cx": 0.7, "wind_cy": 0.8, "wind_cn": 0.1, "wind_kn": 0.0, "wind_delta": 0.0},
}
"""Wind coefficients where a vessel file has none (those declared for Mariner; areas as shares of L^2)."""


def state_of(symbol: str, states: Sequence[str]) -> str | None:
    """The state that a channel measures: its own, or for the surge of a response model the speed loss."""
    if symbol in states:
        return symbol
    return "speed_loss_state" if symbol == "u" and "speed_loss_state" in states else None


def names_of(kernels: Kernels) -> tuple[str, ...]:
    """Names of all entries of the vector."""
    return (*kernels.COEFFICIENTS, *kernels.CONSTANTS, *OUTER)


def base_vector(model: Model, kernels: Kernels) -> np.ndarray:
    """Parameter vector (NP,) of the model with every effect absent."""
    length = model.particulars.get("L", 1.0)
    numbers = {name: 0.0 for name in kernels.CONSTANTS} | NEUTRAL | {"rho": 1025.0, "wind_L": length}
    numbers |= {k: v * length**2 if k.startswith("A_") else v for k, v in DEFAULT_WINDAGE.items()}
    numbers |= dict(model.windage or {}) | rigid_body(model)
    numbers |= {"rho": model.particulars["rho"]} if "rho" in model.particulars else {}
    numbers |= dict(zip(model.constant_names, model.constants, strict=True))
    outer = [WAVES_WITHOUT_EFFECT.get(name, 0.0) for name in OUTER]
    return np.concatenate([model.coefficients, [numbers[name] for name in kernels.CONSTANTS], outer])


def rigid_body(model: Model) -> dict[str, float]:
    """Mass [kg], m x_G [kg m] and yaw inertia [kg m2] of the hull; a radius of gyration of L/4 where none is known."""
    known = {**model.particulars, **dict(zip(model.constant_names, model.constants.tolist(), strict=True))}
    if not model.is_3dof or "nabla" not in known:
        return {}
    mass, length = known.get("rho", 1025.0) * known["nabla"], known["L"]
    centre, radius = known.get("x_G", 0.0), known.get("k_zz", 0.25 * length)
    prime = 0.5 * known.get("rho", 1025.0) * length**5
    inertia = known.get("I_zz", known["I_z"] * prime if "I_z" in known else mass * radius**2)
    return {"rigid_mass": mass, "rigid_moment": mass * centre, "rigid_inertia": inertia}
