"""What records tell of a model's numbers: Cramer-Rao bounds, identifiability, manoeuvres that would tell more."""
