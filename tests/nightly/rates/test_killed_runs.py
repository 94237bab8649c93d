"""Many kills: `make rates`."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]


def test_runs_killed_a_thousand_times_end_as_unbroken_ones(tmp_path, seed):
    command = [sys.executable, "-m", "tests.bench.killed_runs", str(tmp_path), str(seed), "1000"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    print(done.stdout)
