"""Comparison of heading with yaw rate, and of positions with velocities, by forward selection."""
