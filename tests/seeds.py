"""The one rule of seeds: a test's seed is the CRC32 of its name, shifted by HELMBENCH_SEED where that is set."""

import os
import zlib

SHIFT = int(os.environ.get("HELMBENCH_SEED") or 0)
"""Zero in `make test`; `make test-all` draws it and prints it."""


def seed_of(name: str) -> int:
    """The seed (0 to 2**32 - 1) of a test or of a shared record of this name."""
    return (zlib.crc32(name.encode()) + SHIFT) % 2**32
