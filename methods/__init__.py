"""Identification methods: records and a model in, an estimate out.

A method is a function of records and model, or of what its base makes of them, and of its options, each declared once
(`options`); `base.method` makes a class of it.  One that needs more is a subclass of `base.Method`.  Methods that
differ by a number or a function share a file.  Every one with a `name` in any file here is found by the registry and
tested by the shipped contract checks (`contract`) with no other edit.  What methods share is in
`helmbench.estimation`; mathematics that one method alone uses stands in its file, unless it is long.
"""
