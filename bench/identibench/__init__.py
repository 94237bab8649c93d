"""Adapters both ways between helmbench and identibench 0.4 (D. O. M. Weber, github.com/daniel-om-weber/identibench)."""
