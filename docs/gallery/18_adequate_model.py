"""
A model with nothing wrong
==========================

A diagnosis must also be able to say that it has found nothing. The record comes from the model itself, with sensor
noise, and no cause is named.
"""

import helmbench

train = helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=1)
other = helmbench.simulate("response-1", "zigzag:10/10", noise="low", seed=2)
found = helmbench.diagnose("response-1", train, other)
print(found.verdict, [cause.cause for cause in found.causes])
found.plot()
