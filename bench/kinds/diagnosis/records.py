"""How the records of a case are made: a dimension of diagnosis suites."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

RECORDS: Mapping[str, Mapping[str, Any]] = {
    "plain": {},
    "coloured": {"noise_time_s": 5.0},
    "spread": {"spread": 0.3},
    "closed-loop": {"train": ("zigzag:10/10", "zigzag:20/20:port", "zigzag:20/10")},
    "orders": {"command": True},
    "five-three": {
        "train": ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port", "turn:35", "zigzag:20/10"),
        "held_out": ("zigzag:10/10", "turn:20:port", "zigzag:25/15:port"),
    },
    "five-steps": {
        "train": ("zigzag:20/20", "turn:25:port", "zigzag:10/10:port", "steps:30deg/{:g}s", "steps:20deg/{:g}s"),
        "held_out": ("zigzag:10/10", "turn:20:port", "steps:25deg/{:g}s"),
    },
}
"""Name -> what differs from a plain case: sensors' noise with a memory (s, of a 160 m ship), sizes that differ between
records (relative standard deviation), runs in which heading orders the rudder, its order in the place of its angle,
five training and three held-out ones (zigzags and turns, or with random rudder angles, which tell a threshold)."""
