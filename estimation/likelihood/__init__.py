"""Maximum likelihood of free runs: problems, unknowns, minimiser, searches."""
