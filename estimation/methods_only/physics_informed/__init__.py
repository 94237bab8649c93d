"""Networks of time that are held to a model's equations."""
