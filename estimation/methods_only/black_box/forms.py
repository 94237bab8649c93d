"""Forms of packed learnt functions, and the distance from the training rows beyond which they are not asked."""

NETWORKS, TERMS, KERNELS, TREES = range(4)
OUTSIDE = 1e3
"""Standard deviations from the training rows beyond which nothing is predicted: the run has diverged."""
