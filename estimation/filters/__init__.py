"""Kalman filters of any model: innovations, joint state and parameter estimation."""
