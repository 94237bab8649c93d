"""Causes beside a base model whose own numbers are wrong: a discrepancy with priors whose scales are estimated."""
