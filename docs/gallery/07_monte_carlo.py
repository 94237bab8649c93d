"""
How far uncertain coefficients move the overshoot
=================================================

Six linear derivatives of the Mariner are each uncertain by 5 %. Two hundred draws of them sail the same 10/10 zigzag
at once, and the spread of the overshoot angles is what the uncertainty means for the ship.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

runs, rng = 200, np.random.default_rng(1)
ship = helmbench.resolve("mariner")
uncertain = ("Yv", "Nv", "Yr", "Nr", "Yd", "Nd")
drawn = {name: ship.parameters[name] * rng.normal(1.0, 0.05, runs) for name in uncertain}
overshoots = ["first_overshoot", "second_overshoot"]
found = helmbench.simulate_many("mariner", "zigzag:10/10", runs, parameters=drawn, channels=[], indices=overshoots)

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for name in overshoots:
    axes.hist(np.degrees(found.indices[name]), bins=25, alpha=0.7, label=name.replace("_", " "))
axes.set(
    xlabel="overshoot [deg]", ylabel="runs", title=f"{runs} draws of the coefficients, {found.diverged.sum()} diverged"
)
axes.legend()

# %%
# The overshoots go together: a derivative that raises the first raises the second.

print(f"correlation {np.corrcoef(*found.indices.values())[0, 1]:.2f}")
