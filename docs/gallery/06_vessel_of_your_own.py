"""
A vessel of your own
====================

A family of models becomes a vessel by its parameters. The vessel is used like any other: here it sails a zigzag, and
a model is identified from the record, which gives the parameters back.
"""

import helmbench

family = helmbench.resolve("nomoto-1-cubic")
ship = family.with_coefficients(family.from_parameters({"T": 21.0, "K": 0.11, "alpha": 140.0}))
record = helmbench.simulate(ship, "zigzag:20/20", noise="low", seed=1, duration_s=300.0, dt_s=0.5)
record.plot()

# %%
# Estimates with their standard errors:

estimate = helmbench.identify(record, "nomoto-1-cubic", "output-error")
print(estimate.to_dataframe())
