"""`helmbench.reproduce` without a folder."""

import pytest

import helmbench


@pytest.mark.usefixtures("here_or_in_a_worker")
def test_a_table_is_computed_where_no_folder_is_given(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    table = helmbench.reproduce("000", 1, jobs=1)
    assert len(table.rows) == 5 and not table.failures
    assert not [*tmp_path.iterdir()]
