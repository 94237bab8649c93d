"""
A zigzag manoeuvre
==================

In a 20/20 zigzag the rudder goes to the other side whenever the heading is 20 degrees off the initial course. The
heading goes on beyond that: this is the overshoot angle by which IMO MSC.137(76) judges how well a ship can be
checked.
"""

import numpy as np

import helmbench

record = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1, dt_s=1.0)
record.plot(["rudder_rad", "heading_rad", "yaw_rate_rad_s"])

# %%
# `validate` computes the overshoot angles of a record and of a model that sails the same manoeuvre.

for index in helmbench.validate("mariner", record).indices:
    measured, simulated = np.degrees([index.measured, index.simulated])
    print(f"{index.name}: {measured:.2f} deg measured, {simulated:.2f} deg simulated")
