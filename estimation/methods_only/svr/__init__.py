"""Least-squares support vector regression: the mathematics, and scikit-learn regressors on it."""
