"""Recursive least squares: compiled recursions, streams of records, convergence."""
