"""Estimates: a fit with its model and records, and the statistics of its residuals."""
