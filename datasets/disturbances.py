"""Disturbances: wind, current and waves, read from a text and turned into inputs of the 3-DOF kernels.

Texts, joined by ``+`` (each kind once), directions in degrees from north, clockwise::

    none
    wind:SPEED@FROM           m/s; mean plus gusts        wind:12@40deg
    steady-wind:SPEED@FROM    the mean only
    current:SPEED@TOWARDS     m/s; steady and uniform     current:0.5@90
    waves:HS/TP@FROM          m, s; long-crested JONSWAP  waves:3.25/9@30

Gusts are earth-fixed, both components independent: Gauss-Markov, sd 12 % of the mean, correlation time 20 s.

Waves do two things. Their mean second-order force is a force on the hull, F = rho g Hs^2 L C with
CX = -.010 cos(chi) (times .3 in following seas), CY = -.020 sin(chi)|sin(chi)|, CN = -.002 sin(2 chi) (times L),
chi the direction they come from against the bow (assumed coefficients, of the right order of magnitude). Their
first-order motion does not enter the equations: it is added to what the sensors see. The hull follows the water
averaged over its length at half its draught; with elevation a cos(theta) of one component, theta = w t - k xi + phase
at the ship's own place (so that the encounter frequency is theta's rate at any speed, heading and turn),
s = k L cos(gamma)/2, gamma the waves' direction of travel against the bow and E = exp(-k d/2)::

    displacement along the waves  a E sin(s)/s sin(theta)
    heading                      -a E (6/L) j1(s) sin(gamma) cos(theta)
    roll                          a E k sin(s)/s sin(gamma) sin(theta)

Velocities are their exact time derivatives (chain rule through theta and gamma), so that every channel stays
consistent with every other. The helmsman steers by the low-frequency heading (a perfect wave filter).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from ..models.errors import BadInput
from ..models.model import Model
from .grammar import ANGLE, DEGREE, pair, plain, positive, quantity
from .randomness import gauss_markov, key_of, stream
from .record import Record

GRAVITY = 9.81
WATER_DENSITY = 1025.0
GUST_SD, GUST_CORRELATION_S = 0.12, 20.0
PEAK_ENHANCEMENT = 3.3
COMPONENTS = 48
BAND = (0.6, 2.8)
DRAUGHT_OVER_LENGTH = 0.04
TRACK = ("north_m", "east_m", "surge_m_s", "sway_m_s")


class MeanWind(NamedTuple):
    """Mean wind: speed m/s, direction rad it blows from, with gusts or steady."""

    speed_m_s: float
    from_rad: float
    gusting: bool = True


class SteadyCurrent(NamedTuple):
    """Steady current: speed m/s, direction rad it flows towards."""

    speed_m_s: float
    towards_rad: float


class Waves(NamedTuple):
    """Sea state: significant height m, peak period s, direction rad the waves come from."""

    height_m: float
    period_s: float
    from_rad: float


@dataclass(frozen=True)
class Disturbance:
    """The disturbances of a run; read by `parse_disturbance`."""

    text: str = "none"
    wind: MeanWind | None = None
    current: SteadyCurrent | None = None
    waves: Waves | None = None

    def check(self, model: Model) -> None:
        """BadInput with one line if ``model`` cannot be exposed to this disturbance."""
        if not model.is_3dof and (self.wind or self.current):
            hint = "wind and current need a 3-DOF vessel"
            raise BadInput(f"{model.id} is a response model: disturbance {self.text!r} does not apply", hint=hint)
        if self.wind and model.windage is None:
            raise BadInput(f"{model.id}: the vessel file has no windage data", hint="add a windage block to it")
        if self.waves is not None:
            length(model)

    def environment(self, model: Model, time_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Input of the environment kernels at ``time_s`` (N+1,): array (N+1, 7).

        Columns: current north, east; wind velocity north, east (m/s, towards); body-fixed force X, Y in N and
        moment N in N m of the mean wave drift on the initial course, heading zero. Raises BadInput for a response
        model under wind or current.
        """
        self.check(model)
        key = key_of(rng)
        out = np.zeros((time_s.size, 7))
        if self.current is not None:
            out[:, 0:2] = _vector(self.current.speed_m_s, self.current.towards_rad)
        if self.wind is not None:
            out[:, 2:4] = wind_velocity(self.wind, time_s, stream(key, "gust"))
        if self.waves is not None and model.is_3dof:
            out[:, 4:7] = self.drift(model, np.zeros(time_s.size))
        return out

    def drift(self, model: Model, heading_rad: np.ndarray) -> np.ndarray:
        """Mean wave-drift force X, Y (N) and moment N (N m) at headings (N,), body-fixed: (N, 3)."""
        if self.waves is None:
            return np.zeros((heading_rad.size, 3))
        size = length(model)
        force = density(model) * GRAVITY * self.waves.height_m**2 * size
        return force * drift_coefficients(self.waves.from_rad - heading_rad) * np.array([1.0, 1.0, size])

    def motion(self, model: Model, record: Record, rng: np.random.Generator) -> Record:
        """The record with first-order wave motion added (the record itself if there are no waves).

        A 3-DOF vessel moves in heading, yaw rate, surge, sway, position and, as new channels, roll and roll
        rate; a response model in heading and yaw rate only. Needs heading_rad and yaw_rate_rad_s without gaps;
        raises BadInput if the vessel file gives no length.
        """
        if self.waves is None:
            return record
        components = wave_components(self.waves, stream(key_of(rng), "waves"))
        motion = wave_motion(model, record, self.waves, components)
        return record.with_channels(**moved_channels(record, motion, self.waves.from_rad + math.pi))


# ---- wind and waves as pure functions


def wind_velocity(wind: MeanWind, time_s: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Velocity (N, 2) of the air, north and east, m/s."""
    mean = -_vector(wind.speed_m_s, wind.from_rad)
    sd = GUST_SD * wind.speed_m_s if wind.gusting else 0.0
    gusts = [gauss_markov(time_s, sd, GUST_CORRELATION_S, rng) for _ in range(2)]
    return mean + np.column_stack(gusts)


def drift_coefficients(chi: np.ndarray) -> np.ndarray:
    """CX, CY, CN (N, 3) for waves from ``chi`` (N,) rad off the bow to starboard."""
    cosine, sine = np.cos(chi), np.sin(chi)
    ahead = -0.010 * cosine * np.where(cosine < 0.0, 0.3, 1.0)
    return np.column_stack([ahead, -0.020 * sine * np.abs(sine), -0.002 * np.sin(2.0 * chi)])


def jonswap(omega: np.ndarray, height_m: float, period_s: float) -> np.ndarray:
    """JONSWAP spectral density (N,) in m^2 s/rad at ``omega`` rad/s, gamma 3.3.

    Scaled by 1 - .287 ln(gamma) to the significant height. (DNV-RP-C205, 3.5.5.)
    """
    peak = 2.0 * math.pi / period_s
    width = np.where(omega <= peak, 0.07, 0.09)
    bump = PEAK_ENHANCEMENT ** np.exp(-0.5 * ((omega - peak) / (width * peak)) ** 2)
    scale = (1.0 - 0.287 * math.log(PEAK_ENHANCEMENT)) * 5.0 / 16.0 * height_m**2 * peak**4
    return scale * omega**-5.0 * np.exp(-1.25 * (peak / omega) ** 4) * bump


class Components(NamedTuple):
    """Regular waves (M,): frequency rad/s, amplitude m, phase rad."""

    omega: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray


def wave_components(waves: Waves, rng: np.random.Generator) -> Components:
    """Regular components of a sea: one random frequency in each band, random phases.

    The amplitudes hold exactly the energy Hs^2/16 (the spectrum's share outside .6 to 2.8 peak frequencies is
    spread over the band).
    """
    peak = 2.0 * math.pi / waves.period_s
    edges = np.linspace(BAND[0] * peak, BAND[1] * peak, COMPONENTS + 1)
    omega = rng.uniform(edges[:-1], edges[1:])
    energy = jonswap(omega, waves.height_m, waves.period_s)
    amplitude = np.sqrt(2.0 * energy * (waves.height_m**2 / 16.0) / np.sum(energy))
    return Components(omega, amplitude, rng.uniform(0.0, 2.0 * math.pi, COMPONENTS))


class FirstOrderMotion(NamedTuple):
    """First-order motion (N,) each, and rates: along the waves (m), heading and roll (rad)."""

    along: np.ndarray
    along_rate: np.ndarray
    heading: np.ndarray
    heading_rate: np.ndarray
    roll: np.ndarray
    roll_rate: np.ndarray


def wave_motion(model: Model, record: Record, waves: Waves, components: Components) -> FirstOrderMotion:
    """Motion of the hull in ``components`` along the record's own track."""
    travel = waves.from_rad + math.pi
    gamma = travel - record.column("heading_rad")
    turn = -record.column("yaw_rate_rad_s")
    # place, m, and speed, m/s, (N,) of the ship along the direction that the waves travel
    if record.has(*TRACK):
        surge, sway = record.column("surge_m_s"), record.column("sway_m_s")
        xi = record.column("north_m") * math.cos(travel) + record.column("east_m") * math.sin(travel)
        advance = surge * np.cos(gamma) + sway * np.sin(gamma)
    else:  # a response model has no track: its position is computed from its speed (0 if it has none) and its heading
        advance = (model.speed_m_s if math.isfinite(model.speed_m_s) else 0.0) * np.cos(gamma)
        step = 0.5 * (advance[1:] + advance[:-1]) * np.diff(record.time_s)
        xi = np.concatenate([[0.0], np.cumsum(step)])
    size, depth = length(model), draught(model)
    out = np.zeros((6, record.n))
    for omega, amplitude, phase in zip(*components, strict=True):
        k = omega**2 / GRAVITY
        theta = omega * record.time_s - k * xi + phase
        reach = amplitude * math.exp(-0.5 * k * depth)
        out += reach * _unit_motion(k, size, gamma, turn, theta, omega - k * advance)
    return FirstOrderMotion(*out)


def _unit_motion(
    k: float, size: float, gamma: np.ndarray, turn: np.ndarray, theta: np.ndarray, encounter: np.ndarray
) -> np.ndarray:
    """Rows of `FirstOrderMotion` (6, N) of a wave of unit amplitude; ``turn``, ``encounter``: rates of gamma, theta."""
    from scipy.special import spherical_jn

    sin_g, cos_g, sin_t, cos_t = np.sin(gamma), np.cos(gamma), np.sin(theta), np.cos(theta)
    s = 0.5 * k * size * cos_g
    s_rate = -0.5 * k * size * sin_g * turn
    j0, j1, j2 = (spherical_jn(order, s) for order in range(3))
    j0_rate, j1_rate = -j1 * s_rate, (j0 - 2.0 * j2) / 3.0 * s_rate
    swing = j1 * sin_g
    swing_rate = j1_rate * sin_g + j1 * cos_g * turn
    heel = j0 * sin_g
    heel_rate = j0_rate * sin_g + j0 * cos_g * turn
    lever = 6.0 / size
    return np.stack(
        [
            j0 * sin_t,
            j0_rate * sin_t + j0 * cos_t * encounter,
            -lever * swing * cos_t,
            lever * (swing * sin_t * encounter - swing_rate * cos_t),
            k * heel * sin_t,
            k * (heel_rate * sin_t + heel * cos_t * encounter),
        ]
    )


def moved_channels(record: Record, motion: FirstOrderMotion, travel_rad: float) -> dict[str, np.ndarray]:
    """The record's channels with the motion added; velocities over ground in the moved hull's own axes."""
    calm = record.column("heading_rad")
    heading = calm + motion.heading
    out = {"heading_rad": heading, "yaw_rate_rad_s": record.column("yaw_rate_rad_s") + motion.heading_rate}
    if not record.has(*TRACK):
        return out
    north, east = turned(record.column("surge_m_s"), record.column("sway_m_s"), calm)
    ahead, across = _vector(1.0, travel_rad)
    surge, sway = turned(north + ahead * motion.along_rate, east + across * motion.along_rate, -heading)
    place = {
        "north_m": record.column("north_m") + ahead * motion.along,
        "east_m": record.column("east_m") + across * motion.along,
    }
    roll = {"roll_rad": motion.roll, "roll_rate_rad_s": motion.roll_rate}
    return out | place | roll | {"surge_m_s": surge, "sway_m_s": sway}


def turned(x: np.ndarray, y: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Components of a vector after turning it by ``angle`` (body to earth for a heading)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return x * cosine - y * sine, x * sine + y * cosine


# ---- particulars


def length(model: Model) -> float:
    """Length between perpendiculars in m; BadInput if the vessel file gives none."""
    value = (model.particulars or {}).get("L")
    if not value:
        raise BadInput(f"{model.id} has no length in its file", hint="waves need particulars L")
    return float(value)


def draught(model: Model) -> float:
    """Draught in m (4 % of the length if the vessel file gives none)."""
    return float((model.particulars or {}).get("d") or DRAUGHT_OVER_LENGTH * length(model))


def density(model: Model) -> float:
    """Water density in kg/m^3 (1025 if the vessel file gives none)."""
    return float((model.particulars or {}).get("rho") or WATER_DENSITY)


def _vector(speed: float, direction: float) -> np.ndarray:
    return speed * np.array([math.cos(direction), math.sin(direction)])


# ---- texts


def parse_disturbance(text: str) -> Disturbance:
    """Read a disturbance text (see the module's head); BadInput with one line if it is malformed."""
    found = Disturbance()
    names = []
    for part in [] if text == "none" else text.split("+"):
        name, _, rest = part.partition(":")
        if name not in KINDS:
            forms = ", ".join(form for _, form, _ in KINDS.values())
            raise BadInput(f"unknown disturbance {part!r}", hint=f"expected none or {forms}")
        slot, form, read = KINDS[name]
        if getattr(found, slot) is not None:
            raise BadInput(f"disturbance {text!r} holds {slot} twice")
        try:
            value, canonical = read(rest)
        except ValueError as error:
            raise BadInput(f"disturbance {part!r}: {error}", hint=f"expected {form}") from None
        found = replace(found, **{slot: value})
        names.append(f"{name}:{canonical}")
    return replace(found, text="+".join(names) or "none")


def _directed(rest: str) -> tuple[str, float, str]:
    """Split ``what@DIRECTION``: (what, direction in rad, direction as text)."""
    what, at, direction = rest.partition("@")
    if not at:
        raise ValueError("no direction (@DEGREES)")
    angle = quantity(direction, ANGLE, "deg")
    return what, angle, plain(angle / DEGREE)


def _read_flow(
    rest: str, made_of: Callable[[float, float], MeanWind | SteadyCurrent]
) -> tuple[MeanWind | SteadyCurrent, str]:
    """What is made of speed, m/s, and direction, rad, and the canonical text of ``SPEED@DIRECTION``."""
    speed, angle, name = _directed(rest)
    value = positive(speed, {"m_s": 1.0}, "m_s")
    return made_of(value, angle), f"{plain(value)}@{name}"


def _read_waves(rest: str) -> tuple[Waves, str]:
    sea, angle, name = _directed(rest)
    height, period = pair(sea)
    hs, tp = positive(height, {"m": 1.0}, "m"), positive(period, {"s": 1.0}, "s")
    return Waves(hs, tp, angle), f"{plain(hs)}/{plain(tp)}@{name}"


KINDS = {
    "wind": ("wind", "wind:SPEED@FROM (m/s, degrees)", lambda rest: _read_flow(rest, MeanWind)),
    "steady-wind": ("wind", "steady-wind:SPEED@FROM", lambda rest: _read_flow(rest, partial(MeanWind, gusting=False))),
    "current": ("current", "current:SPEED@TOWARDS", lambda rest: _read_flow(rest, SteadyCurrent)),
    "waves": ("waves", "waves:HS/TP@FROM (m, s, degrees)", _read_waves),
}
"""Name -> what of a `Disturbance` it is, its form, and the reader of what stands behind the colon."""
