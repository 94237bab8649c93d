"""The papers' methods against their baselines on every vessel."""

from .studies import STUDIES

__all__ = ["STUDIES"]
