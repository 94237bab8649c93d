"""Validation of models on records: free runs, errors at several horizons, manoeuvring indices.  No diagnosis."""
