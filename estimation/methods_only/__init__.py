"""What identification methods fit with and no diagnosis does."""
