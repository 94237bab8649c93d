"""
Sensor noise in four levels
===========================

The same turn is measured without noise and with the noise levels `low`, `medium` and `high`. A level has a standard
deviation for every channel; the seed makes the numbers repeatable.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

levels = ("high", "medium", "low", "none")
records = {level: helmbench.simulate("response-1", "zigzag:20/20", noise=level, seed=3) for level in levels}

figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
for level, record in records.items():
    axes.plot(record.time_s, np.degrees(record.column("yaw_rate_rad_s")), linewidth=1.0, label=level)
axes.set(xlabel="time [s]", ylabel="yaw rate [deg/s]", title="yaw rate of response-1, by noise level")
axes.grid(True, linewidth=0.3)
axes.legend()

# %%
# What the noise has added, as a standard deviation:

calm = records["none"].column("yaw_rate_rad_s")
for level in ("low", "medium", "high"):
    added = records[level].column("yaw_rate_rad_s") - calm
    print(f"{level}: {np.degrees(added.std()):.4f} deg/s")
