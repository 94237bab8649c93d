"""The page and the terminal form of a validation."""
