"""The matrix of wrong data: every change of the records of every ship and set, given to every command.

`make wrong-data`, or `python -m tests.helmbench.wrong_data.run [SET[:COMMAND] ...]`.  Prints the seed, every cell that
is not told, refused or harmless, or that names the hull or a sensor that the unchanged records do not have, and the
counts.
"""

import random
import sys
import zlib
from collections import Counter

import numpy as np

from .changes import CHANGES
from .commands import COMMANDS, UNKNOWABLE, ChangeOutcome, judged
from .fleet import CRAFT, FLEET, at_hand, records_of

OUTCOMES = ("told", "refused", "harmless", "unknowable", "silent")


def cell(command: str, name: str, change: str, seed: int) -> ChangeOutcome:
    """One cell of the matrix."""
    rng = np.random.default_rng([seed, zlib.crc32(change.encode())])
    return judged(command, name, change, [CHANGES[change](record, rng) for record in records_of(name)])


def row(command: str, name: str, seed: int) -> Counter[str]:
    """Counts of one set and command; prints what is wrong."""
    counts: Counter[str] = Counter()
    for change in CHANGES:
        found = cell(command, name, change, seed)
        unknowable = found.outcome == "silent" and (command, change) in UNKNOWABLE
        outcome = "unknowable" if unknowable else found.outcome
        counts.update([outcome, *(["hull"] * bool(found.hull)), *(["invented"] * bool(found.invented))])
        if outcome == "silent" or found.hull or found.invented:
            print(f"  {command} {name}, {change}: {outcome}, hull {found.hull}, invented {found.invented}: {found.why}")
    return counts


def main(chosen: list[str]) -> int:
    """Run the matrix, or the sets that are named; 1 where a cell is wrong."""
    seed, whole = random.SystemRandom().randrange(2**32), Counter()
    print(f"seed {seed}; {len(CHANGES)} changes", flush=True)
    pairs = [
        (command, name) for name in filter(at_hand, FLEET) for command in (COMMANDS if name not in CRAFT else ["check"])
    ]
    for command, name in pairs:
        if not chosen or name in chosen or f"{name}:{command}" in chosen:
            counts = row(command, name, seed)
            whole += counts
            print(f"{name:>12} {command:>10}  {_text(counts)}", flush=True)
    print(f"{'':>12} {'all':>10}  {_text(whole)}")
    return int(bool(whole["silent"] or whole["hull"] or whole["invented"]))


def _text(counts: Counter[str]) -> str:
    return "  ".join(f"{key} {counts[key]}" for key in (*OUTCOMES, "hull", "invented"))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
