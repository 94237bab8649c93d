"""
A turn in wind and in current
=============================

A current carries the whole turning circle away. Wind pushes the hull as well, with a force that depends on the
heading, so that the circle is also deformed. Wind is given by where it blows from, a current by where it flows to.
"""

import matplotlib.pyplot as plt

import helmbench

weather = {
    "calm": "none",
    "current 0.5 m/s to the east": "current:0.5@90deg",
    "wind 12 m/s from the north": "wind:12@0deg",
}

figure, axes = plt.subplots(figsize=(6.5, 6), layout="constrained")
for label, disturbance in weather.items():
    record = helmbench.simulate("mariner", "turn:20", disturbance=disturbance, duration_s=1200.0, dt_s=1.0)
    axes.plot(record.column("east_m"), record.column("north_m"), label=label)
axes.set(xlabel="east [m]", ylabel="north [m]", aspect="equal", title="mariner: 20 degrees of rudder, 20 minutes")
axes.grid(True, linewidth=0.3)
axes.legend(fontsize="small")
