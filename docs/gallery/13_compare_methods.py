"""
Methods side by side on one record
==================================

Least squares, its robust relatives and output error fit the same model to the same noisy record. The
error is that of free runs along a record that took no part.
"""

import helmbench

train = helmbench.simulate("response-1", "zigzag:20/20", noise="medium", seed=1)
other = helmbench.simulate("response-1", "zigzag:10/10", noise="medium", seed=2)
found = helmbench.compare(train, "nomoto-1-cubic", ["ls", "huber", "iv", "output-error"], validate=other)
print(found.to_dataframe()[["method", "error", "chosen"]])

# %%
# A logarithmic axis:

found.plot()
