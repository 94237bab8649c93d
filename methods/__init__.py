"""Identification methods: records and a model in, an estimate out.

One file per method.  A file that defines a subclass of `base.Method` with a `name` is found by the registry and
run through the shipped contract checks (`contract`) with no other edit.  The mathematics of each method is a pure
function of arrays; `fit` checks the records, calls it and wraps what comes back.
"""
