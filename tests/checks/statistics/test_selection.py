"""The loop of all forward selections."""

from dataclasses import dataclass

import pytest

from helmbench.checks.statistics.selection import grown


@dataclass
class Largest:
    """Numbers enter, the largest first, as long as one is above a level; the state is a tuple of those that did."""

    numbers: tuple[float, ...]
    level: float

    def tried(self, now, step):
        assert step == len(now)
        return now, [x for x in self.numbers if x not in now]

    def entered(self, now, tried, step):
        best = max(tried, default=self.level)
        return (*now, best) if best > self.level else None


@pytest.mark.parametrize(("most", "found"), [(0, ()), (1, (9.0,)), (2, (9.0, 5.0)), (7, (9.0, 5.0))])
def test_what_enters_ends_with_the_criterion_or_the_number_of_steps(most, found):
    assert grown(Largest((2.0, 9.0, 5.0, 1.0), 4.0), (), most) == found
