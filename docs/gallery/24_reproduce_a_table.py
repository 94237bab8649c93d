"""
A table of a paper, computed again
==================================

Five papers are reproduced claim by claim. Here table 1 of the first one is computed, and every claim has a verdict with its
reason.
"""

import matplotlib.pyplot as plt

import helmbench

found = helmbench.reproduce("000", 1, jobs=1)
for row in found.rows:
    print(f"{row['quantity']}: {row['verdict']}")

# %%
# Published values over computed ones: on the line they agree.

published = [row["published"] for row in found.rows]
computed = [row["corrected"]["median"] for row in found.rows]
figure, axes = plt.subplots(figsize=(5, 5), layout="constrained")
axes.plot(computed, published, "o")
axes.axline((0.0, 0.0), slope=1.0, color="black", linewidth=0.5)
axes.set(xlabel="computed", ylabel="published", title="paper 000, table 1")
axes.grid(True, linewidth=0.3)
