"""Tails of distributions, and means of sizes that differ between records."""
