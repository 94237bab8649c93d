"""Innovations of any model under sensor noise and coloured forces: likelihood, noise fit, parameter refits."""
