"""How much worse than the base model an extended model may predict what it was not fitted to."""

WORSE = 1.05
"""Ratio of the free-run errors (rms) of left-out records to the base model's, in any channel, from which a cause or a
group of numbers is given up."""
