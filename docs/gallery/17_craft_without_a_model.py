"""
A craft without a model
=======================

Where no model of a craft is known, `build_model` starts from the simplest law that steers it, and adds what the records
show that it lacks. The outcome says how far ahead the model can be trusted.
"""

import helmbench

train = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1, dt_s=1.0)
other = helmbench.simulate("mariner", "zigzag:10/10", noise="low", seed=2, dt_s=1.0)
found = helmbench.build_model(train, other)
print(found)
print(found.reason)

# %%
# The model that was built and the steering law alone, over the record that was held out:

found.plot()
