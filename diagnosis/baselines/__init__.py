"""Diagnosers: the project's own and those it is compared with."""
