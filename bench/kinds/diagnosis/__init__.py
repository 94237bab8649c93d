"""The benchmark of diagnosis itself: effects are planted by the truth simulator, diagnosed, and the findings scored.

`plan` deals out the cases, `runner` executes one, `judge` scores it, `rates` sums up, `page` reports.
"""
