"""The records of paper 000, made by its own difference equation (eq 8), and its published and reachable numbers."""

import numpy as np

from helmbench.datasets.record import Record

T1, T2, K, T3 = 2.2256, 2.9686, 2.2071, 2.2309
STEP_S = 0.1

# Reachable values of the protocol (20/20 zigzag, 20 s), in the order T2, T1, K, T3.
RLS = (2.967822816682175, 2.2253958456015503, 2.206231700675856, 2.2309195264661414)
FW_RLS = (2.9685649511183327, 2.2255908179633686, 2.2070608060120636, 2.2309008834762025)
AS_PRINTED = (3.2442287075756395, 2.45279756204046, 2.4094860712813766, 2.471833642697518)
BOUND_CONTINUOUS = (0.017420553495216342, 0.008402834047297542, 0.018128520195117164, 0.01094416340161591)
SWITCHES_CONTINUOUS = (0.1, 1.5, 4.0, 6.2, 8.4, 10.6, 12.8, 15.0, 17.2, 19.4)


def difference_record(samples=200):
    """20/20 zigzag by eq 8: heading and rudder, delta[0] = 0, step at k = 1, switched on psi[k-1]."""
    h, angle = STEP_S, np.deg2rad(20.0)
    psi, y, delta = np.zeros((3, samples + 1))
    order = angle
    for k in range(1, samples + 1):
        if order * psi[k - 1] > 0.0 and abs(psi[k - 1]) >= angle:
            order = -np.sign(psi[k - 1]) * angle
        delta[k] = order
        before = y[k - 2] if k > 1 else 0.0
        push = h**3 * K * delta[k] + h**2 * T3 * (delta[k] - delta[k - 1])
        y[k] = (2.0 * y[k - 1] - before + h * T1 * y[k - 1] + push) / (1.0 + h**2 * T2 + h * T1)
        psi[k] = psi[k - 1] + y[k]
    return Record(h * np.arange(samples + 1), {"heading_rad": psi, "rudder_rad": delta}, "paper 000")


def in_paper_order(parameters):
    """T2, T1, K, T3."""
    return np.array([parameters[name] for name in ("T2", "T1", "K", "T3")])
