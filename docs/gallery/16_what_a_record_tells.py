"""
What a record tells, and what to sail next
==========================================

A record with small rudder angles tells little about the damping at large yaw rates. `identifiability` gives the
smallest possible standard deviation of each parameter, and says which further manoeuvre would help most.
"""

import helmbench

record = helmbench.simulate("response-1", "zigzag:5/5", noise="medium", seed=1)
estimate = helmbench.identify(record, "nomoto-1-cubic", "output-error")
found = estimate.identifiability(record)
print("\n".join(found.lines()))

# %%
# One bar a parameter:

found.plot()
