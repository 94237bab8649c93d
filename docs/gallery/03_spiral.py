"""
A spiral: is the ship stable on a straight course?
==================================================

In Dieudonne's spiral the rudder goes in steps from one side to the other and back, and waits at each until the yaw
rate is steady. The steady yaw rate over the rudder angle is one curve for a ship that keeps its course; an unstable
ship has a loop.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

record = helmbench.simulate("mariner", "spiral:25/5", duration_s=16000.0, dt_s=1.0)
rudder = np.degrees(record.column("rudder_command_rad"))
rate = np.degrees(record.column("yaw_rate_rad_s"))

# %%
# The last sample before each change of the command is taken as steady.

last = np.append(np.flatnonzero(np.diff(rudder)), len(rudder) - 1)
figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
axes.plot(rudder[last], rate[last], "o-", markersize=4)
axes.set(xlabel="rudder [deg]", ylabel="steady yaw rate [deg/s]", title="mariner: spiral")
axes.axhline(0.0, color="black", linewidth=0.5)
axes.axvline(0.0, color="black", linewidth=0.5)
axes.grid(True, linewidth=0.3)
