"""What a run was made with."""

import re

from helmbench.bench.environment import code_version, cpu_count, environment


def test_the_version_names_the_sources():
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*\+[0-9a-f]{12}", code_version())
    assert code_version() == code_version()


def test_the_environment_names_versions_and_processor():
    found = environment()
    assert found["cpus"] == cpu_count() >= 1
    assert found["packages"]["numpy"] and found["packages"]["helmbench"]
