"""Fuzzing of every reader for a stated time: `make fuzz`, FUZZ_SECONDS= of each reader, FUZZ_READERS= some of them.

Prints the seed and a table; an input that failed is kept in `corpus/READER`, which `make test` reads again.
"""

import hashlib
import os
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from .mutate import mutated
from .readers import Reader, readers
from .worker import ReaderOutcome, ReaderProcess

CORPUS = Path(__file__).parent / "corpus"
STATES = ("accepted", "refused", "crash", "hang", "memory", "code")
MOST_KEPT = 20
"""Inputs kept of one reader and run, each with a complaint of its own."""


def fuzz(name: str, reader: Reader, seconds: float, seed: int, folder: Path) -> Counter[str]:
    """Numbers of inputs by outcome, and the longest time in `slowest_ms`; prints and keeps what failed."""
    rng = random.Random(f"{seed} {name}")
    worker, counts, kept, slowest = ReaderProcess(reader, folder), Counter[str](), set[str](), 0.0
    pool = [*reader.seeds, *(path.read_bytes() for path in sorted((CORPUS / name).glob("*")))]
    started = time.perf_counter()
    while time.perf_counter() - started < seconds:
        data = mutated(rng.choice(pool), rng.choice(pool), rng)
        found = worker.outcome(data)
        counts[found.state] += 1
        slowest = max(slowest, found.wall_s)
        if found.failed:
            _keep(name, data, found, kept)
        elif found.state == "accepted" and len(pool) < 200 and rng.random() < 0.2:
            pool.append(data)
    worker.close()
    counts["slowest_ms"] = round(1000 * slowest)
    return counts


def _keep(name: str, data: bytes, found: ReaderOutcome, kept: set[str]) -> None:
    complaint = f"{found.state} {found.said.partition(' at ')[2] or found.said[:60]}"
    if complaint in kept or len(kept) >= MOST_KEPT:
        return
    kept.add(complaint)
    place = CORPUS / name / hashlib.sha256(data).hexdigest()[:16]
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(data)
    print(f"{name}: {found.state}: {found.said}\n  kept as {place}", flush=True)


def main() -> int:
    """Fuzz; 1 where anything failed."""
    seconds = float(os.environ.get("FUZZ_SECONDS", "600"))
    seed = int(os.environ.get("FUZZ_SEED", random.SystemRandom().randrange(2**32)))
    print(f"seed {seed} (FUZZ_SEED={seed} repeats it), {seconds:g} s a reader", flush=True)
    failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        known = readers(Path(scratch))
        chosen = os.environ.get("FUZZ_READERS", "").split() or list(known)
        print("  ".join(f"{title:>9}" for title in ("reader", "inputs", *STATES, "slowest")), flush=True)
        for name in chosen:
            counts = fuzz(name, known[name], seconds, seed, Path(scratch) / name)
            slowest = counts.pop("slowest_ms")
            cells = [name, counts.total(), *(counts[state] for state in STATES), f"{slowest / 1000:.2f} s"]
            print("  ".join(f"{cell!s:>9}" for cell in cells), flush=True)
            failed += sum(counts[state] for state in STATES[2:])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
