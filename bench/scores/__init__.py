"""Scores of an estimate: found in the files of this folder; the columns of the results table follow from them."""

from .base import Outcome, ScoreFunction, compute, score, score_columns, scores

__all__ = ["Outcome", "ScoreFunction", "compute", "score", "score_columns", "scores"]
