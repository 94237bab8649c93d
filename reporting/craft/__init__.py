"""The page and the terminal form of a craft's diagnosis."""
