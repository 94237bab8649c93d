"""
A current that the model does not know
======================================

The record was sailed in a current of 0.5 m/s to the east. The diagnosis tests two causes from outside, names one with
its size, and gives the extended model, which simulates the drift as well.
"""

import helmbench

train = helmbench.simulate(
    "mariner", "turn:20", noise="low", disturbance="current:0.5@90deg", seed=1, duration_s=400.0, dt_s=2.0
)
found = helmbench.diagnose("mariner", train, causes=["current", "wind"])
for cause in found.causes:
    print(cause.cause, *(f"{size.parameter} = {size.value:.3f} {size.unit}" for size in cause.sizes))
print(found.extended)

# %%
# The record, the model and the extended model:

found.plot()
