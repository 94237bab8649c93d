"""
A leaderboard of three methods
==============================

A suite fits methods to many simulated records and judges all of them on manoeuvres that they have not seen. Here it
is the quick suite on one ship with three methods.
"""

import tempfile

import helmbench

with tempfile.TemporaryDirectory() as folder:
    found = helmbench.run_suite(
        "quick", directory=folder, vessels=["response-1"], methods=["ls", "rls", "output-error"], jobs=1
    )
    standings = helmbench.leaderboard(folder)
print(found.counts)

# %%
# The standings:

standings.plot()
