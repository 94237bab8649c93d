"""
A rudder column that is twice too large
=======================================

Somebody has scaled the rudder column by two. The ship then seems to answer with half the rudder force, and the diagnosis says
so: the effectiveness is -0.5.
"""

import helmbench


def doubled(manoeuvre, seed):
    """A record of response-1 whose rudder column is twice the rudder."""
    record = helmbench.simulate("response-1", manoeuvre, noise="low", seed=seed)
    return record.with_channels(rudder_rad=2.0 * record.column("rudder_rad"), rudder_command_rad=None)


found = helmbench.diagnose("response-1", doubled("zigzag:20/20", 1), doubled("zigzag:10/10", 2))
for cause in found.causes:
    print(cause.cause, *(f"{size.parameter} = {size.value:.3f} {size.unit}" for size in cause.sizes))

# %%
# The record that was held out:

found.plot()
