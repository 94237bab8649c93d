"""Paper 001: Euler-difference least squares (A1, A2) for the 60 coefficients of a Mariner model."""
