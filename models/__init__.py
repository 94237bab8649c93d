"""Vessel models: symbolic definitions, the kernels generated from them, vessels as data, simulation."""
