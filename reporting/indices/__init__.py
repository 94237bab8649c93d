"""A model from manoeuvring indices, in text and tables."""
