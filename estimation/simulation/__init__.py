"""Free runs of a model along records, their sensitivities, and the choice among estimates by them."""
