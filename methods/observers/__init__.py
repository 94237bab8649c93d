"""Observers, filters and smoothers: parts that methods combine, none of them a method by itself."""
