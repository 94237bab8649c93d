"""Drift angles that go with the heading: a compass that deviates, a current, and a log that stands askew."""

import numpy as np

from helmbench.checks.check import check
from helmbench.datasets.record import Record, RecordMeta


def cruise(rng, current=0.0, askew_rad=0.0):
    """A craft that makes way at changing speed, most of it towards north, and sways with its turn, with the velocities
    over ground that a log tells which is turned by `askew_rad`; current (m/s) towards north."""
    time = np.arange(1200) * 0.25
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    side = np.sin(0.042 * time + phase[0])
    heading = 2.2 * side**3
    rate = 6.6 * side**2 * 0.042 * np.cos(0.042 * time + phase[0])
    ahead = 1.4 + 0.4 * np.sin(0.11 * time + phase[1])
    velocity = (ahead - 0.4j * rate) * np.exp(1j * heading) + current
    body = velocity * np.exp(-1j * (heading + askew_rad))
    place = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * 0.25)])
    true = {"heading_rad": heading, "yaw_rate_rad_s": rate, "surge_m_s": body.real, "sway_m_s": body.imag}
    true |= {"north_m": place.real, "east_m": place.imag, "rudder_rad": 0.3 * np.cos(0.042 * time + phase[0])}
    noise = dict.fromkeys(true, 3e-3) | {"north_m": 0.05, "east_m": 0.05}
    return Record(
        time, {n: v + noise[n] * rng.standard_normal(time.size) for n, v in true.items()}, "run", RecordMeta()
    )


def deviations(record):
    return [f for f in check([record]).findings if "compass_deviation" in (f.cause, *f.tied_with) and f.material]


def test_velocities_over_ground_in_a_current_may_be_a_current(rng):
    findings = [f for _ in range(5) for f in deviations(cruise(rng, current=0.15))]
    assert findings and all("current" in f.tied_with for f in findings)


def test_a_log_that_stands_askew_is_no_deviation(rng):
    assert not deviations(cruise(rng, askew_rad=0.09))
