"""Between the true motion and the record: the rudder linkage and the sensors, as named numbers.

`Model.instruments` maps these names to values (SI); what is not named is ideal.

Rudder: the recorded angle goes through delay, rate limit, stop (saturation), play (backlash), effectiveness and
offset, in this order; `models.rudder_chain` holds the equations.  A fault changes the effectiveness from
rudder_fault_time (of the record) on.  All in the sign of the record.
The recorded angle itself lies behind play of +- rudder_hysteresis of the rudder's sensor, and is late by
rudder_sensor_delay; both are undone first.
Sensors: recorded = (1 + CHANNEL_scale) true(t - CHANNEL_delay) + CHANNEL_bias + CHANNEL_drift (t - start of the
record); the scale of a speed log that is not linear is 1 + surge_scale + surge_curve |surge|.  Velocities and positions
are those of a point point_ahead ahead of the hull's (sway + point_ahead yaw rate); surge and sway are then turned by
axis_misalignment, or given in the earth frame where earth_frame_velocity is 1; swap_A_B = 1 exchanges two columns.
Waves: narrow-band motion of rms wave_rms around wave_frequency is added to heading and yaw rate.
Logger: a true second takes 1 + clock_rate seconds of the recorded time.
Size: the record is of a similar ship 1 + ship_scale times as long as the model's, after Froude: lengths go with the
scale, times and speeds with its square root, rates and revolutions with the inverse of that; `similar` says it by
clock and sensors.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from .errors import BadInput

RUDDER = {
    "rudder_effectiveness": "1",
    "rudder_offset": "rad",
    "rudder_delay": "s",
    "rudder_backlash": "rad",
    "rudder_fault": "1",
    "rudder_fault_time": "s",
    "rudder_rate_limit": "rad/s",
    "rudder_saturation": "rad",
    "rudder_reversed": "1",
}
"""Numbers of the linkage, in the order in which `linkage` gives them."""
SENSORS = {
    "heading": ("heading_rad", "rad"),
    "yaw_rate": ("yaw_rate_rad_s", "rad/s"),
    "surge": ("surge_m_s", "m/s"),
    "sway": ("sway_m_s", "m/s"),
    "north": ("north_m", "m"),
    "east": ("east_m", "m"),
    "roll_rate": ("roll_rate_rad_s", "rad/s"),
}
"""Short name of a sensor -> its column and unit."""
SWAPS = {f"swap_{a}_{b}": (SENSORS[a][0], SENSORS[b][0]) for a, b in combinations(SENSORS, 2)}
"""Name of an exchange -> the two columns."""
WAVES = {"wave_frequency": "rad/s", "wave_damping": "1", "wave_rms": "rad"}
INSTRUMENTS: dict[str, str] = {
    **RUDDER,
    **{f"{name}_bias": unit for name, (_, unit) in SENSORS.items()},
    **{f"{name}_drift": f"{unit}/s" for name, (_, unit) in SENSORS.items()},
    **{f"{name}_scale": "1" for name in SENSORS},
    **{f"{name}_delay": "s" for name in SENSORS},
    "axis_misalignment": "rad",
    "earth_frame_velocity": "1",
    **dict.fromkeys(SWAPS, "1"),
    **WAVES,
    "surge_curve": "s/m",
    "point_ahead": "m",
    "rudder_hysteresis": "rad",
    "rudder_sensor_delay": "s",
    "clock_rate": "1",
    "ship_scale": "1",
}
"""Name -> unit of everything that `Model.instruments` may hold."""
ADDING = (
    "rudder_delay",
    "rudder_backlash",
    "rudder_hysteresis",
    "rudder_sensor_delay",
    "axis_misalignment",
    "point_ahead",
    *(f"{name}_delay" for name in SENSORS),
)
RATIOS = ("rudder_effectiveness", "clock_rate", "ship_scale")
"""Instruments that multiply by 1 + their value."""
POWERS = {"clock": 0.5, "surge": 0.5, "sway": 0.5, "north": 1.0, "east": 1.0, "yaw_rate": -0.5, "roll_rate": -0.5}
"""Clock or sensor -> power of the scale that its factor is, in records of a similar ship."""
SWITCHES = ("rudder_reversed", "earth_frame_velocity", *SWAPS)
LIMITS = ("rudder_rate_limit", "rudder_saturation")


def checked(instruments: Mapping[str, float], file: object = None) -> dict[str, float]:
    """The instruments as plain numbers; BadInput for an unknown name or a value that is not finite."""
    for name, value in instruments.items():
        if name not in INSTRUMENTS:
            hint = "rudder_..., SENSOR_bias, SENSOR_scale, SENSOR_delay and others: see models/instruments.py"
            raise BadInput(f"unknown instrument {name!r}", file=file, hint=hint)
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise BadInput(f"instrument {name}: {value!r} is not a finite number", file=file)
        if value < 0.0 and (name.endswith("_delay") or name in (*LIMITS, "rudder_backlash", "rudder_hysteresis")):
            raise BadInput(f"instrument {name}: {value!r} is negative", file=file)
        if name in RATIOS[1:] and value <= -1.0:
            raise BadInput(f"instrument {name}: {value!r} must be larger than -1", file=file)
    return {name: float(value) for name, value in instruments.items()}


def similar(instruments: Mapping[str, float]) -> dict[str, float]:
    """The instruments with a ship's scale told by what it changes of clock and sensors."""
    out, scale = dict(instruments), 1.0 + instruments.get("ship_scale", 0.0)
    if scale == 1.0:
        return out
    for short, power in POWERS.items():
        name = "clock_rate" if short == "clock" else f"{short}_scale"
        out[name] = (1.0 + out.get(name, 0.0)) * scale**power - 1.0
    return out


def bent(true: np.ndarray, gain: float, curve: float) -> np.ndarray:
    """What a sensor whose gain grows by `curve` with a unit of its channel shows of true values, without its bias."""
    return true * (gain + curve * np.abs(true))


def straightened(shown: np.ndarray, gain: float, curve: float) -> np.ndarray:
    """The true values of which such a sensor shows these; those beyond what it can show are what it shows most of."""
    return 2.0 * shown / (gain + np.sqrt(np.maximum(gain**2 + 4.0 * curve * np.abs(shown), 0.0)))


def linkage(instruments: Mapping[str, float]) -> np.ndarray:
    """The rudder's numbers (9,) in the order of `RUDDER`, as `rudder_chain` takes them; 0 where ideal."""
    return np.array([instruments.get(name, 0.0) for name in RUDDER])


def combined(own: Mapping[str, float], found: Mapping[str, float]) -> dict[str, float]:
    """The instruments of a model that had `own` ones, after its corrected records showed `found` ones.

    Scales (a curve to first order), biases and rates of the clock of both in turn, delays, play and angles added,
    limits the tighter, switches exchanged; a fault and waves are taken from `found` where it has them.
    """
    out = {**own, **found}
    for name in SENSORS:
        outer, inner = own.get(f"{name}_scale", 0.0), found.get(f"{name}_scale", 0.0)
        out[f"{name}_scale"] = (1.0 + outer) * (1.0 + inner) - 1.0
        for error in (f"{name}_bias", f"{name}_drift"):
            out[error] = (1.0 + outer) * found.get(error, 0.0) + own.get(error, 0.0)
    first, second = (1.0 + q.get("surge_scale", 0.0) for q in (own, found))
    out["surge_curve"] = own.get("surge_curve", 0.0) * second**2 + found.get("surge_curve", 0.0) * first
    for name in RATIOS:
        out[name] = (1.0 + own.get(name, 0.0)) * (1.0 + found.get(name, 0.0)) - 1.0
    second = found.get("rudder_effectiveness", 0.0)
    out["rudder_offset"] = (1.0 + second) * own.get("rudder_offset", 0.0) + found.get("rudder_offset", 0.0)
    out |= {name: own.get(name, 0.0) + found.get(name, 0.0) for name in ADDING}
    out |= {name: (own.get(name, 0.0) + found.get(name, 0.0)) % 2.0 for name in SWITCHES}
    out |= {name: min(own.get(name, 0.0) or np.inf, found.get(name, 0.0) or np.inf) for name in LIMITS}
    return {name: float(value) for name, value in out.items() if value != 0.0 and np.isfinite(value)}
