"""`helmbench reproduce`: what five papers publish, computed again, with a verdict on every number.

`claims/` has the claims, errata and figures of each paper as data; `papers/` the studies that compute their values;
`verdicts/` compares the two; `pages/` writes Markdown, HTML and figures.  `runner` executes studies and stores each
run, `results` summarises the runs, `session` is one call of the command.
"""
