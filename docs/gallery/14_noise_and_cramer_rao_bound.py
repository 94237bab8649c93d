"""
Noise, and the smallest error that is possible
==============================================

No unbiased method can have a smaller standard deviation than the Cramer-Rao bound. Twenty records with other noise
show how near output error and least squares on forward differences come to it for the gain K. These differentiate the
noise, which costs accuracy and biases K. The bound takes the rudder as exactly known. Noise of the measured rudder
angle, which the preset `low` has too, drives the model and comes on top: the third row.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

runs = 20
exact_rudder = "heading=0.02deg,yaw_rate=0.01deg_s"
many, noisy_rudder = (
    helmbench.simulate_many("response-1", "zigzag:20/20", runs, noise=noise, seed=1) for noise in (exact_rudder, "low")
)
truth = helmbench.resolve("response-1").parameters["K"]
gains = {
    name: [helmbench.identify(given.record(i), "response-1", method).parameters["K"] for i in range(runs)]
    for name, method, given in (
        ("output-error", "output-error", many),
        ("ls-forward", "ls-forward", many),
        ("output-error, noisy rudder", "output-error", noisy_rudder),
    )
}

# %%
# The bound belongs to the estimate from one of the records.

estimate = helmbench.identify(many.record(0), "response-1", "output-error")
bound = next(p.sd for p in estimate.identifiability(many.record(0)).parameters if p.name == "K")
print(f"bound {bound:.2g}", *(f"{name} {np.std(found, ddof=1):.2g}" for name, found in gains.items()), sep="\n")

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for row, (name, found) in enumerate(gains.items()):
    axes.plot(found, np.full(runs, row), "|", markersize=18, label=name)
axes.axvspan(truth - 2 * bound, truth + 2 * bound, alpha=0.2, label="truth, twice the bound")
axes.set(xlabel="K [1/s]", yticks=range(len(gains)), yticklabels=list(gains), ylim=(-0.6, len(gains) - 0.4))
axes.legend(fontsize="small")
