"""Benchmarks: plan, run, store and score.

`suites` reads what is to be run, from data files.  A kind of suite (`kinds`) plans the runs, executes one and says
which tables it fills; `runner` executes them in the worker processes of `pool` and keeps finished runs in a `store`.
`scores` holds the scores of an estimate.  `faults` is a truth simulator that injects effects in records.
"""
