"""A model along a record: one rule for start state, inputs, the stretch that is scored, and the errors."""
