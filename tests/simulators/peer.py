"""A second nature: KVLCC2 by shipmmg, whose code and wake law are its own, with one constant changed.

`python -m tests.simulators.peer` prints what `diagnose` and `calibrate` name of each change; the base model is
ours with shipmmg's constants, so that beside the change only the wake law and two definitions differ
(`models/test_reference_kvlcc2`).
"""

from dataclasses import replace

import numpy as np

from helmbench import calibrate
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.datasets.record import Record
from helmbench.datasets.sensors import apply, parse_noise
from helmbench.diagnosis.diagnose import diagnose

from ..models.test_reference_kvlcc2 import CHANNELS, run_shipmmg, ship_of_shipmmg

TRAIN = ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port", "turn:35", "prbs:25deg/8s")
HELD_OUT = ("zigzag:10/10", "turn:20:port", "zigzag:25/15:port")
CHANGES = {
    "nothing": {},
    "rudder area": {"A_R": 1.213},
    "propeller": {"D_P": 1.06},
    "yaw inertia": {"I_zz": 1.3},
    "thrust deduction": {"t_P": 0.5},
}
"""What is changed in nature: factors on its constants."""
DT, SETTLED, DURATION = 0.2, 30.0, 100.0
"""Sampling, seconds that are left out until the ship has reached her speed, and duration of a record."""


def records(factors, texts, rng):
    """Records of shipmmg with some constants multiplied, steered as our model of it would be, with sensors' noise."""
    base, time = ship_of_shipmmg(), np.arange(0.0, SETTLED + DURATION + DT / 2, DT)
    constants = [v * factors.get(name, 1.0) for name, v in zip(base.constant_names, base.constants, strict=True)]
    nature, out = replace(base, constants=np.array(constants)), []
    for text in texts:
        run = record_run(base, parse_manoeuvre(text), duration_s=DURATION, dt_s=DT, seed=int(rng.integers(2**31)))
        rudder = np.append(np.zeros(time.size - run.n), run.rudder())
        states = run_shipmmg(nature, rudder, time, rtol=1e-6, atol=1e-8)[:, -run.n :]
        states[3:5] -= states[3:5, :1]
        channels = dict(zip(CHANNELS, states, strict=True)) | {"rudder_rad": run.rudder()}
        channels["propeller_rps"] = np.full(run.n, base.n0_rps)
        record = Record(run.time_s, channels, text.replace(":", "-").replace("/", "-"), run.meta)
        out.append(apply(record, parse_noise("low"), rng))
    return out


def main():
    """Print what is named of each change."""
    for name, factors in CHANGES.items():
        rng = np.random.default_rng(1)
        train, held_out = records(factors, TRAIN, rng), records(factors, HELD_OUT, rng)
        found, fitted = diagnose(ship_of_shipmmg(), train, held_out), calibrate(ship_of_shipmmg(), train, held_out)
        print(f"{name} {factors}")
        print("  diagnose", found.verdict, [(f.cause, f.details.get("groups"), f.tied_with) for f in found.causes])
        print(
            "  calibrate",
            fitted.verdict,
            [(m.name, round(m.after / m.before - 1.0, 3) if m.before else m.after) for m in fitted.moved],
        )
        for channel in ("heading_rad", "yaw_rate_rad_s", "surge_m_s"):
            print(
                "   ",
                channel,
                found.gain[channel].rmse_before,
                found.gain[channel].rmse_after,
                fitted.after[channel][1],
            )


if __name__ == "__main__":
    main()
