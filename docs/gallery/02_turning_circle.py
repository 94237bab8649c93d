"""
Turning circles at three rudder angles
======================================

The rudder is put over on a straight course and held. The larger its angle, the smaller the tactical diameter, and the
more speed the ship loses in the turn.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

angles_deg = (10, 20, 35)
turns = helmbench.simulate_many(
    "mariner",
    [f"turn:{angle}" for angle in angles_deg],
    len(angles_deg),
    duration_s=900.0,
    channels=["north_m", "east_m"],
    indices=["tactical_diameter", "steady_speed"],
)

figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
for angle, north, east in zip(angles_deg, turns.channels["north_m"], turns.channels["east_m"], strict=True):
    axes.plot(east, north, label=f"rudder {angle} deg")
axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal", title="mariner: turning circles")
axes.grid(True, linewidth=0.3)
axes.legend()

# %%
# The indices are those of the motion itself, without noise.

print(turns.indices_to_dataframe()[list(turns.indices)].round(2))
assert np.all(np.diff(turns.indices["tactical_diameter"]) < 0.0)
