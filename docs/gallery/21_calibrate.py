"""
Which numbers of a simulation are wrong
=======================================

The simulation has a rudder moment that is a quarter too small, so that it is to grow by a third. `calibrate` moves
coefficients within what is known of them beforehand, as long as that predicts pieces of records better which were left
out.
"""

import helmbench

ship = helmbench.resolve("mariner")
wrong = ship.with_coefficients(ship.from_parameters({**ship.parameters, "Nd": 0.75 * ship.parameters["Nd"]}))
train = helmbench.simulate(ship, "zigzag:20/20", noise="low", seed=1, dt_s=1.0)
other = helmbench.simulate(ship, "zigzag:10/10", noise="low", seed=2, dt_s=1.0)
found = helmbench.calibrate(wrong, train, other)
print(found)
for number in found.moved:
    low, high = sorted((number.low / number.before, number.high / number.before))
    print(f"{number.name}: {number.after / number.before:.3f} times what it was, {low:.3f} to {high:.3f}")

# %%
# Before and after, over the record that was held out:

found.plot()
