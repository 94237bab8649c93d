"""Verdicts: intervals of our values over noise seeds, and their comparison with a claim."""
