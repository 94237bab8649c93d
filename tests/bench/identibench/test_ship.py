"""identibench's ship set as records and a suite."""

import h5py
import numpy as np
import pytest

import helmbench
from helmbench.bench.identibench.ship import default_root
from helmbench.bench.suites import load_suite
from helmbench.models.errors import BadInput

from .ship_files import FIXED, MANOEUVRES, columns_of, write_columns, write_ship


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    return write_ship(tmp_path_factory.mktemp("data"))


def test_the_records_are_in_si_units(root, tmp_path):
    helmbench.identibench_suite(tmp_path / "out", root)
    found = helmbench.read_record(tmp_path / "out" / "test" / "test_1.csv")
    sailed = helmbench.simulate("mariner", MANOEUVRES["test"][1], dt_s=1.0, duration_s=420.0).turned("port")
    assert found.meta.positive_rudder == "port" and "2905" in found.meta.source
    assert np.array_equal(found.time_s, np.arange(421.0))
    for channel in ("rudder_rad", "surge_m_s", "sway_m_s", "yaw_rate_rad_s"):
        expected = sailed.rudder() if channel == "rudder_rad" else sailed.column(channel)
        assert np.allclose(found.column(channel), expected, atol=1e-6), channel
    for channel, value in (("propeller_rps", 1.0), ("wind_speed_m_s", FIXED["Vw"]), ("roll_rad", FIXED["phi"])):
        assert np.allclose(found.column(channel), value), channel
    assert not found.has("wind_direction_rad")


def test_the_suite_runs_both_held_out_sets(root, tmp_path, in_this_process, monkeypatch):
    monkeypatch.setenv("IDENTIBENCH_DATA_ROOT", str(root))
    path = helmbench.identibench_suite(tmp_path / "out")
    (entry,) = load_suite(str(path)).entries
    assert [len(part) for part in (*entry.records.train, *entry.records.held_out)] == [2, 2, 1]
    found = helmbench.run_suite(str(path), directory=tmp_path / "results", methods=["ls", "straight-line"])
    rows = {(row["method"], row["held_out"]): row for row in found.rows if row["model"] == "nomoto-1-cubic"}
    sets = ("test_0+test_1", "test_ood_0")
    assert set(rows) == {(method, one) for method in ("ls", "straight-line") for one in sets}
    assert {(row["status"], row["vessel"]) for row in rows.values()} == {("ok", "identibench-ship")}
    ls, straight = (rows[method, sets[0]]["rmse_free_yaw_rate_rad_s"] for method in ("ls", "straight-line"))
    assert 0.0 < ls < 0.5 * straight


def test_an_empty_variable_counts_as_unset(monkeypatch, tmp_path):
    monkeypatch.setenv("IDENTIBENCH_DATA_ROOT", "")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert default_root() == tmp_path / ".identibench_data"


def test_what_is_wrong_is_told_and_nothing_is_written(root, tmp_path):
    with pytest.raises(BadInput, match="has no file of identibench's ship set"):
        helmbench.identibench_suite(tmp_path / "out", tmp_path)
    columns = columns_of(helmbench.simulate("mariner", "turn:10", dt_s=1.0, duration_s=60.0))
    for part in ("train", "test"):
        write_columns(tmp_path / "ship" / part / "a.hdf5", columns)
    wrong = tmp_path / "ship" / "test_ood" / "b.hdf5"
    write_columns(wrong, {name: values for name, values in columns.items() if name != "deltar"})
    with pytest.raises(BadInput, match="deltar"):
        helmbench.identibench_suite(tmp_path / "out", tmp_path)
    write_columns(wrong, columns | {"Vw": columns["Vw"][:-1]})
    with pytest.raises(BadInput, match="unequal lengths"):
        helmbench.identibench_suite(tmp_path / "out", tmp_path)
    with h5py.File(wrong, "a") as file:
        del file["Vw"]
        file["Vw"] = "windy"
    with pytest.raises(BadInput, match="Vw"):
        helmbench.identibench_suite(tmp_path / "out", tmp_path)
    wrong.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(200))
    with pytest.raises(BadInput, match="not an HDF5 file"):
        helmbench.identibench_suite(tmp_path / "out", tmp_path)
    assert not (tmp_path / "out").exists()
