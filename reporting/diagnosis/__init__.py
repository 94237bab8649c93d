"""Pages of one diagnosis."""
