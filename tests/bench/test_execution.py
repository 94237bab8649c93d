"""What one run costs, and how its failure is told."""

import re

import numpy as np

from helmbench.bench.environment import code_version, cpu_count, environment
from helmbench.bench.execution import one_line, reset_peak_memory


def test_peak_memory_sees_what_a_fit_allocates():
    before = reset_peak_memory()()
    peak = reset_peak_memory()
    np.ones(30_000_000).sum()  # 229 MiB
    assert before is not None and peak() - before > 200
    assert reset_peak_memory()() < before + 100


def test_a_message_is_one_line_of_a_sensible_length():
    assert one_line("no\n  luck") == "no luck"
    assert len(one_line("x" * 500)) == 400 and one_line("x" * 500).endswith("...")


# ---- What a run was made with.


def test_the_version_names_the_sources():
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*\+[0-9a-f]{12}", code_version())
    assert code_version() == code_version()


def test_the_environment_names_versions_and_processor():
    found = environment()
    assert found["cpus"] == cpu_count() >= 1
    assert found["packages"]["numpy"] and found["packages"]["helmbench"]
