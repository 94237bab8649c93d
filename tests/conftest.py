"""Fixtures for all rooms."""

import numpy as np
import pytest


@pytest.fixture
def rng(request):
    """A generator whose seed is drawn anew and printed, so that a failure can be repeated."""
    seed = int(np.random.SeedSequence().generate_state(1)[0])
    print(f"{request.node.name}: seed {seed}")
    return np.random.default_rng(seed)
