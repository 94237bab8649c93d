"""Causes of what a simulation gets wrong: one class in one file each, found by `registry`."""
