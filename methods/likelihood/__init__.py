"""Maximum likelihood of free runs: the problem, its unknowns, the minimiser, the search among starts, profiles."""
