"""Planted nulls: the force of an effect as it acts in another record, so that no cause of the motion explains it.

Knock-offs in the sense of Barber & Candes 2015 (Ann. Stat. 43, 2055): the size, spectrum and shape of the true effect
without its relation to the record's own rudder and motion.  What a diagnosis names of them is a false discovery.
"""

from __future__ import annotations

import numpy as np

from . import equations
from .ships import SECOND, TrueShip
from .simulator import DenseRun, RunPlan, first_class_functions, further_forces, rudder_force, vector

EVERY = 10
"""Steps of the simulation between two forces that are computed; linear between them."""


def foreign_forces(plan: RunPlan, sound: TrueShip, run: DenseRun) -> np.ndarray:
    """Forces X, Y, N (n + 1, 3) that the effects of a plan add along a run, backwards in time and without their mean.

    A mean would be a constant force, which a diagnosis may name.
    """
    steps = np.arange(len(run.states))
    at = np.append(steps[:-1:EVERY], steps[-1])
    ill, well = (
        np.array([forces(one, run, int(k), rudder) for k in at])
        for one, rudder in ((plan, run.hull), (RunPlan(sound), run.rudder))
    )
    added = ill - well
    series = np.column_stack([np.interp(steps, at, column) for column in added.T])
    return (series - series.mean(axis=0))[::-1]


def forces(plan: RunPlan, run: DenseRun, step: int, rudder: np.ndarray) -> np.ndarray:
    """X, Y, N (3,) that give the accelerations of a plan's ship at a step of a run; of a response ship the yaw one."""
    ship, out = plan.ship, np.zeros(8)
    args = equations.ship_vector(ship, *rudder_force(ship)), vector(plan.dynamic), *further_forces(plan.extra)
    state, angle = run.states[step], float(rudder[2 * step])
    with first_class_functions():
        equations.derivative(
            ship.kind, ship.coefficients, *args, step * run.step_s, state, angle, 0.0, 0.0, 0.0, np.zeros(5), out
        )
    if ship.is_3dof:
        return ship.mass @ out[:3]
    return np.array([0.0, 0.0, out[1 if ship.kind == SECOND else 2]])
