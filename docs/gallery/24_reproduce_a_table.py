"""
A table of a paper, computed again
==================================

Five papers are reproduced claim by claim. Table 1 of the first one holds the derivatives of a vehicle, and the paper
says that the coefficients of its equation (23) follow from them. Every claim has a verdict with its reason.
"""

import matplotlib.pyplot as plt

import helmbench

found = helmbench.reproduce("000", 1, jobs=1)
for row in found.rows:
    print(f"{row['quantity']}: {row['verdict']}", f"    {row['reason']}", sep="\n")

# %%
# The printed coefficients beside those that follow from the table:

claims = [row for row in found.rows if row["kind"] == "result"]
places = range(len(claims))
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.bar([place - 0.2 for place in places], [row["published"] for row in claims], 0.4, label="printed")
axes.bar([place + 0.2 for place in places], [row["corrected"]["median"] for row in claims], 0.4, label="from table 1")
axes.set_xticks(places, [f"{row['quantity'].split()[0]} [{row['unit']}]" for row in claims])
axes.axhline(0.0, color="black", linewidth=0.5)
axes.legend()
