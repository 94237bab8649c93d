"""Kalman filters of state and parameters together."""
