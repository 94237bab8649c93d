"""Fixtures of the leaderboard's tests."""

import pytest

from helmbench.bench.store import Store


@pytest.fixture
def folder_of(tmp_path, manifest):
    """Writes runs into a directory of results: folder_of(name, runs)."""

    def build(name, runs):
        with Store.create(tmp_path / name, manifest(len(runs)) | {"suite": name}) as store:
            for run in runs:
                store.append(run)
            store.write_tables()
        return tmp_path / name

    return build
