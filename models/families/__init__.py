"""Model families: their equations as data, what acts on them from outside, and their extensions."""
