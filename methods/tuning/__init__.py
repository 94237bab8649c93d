"""Tuning of a method's options: search spaces as data, samplers, studies that several machines may share.

`space` says what a method may declare, `abc` is the artificial bee colony as an Optuna sampler, `tune` runs a study and
`tuned` wraps a method so that its options are tuned within its fit.
"""
