"""Gazebo: inertia with added mass and the damping of the plugin gz::sim::systems::Hydrodynamics, also for VRX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import BadInput
from ..linear_algebra import lstsq
from ..model import Model
from ..simulate import accelerations
from .equations import heading, identifier, mass_matrix
from .texts import template

DRIFT_RAD, TURN = np.radians(20.0), 0.6
"""Largest drift angle, and yaw rate times length over speed, over which the damping is fitted."""
POINTS = 13
CROSS = {"V": "v", "R": "r", "VabsV": "v|v|", "RabsR": "r|r|", "VabsR": "v|r|", "RabsV": "r|v|"}
"""Ending of a tag -> the product of sway and yaw rate that it multiplies."""


class GazeboDamping(NamedTuple):
    """Tag -> coefficient, SI; thrust that holds the speed; share of each force's variance that the terms hold."""

    tags: Mapping[str, float]
    thrust_n: float
    held: Mapping[str, float]


def gazebo(model: Model) -> dict[str, str]:
    """File name -> text of the SDF elements for a link of the model at its service speed.

    Forces that the plugin's products cannot hold are left out, and their share is told in the file.  The rudder is a
    plugin of its own.

    Raises
    ------
    BadInput : the model is no 3-DOF model, or lacks its speed or displaced volume.
    """
    matrix = mass_matrix(model)
    volume, density = model.particulars.get("nabla"), model.environment_numbers()["rho"]
    if volume is None or not np.isfinite(model.speed_m_s):
        raise BadInput(f"{model.id}: displaced volume or speed is missing", hint="add nabla and speed_m_s to the model")
    mass = volume * density
    found = damping(model, matrix)
    gyration = model.particulars.get("k_zz", 0.25 * model.particulars["L"])
    inertia = mass * (gyration**2 + model.particulars.get("x_G", 0.0) ** 2)
    values = {
        "heading": heading(model),
        "model": model,
        "turn": TURN,
        "damping": found.tags,
        "thrust_n": found.thrust_n,
        "held": ", ".join(f"{axis} {share:.1%}" for axis, share in found.held.items()),
        "mass": mass,
        "inertia": inertia,
    }
    places = {"surge": (0, 0), "sway": (1, 1), "coupling": (1, 2), "yaw": (2, 2)}
    values |= {axis: float(matrix[place]) for axis, place in places.items()}
    return {f"{identifier(model)}.sdf.xml": template("gazebo.xml").render(values)}


def damping(model: Model, matrix: NDArray[np.float64]) -> GazeboDamping:
    """Least squares of the plugin's terms on the forces of the model beside its masses, over drift and yaw rate."""
    speed = model.speed_m_s
    drift, turn = np.meshgrid(np.linspace(-1, 1, POINTS) * DRIFT_RAD, np.linspace(-1, 1, POINTS) * TURN)
    v, r = (speed * np.sin(drift)).ravel(), (turn * speed / model.particulars["L"]).ravel()
    forces = _forces(model, matrix, np.full(v.size, speed), v, r)
    columns = np.stack([v, r, v * np.abs(v), r * np.abs(r), v * np.abs(r), r * np.abs(v)], axis=1)
    scale = np.abs(columns).max(axis=0)
    tags: dict[str, float] = {}
    held: dict[str, float] = {}
    for axis, name, own in (("Y", "y", forces[1]), ("N", "n", forces[2])):
        found = lstsq(columns / scale, own) / scale
        tags |= {f"{name}{ending}": float(value) for ending, value in zip(CROSS, found, strict=True)}
        held[axis] = 1.0 - float(np.var(own - columns @ found) / np.var(own))
    u = np.linspace(0.5, 1.1, POINTS) * speed
    surge = _forces(model, matrix, u, np.zeros(POINTS), np.zeros(POINTS))[0]
    thrust, drag = lstsq(np.stack([np.ones(POINTS), u * np.abs(u)], axis=1), surge)
    held["X"] = 1.0 - float(np.var(surge - thrust - drag * u * np.abs(u)) / np.var(surge))
    return GazeboDamping({"xUabsU": float(drag)} | tags, float(thrust), held)


def _forces(
    model: Model, matrix: NDArray[np.float64], u: Sequence[float] | NDArray[np.float64], v, r
) -> NDArray[np.float64]:
    """Forces and moment (3, N) beside M a + C(nu) nu, rudder amidships."""
    states = np.zeros((len(r), len(model.states)))
    for name, values in (("u", u), ("v", v), ("r", r)):
        states[:, model.states.index(name)] = values
    inputs = np.zeros((len(r), len(model.inputs)))
    if "n" in model.inputs:
        inputs[:, model.inputs.index("n")] = model.n0_rps or 0.0
    motion = np.stack([u, v, r])
    rates = accelerations(model, states, inputs).T[:3]
    return matrix @ rates + coriolis(matrix, motion)


def coriolis(matrix: NDArray[np.float64], motion: NDArray[np.float64]) -> NDArray[np.float64]:
    """C(nu) nu (3, N) of a mass matrix (Fossen 2021, eq. 6.43)."""
    u, v, r = motion
    sway = matrix[1, 1] * v + matrix[1, 2] * r
    return np.stack([-sway * r, matrix[0, 0] * u * r, sway * u - matrix[0, 0] * u * v])
