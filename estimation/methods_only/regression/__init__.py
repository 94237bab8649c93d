"""Regressions of single methods: robust, weighted, instrumental, exact hold, observed and smoothed states."""
