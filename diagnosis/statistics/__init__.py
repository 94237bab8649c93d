"""Score tests, their levels, and what a record is worth under random forces."""
