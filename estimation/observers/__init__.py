"""Observers, filters and smoothers of measured motions, without a model of the ship."""
