"""`helmbench.reproduce` without a folder."""

import helmbench


def test_a_table_is_computed_where_no_folder_is_given(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    table = helmbench.reproduce("000", 1, jobs=1)
    assert len(table.rows) == 5 and not table.failures
    assert not [*tmp_path.iterdir()]
