"""Kalman filters of any model that methods and diagnosis share."""
