"""
Sampling step and difference scheme
===================================

Least squares needs accelerations, and takes them from differences between samples. Forward (Euler) differences are
wrong in the first power of the sampling step, the midpoint rule in the second. Without noise, what is left is
this, and the motion of the rudder between samples.
"""

import matplotlib.pyplot as plt

import helmbench

ship = helmbench.resolve("response-1")
record = helmbench.simulate(ship, "zigzag:20/20", dt_s=0.05)
every = (2, 4, 8, 16, 32)

figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
for scheme in ("forward", "midpoint"):
    method = helmbench.make_method(f"ls,scheme={scheme}")
    found = [helmbench.identify(record.thinned(n), "response-1", method).parameters["T"] for n in every]
    errors = [abs(value / ship.parameters["T"] - 1.0) for value in found]
    axes.loglog([0.05 * n for n in every], errors, "o-", label=scheme)
axes.set(xlabel="sampling step [s]", ylabel="relative error of T", title="response-1, without noise")
axes.grid(True, which="both", linewidth=0.3)
axes.legend()
