"""Fixtures for all rooms."""

import numpy as np
import pytest


@pytest.fixture
def seed(request) -> int:
    """A seed, drawn anew and printed, so that a failure can be repeated."""
    value = int(np.random.SeedSequence().generate_state(1)[0])
    print(f"{request.node.name}: seed {value}")
    return value


@pytest.fixture
def rng(seed) -> np.random.Generator:
    """A generator made of the drawn seed."""
    return np.random.default_rng(seed)
