"""`helmbench reproduce`: what five papers publish, computed again, and a verdict on every number.

`claims/NNN.yaml` holds a paper's claims, errata and figures; `paper_NNN` the studies that compute them; `claims` reads
the one, `study` defines the other.  `runner` runs studies and keeps each result, `summary` makes intervals of them,
`verdict` compares, `pages` and `figures` write.
"""
