"""
Noise, and the smallest error that is possible
==============================================

No unbiased method can have a smaller standard deviation than the Cramer-Rao bound. Twenty records with other noise
show how near output error and least squares come to it for the gain K. Least squares differentiates the noise, which
costs accuracy and biases K.
"""

import matplotlib.pyplot as plt
import numpy as np

import helmbench

runs = 20
many = helmbench.simulate_many("response-1", "zigzag:20/20", runs, noise="low", seed=1)
truth = helmbench.resolve("response-1").parameters["K"]
gains = {
    method: [helmbench.identify(many.record(i), "response-1", method).parameters["K"] for i in range(runs)]
    for method in ("output-error", "ls")
}

# %%
# The bound belongs to the estimate from one of the records.

estimate = helmbench.identify(many.record(0), "response-1", "output-error")
bound = next(p.sd for p in estimate.identifiability(many.record(0)).parameters if p.name == "K")
print(f"bound {bound:.2g}", *(f"{method} {np.std(found, ddof=1):.2g}" for method, found in gains.items()), sep="\n")

figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
for row, (method, found) in enumerate(gains.items()):
    axes.plot(found, np.full(runs, row), "|", markersize=18, label=method)
axes.axvspan(truth - 2 * bound, truth + 2 * bound, alpha=0.2, label="truth, twice the bound")
axes.set(xlabel="K [1/s]", yticks=range(len(gains)), yticklabels=list(gains), ylim=(-0.6, 1.6))
axes.legend(fontsize="small")
