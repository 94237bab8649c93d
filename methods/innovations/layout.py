"""Channels of the innovations filter and the parameters that stand behind a model's own vector."""

from __future__ import annotations

CHANNELS = 6
WIND_DRIFT = (0.010, 0.020, 0.002)
"""Mean wave drift force coefficients in surge, sway and yaw (those of datasets.disturbances)."""

OUTER = (
    *("rudder_effectiveness", "rudder_offset", "rudder_delay", "rudder_play", "fault", "fault_time"),
    *("rudder_rate", "rudder_limit", "current_n", "current_e", "wind_n", "wind_e"),
    *("force_0", "force_1", "force_2", "drift_n", "drift_e"),
    *(f"scale_{c}" for c in ("psi", "r", "u", "v", "x", "y")),
    *(f"bias_{c}" for c in ("psi", "r", "u", "v", "x", "y")),
    *(f"delay_{c}" for c in ("psi", "r", "u", "v", "x", "y")),
    *("misalignment", "earth_frame", "wave_frequency", "wave_damping", "wave_rms", "clock"),
)
"""Parameters behind the model's own vector: rudder, environment, sensors, waves."""
PLACE = {name: index for index, name in enumerate(OUTER)}
(E_D, D_0, TAU_D, PLAY, E_F, T_0, RATE, LIMIT, V_N, V_E, W_N, W_E, F_0, _, _, D_N, D_E) = range(17)
S_C, B_C, TAU_C = PLACE["scale_psi"], PLACE["bias_psi"], PLACE["delay_psi"]
MISALIGNED, EARTH, OMEGA, ZETA, RMS, CLOCK = (
    PLACE[name] for name in ("misalignment", "earth_frame", "wave_frequency", "wave_damping", "wave_rms", "clock")
)
KINK = 12.0
"""Second difference of the rudder, in its sensor's sd, from which a corner lies between samples."""
BETWEEN = 0.12
"""Error of the mean rudder between two samples with a corner between them, as a share of the second difference, where
nothing is known of how the rudder moves there."""
