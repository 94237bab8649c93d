"""
A rudder column that is twice too large
=======================================

Somebody has scaled the rudder column by two. A diagnosis compares the records with the model before it looks for
causes, and says so in its doubts. The named cause has the same size: with an effectiveness of -0.5 half of the rudder
force is missing.
"""

import helmbench


def doubled(manoeuvre, seed):
    """A record of the Mariner whose rudder column is twice the rudder."""
    record = helmbench.simulate("mariner", manoeuvre, noise="low", seed=seed, dt_s=2.0)
    return record.with_channels(rudder_rad=2.0 * record.column("rudder_rad"), rudder_command_rad=None)


causes = ["rudder_effectiveness", "rudder_offset", "rudder_delay"]
found = helmbench.diagnose("mariner", doubled("zigzag:15/15", 1), doubled("zigzag:10/10", 2), causes=causes)
print(*found.doubts, sep="\n")
for cause in found.causes:
    print(cause.cause, *(f"{size.parameter} = {size.value:.3f}" for size in cause.sizes))

# %%
# The record that was held out:

found.plot()
