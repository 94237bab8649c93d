"""Identification methods: records and a model in, an estimate out.

One file per method: a class, its options and a short `estimate`.  A file that defines a subclass of `base.Method` with
a `name` is found by the registry and tested by the shipped contract checks (`contract`) with no other edit.  What
methods share is in `helmbench.estimation`; mathematics that one method alone uses may stand in its file.
"""
