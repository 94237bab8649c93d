"""Maximum likelihood of free runs and of one-step predictions: problems, unknowns, minimiser, searches, profiles."""
