"""
A published and an identified model on one record
=================================================

Three models run freely along the same record. One is the full simulation of the Mariner that made it, the others are
response models that were identified from another record.
"""

import helmbench

train = helmbench.simulate("mariner", "zigzag:20/20", noise="low", seed=1, dt_s=1.0)
other = helmbench.simulate("mariner", "zigzag:10/10", noise="low", seed=2, dt_s=1.0)
simple, cubic = (helmbench.identify(train, family, "output-error").model for family in ("nomoto-1", "nomoto-1-cubic"))
found = helmbench.validate("mariner", other, [simple, cubic])
scores = found.to_dataframe()
yaw = scores[(scores.channel == "yaw_rate_rad_s") & (scores.record == other.name)]
print(yaw[["model", "horizon", "rmse", "r2"]].to_string(index=False))
found.plot()
