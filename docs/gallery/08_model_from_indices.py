"""
A model from the wheelhouse poster
==================================

Of many ships nobody has a record, but the turning circle and the overshoots are known. `model_from_indices` fits a
model to them, with an interval of each parameter that they determine.
"""

import helmbench

found = helmbench.model_from_indices(
    {
        "name": "tanker",
        "length_m": 320.0,
        "speed_kn": 15.5,
        "indices": [
            {"manoeuvre": "turn:35", "advance_m": 1000.0, "tactical_diameter_m": 1020.0, "speed_ratio": 0.4},
            {"manoeuvre": "zigzag:10/10", "first_overshoot_deg": 8.1, "second_overshoot_deg": 17.0},
        ],
    }
)
print(found.to_dataframe())

# %%
# The model is taken wherever a model is. Here it sails a manoeuvre that the poster does not have.

helmbench.simulate(found.model, "zigzag:20/20", duration_s=900.0, dt_s=1.0).plot()
