"""A craft without a published simulation: a model built from its records, rung by rung (docs/mathematics/craft.md)."""
