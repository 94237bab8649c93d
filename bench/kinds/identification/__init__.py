"""Suites that identify models: problems, runs, scores."""
