"""The papers, a package each: `STUDIES` that compute the values of its claims, and functions that draw its figures."""
