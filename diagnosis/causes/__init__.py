"""Causes of what a simulation gets wrong: rows of data in one file a concept, found by `registry`."""
