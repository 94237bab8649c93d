"""When two causes cannot be distinguished."""

TIE_NATS, MOST_TIED = 4.6, 2
"""Log p-values within which significant rivals are tied, and how many are named beside the best."""
TIE_CORRELATION = 0.5
"""Canonical correlation of their projected sensitivities below which two causes are no tie."""
