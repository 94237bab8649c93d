"""Identification methods: records and a model in, an estimate out.

A method is a class: its options, each declared once (`options`), and a short `estimate`.  Methods that differ by a
number or a function share a file.  A subclass of `base.Method` with a `name` in any file here is found by the registry
and tested by the shipped contract checks (`contract`) with no other edit.  What methods share is in
`helmbench.estimation`; mathematics that one method alone uses stands in its file, unless it is long.
"""
