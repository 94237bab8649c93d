"""Scores of an estimate: one file each, found by the registry; the columns of the results table follow from them."""

from .base import Outcome, ScoreFunction, score
from .registry import compute, score_columns, scores

__all__ = ["Outcome", "ScoreFunction", "compute", "score", "score_columns", "scores"]
