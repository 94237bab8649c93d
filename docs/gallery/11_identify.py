"""
A model from one record
=======================

Output error changes the coefficients until a free run, driven by the recorded rudder alone, lies on the record. The
result has standard errors and draws itself over any record.
"""

import helmbench

train = helmbench.simulate("response-1", "zigzag:20/20", noise="medium", seed=1)
estimate = helmbench.identify(train, "nomoto-1-cubic", "output-error")
print(estimate.to_dataframe())

# %%
# Along a record that took no part in the fit:

other = helmbench.simulate("response-1", "zigzag:10/10", noise="medium", seed=2)
print(f"R2 of the yaw rate: {estimate.score(other)['r2_free_yaw_rate_rad_s']:.4f}")
estimate.plot(other)
