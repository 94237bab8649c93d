"""Model families: each module offers `DEFINITIONS`, identifier -> function that builds the definition."""
