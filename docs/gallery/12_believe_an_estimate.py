"""
Whether to believe an estimate
==============================

A linear first-order law (Nomoto) is fitted to a ship with cubic damping. It follows its own record fairly well;
`assess` says, by free runs and residuals along a record that was held out, whether that is good enough.
"""

import helmbench

train = helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=1)
other = helmbench.simulate("response-1", "zigzag:10/10", noise="low", seed=2)

simple = helmbench.identify(train, "nomoto-1", "output-error").assess(other)
print(simple.verdict, *simple.statement(), sep="\n")
simple.plot()

# %%
# With the cubic term:

cubic = helmbench.identify(train, "nomoto-1-cubic", "output-error").assess(other)
print(cubic.verdict, *cubic.statement(), sep="\n")
cubic.plot()
