"""Checks of what whole columns mean: one class in one file each."""
