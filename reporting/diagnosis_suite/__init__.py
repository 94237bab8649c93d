"""The report of a suite that diagnoses records with injected effects."""
