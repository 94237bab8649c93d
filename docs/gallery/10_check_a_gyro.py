"""
A rate gyro with a zero error
=============================

No model of the ship is needed to see that a rate gyro is off: its integral must be the change of the heading. A zero
error of 0.05 deg/s is added to a record, and `check` finds it with its size.
"""

import numpy as np

import helmbench

record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1, dt_s=1.0)
biased = record.with_channels(yaw_rate_rad_s=record.column("yaw_rate_rad_s") + np.radians(0.05))

print(helmbench.check(record))
found = helmbench.check(biased)
print(found)

# %%
# The size with its interval:

found.plot()
