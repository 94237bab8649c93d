"""Which values of a parameter `make test` leaves to `make test-all`."""

from collections.abc import Iterable
from typing import Any

import pytest


def nightly_but(values: Iterable[Any], *kept: Any) -> list[Any]:
    """The values of a test's parameter: the kept ones are tested by both commands, the others by `make test-all`."""
    return [value if value in kept else pytest.param(value, marks=pytest.mark.nightly) for value in values]
