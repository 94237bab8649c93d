"""The results store: exact columns, nothing lost, nothing half written."""

import json
import os

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helmbench.bench.journal import RUNS, DamagedRunsWarning, open_journal, read_runs, sealed, unsealed
from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.kinds.identification.columns import PARAMETER_COLUMNS, PARAMETERS, RESULTS, result_columns
from helmbench.bench.store import MANIFEST, Store, frames, locked, read_tables
from helmbench.models.errors import BadInput
from helmbench.models.folders import write_atomic

KEYS = ["suite", "method", "variant", "vessel", "model", "train", "held_out"]
KEYS += ["noise", "disturbance", "thinning", "length", "seed"]


def files(folder):
    return sorted(path.name for path in folder.iterdir())


def test_result_columns_are_those_of_the_specification():
    scores = [name for name in result_columns() if name.startswith(("rmse_", "r2_"))]
    rest = [name for name in result_columns() if name not in scores]
    assert rest == [
        *KEYS, "status", "error", "diverged", "measured", "n_samples", "rel_error_median", "rel_error_max",
        "crb_z_rms", "crps_median", "coverage_95", "crps_free", "coverage_free",
        "nrmse_by_record", "wall_s", "cpu_s", "peak_memory_mib",
    ]  # fmt: skip
    channels = {"heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m"}
    assert set(scores) == {
        f"{score}_{horizon}_{c}" for score in ("rmse", "r2") for horizon in ("free", "one") for c in channels
    }


def test_parameter_columns_are_those_of_the_specification():
    assert list(PARAMETER_COLUMNS) == [
        *KEYS, "parameter", "unit", "true", "true_kind", "estimate", "stderr", "rel_error", "crb_sd", "identifiable",
    ]  # fmt: skip


def test_tables_have_fixed_types_and_sorted_rows(tmp_path, manifest, run_of):
    with Store.create(tmp_path / "out", manifest(3)) as store:
        for vessel, seed in (("s175", 1), ("s175", 0), ("cargo", 0)):
            store.append(run_of(error=0.1, r2=0.9, vessel=vessel, seed=seed))
        store.write_tables()
    results = pd.read_parquet(tmp_path / "out" / RESULTS)
    parameters = pd.read_parquet(tmp_path / "out" / PARAMETERS)
    assert list(results.columns) == list(result_columns())
    assert list(parameters.columns) == list(PARAMETER_COLUMNS)
    assert results[["vessel", "seed"]].values.tolist() == [["cargo", 0], ["s175", 0], ["s175", 1]]
    assert results["rmse_free_surge_m_s"].dtype == "float64" and results["rmse_free_surge_m_s"].isna().all()
    assert results["seed"].dtype == "int64"


def test_every_run_is_on_disk_as_soon_as_it_is_appended(tmp_path, manifest, run_of):
    with Store.create(tmp_path / "out", manifest(2)) as store:
        store.append(run_of(error=0.1, seed=0))
        stored = (tmp_path / "out" / RUNS).read_text()
        assert stored.endswith("\n") and json.loads(stored)["row"]["seed"] == 0


def test_a_torn_last_line_is_cut_off_and_the_rest_kept(tmp_path, manifest, run_of):
    folder = tmp_path / "out"
    with Store.create(folder, manifest(3)) as store:
        first, second = run_of(error=0.1, seed=0), run_of(error=0.2, seed=1)
        store.append(first)
        store.append(second)
    whole = (folder / RUNS).read_bytes()
    for cut in (1, 7, len(whole.splitlines()[1]) - 1):
        (folder / RUNS).write_bytes(whole[:-cut])
        with Store.resume(folder) as store:
            assert store.finished == {first["key"]}
            store.append(second)
        assert (folder / RUNS).read_bytes() == whole


@given(values=st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=8), cut=st.integers(0, 5000))
def test_any_cut_of_the_log_keeps_exactly_the_whole_lines(tmp_path_factory, values, cut):
    from ..made_up.runs import DEFAULTS

    folder = tmp_path_factory.mktemp("log")
    runs = [{"key": f"k{i}", "row": DEFAULTS | {"wall_s": v}, "parameters": []} for i, v in enumerate(values)]
    path = folder / RUNS
    path.write_bytes(b"".join(map(sealed, runs)))
    data = path.read_bytes()[: cut % (path.stat().st_size + 1)]
    path.write_bytes(data)
    kept = read_runs(path)
    assert [run["key"] for run in kept] == [f"k{i}" for i in range(data.count(b"\n"))]
    file, again = open_journal(path, kind_of(IDENTIFICATION).tables)
    os.close(file)
    assert again == kept and path.read_bytes() == data[: data.rfind(b"\n") + 1]


@given(value=st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_come_back_bit_for_bit(value):
    assert json.loads(unsealed(sealed({"x": value}).rstrip()))["x"] == value


def test_numbers_that_are_not_finite_are_null():
    line = sealed({"x": [float("nan"), float("inf"), 1.0]}).rstrip()
    assert json.loads(unsealed(line)) == {"x": [None, None, 1.0]}


@pytest.mark.parametrize(
    "damage",
    [
        b"not a run", b"\xff\xfe", b"{}", b"[" * 5000, b'{"key": "a", "row": 3, "parameters": []}',
        b'{"key": "a", "row": {}, "parameters": []}', b'{"key": "a", "row": {"wall_s": "long"}, "parameters": [1]}',
    ],
)  # fmt: skip
def test_a_damaged_line_is_named_and_the_others_are_used(tmp_path, manifest, run_of, damage):
    folder = tmp_path / "out"
    first, second = run_of(error=0.1, seed=0), run_of(error=0.2, seed=1)
    with Store.create(folder, manifest(2)) as store:
        store.append(first)
        store.append(second)
    lines = (folder / RUNS).read_bytes().splitlines()
    (folder / RUNS).write_bytes(b"\n".join([lines[0], damage, lines[1], b""]))
    with pytest.warns(DamagedRunsWarning, match=r"runs\.jsonl: row 2: not a stored run"):
        store = Store.resume(folder)
    with store:
        assert store.finished == {first["key"], second["key"]}
    with pytest.warns(DamagedRunsWarning):
        assert len(read_tables(folder)[0]) == 2


def test_a_run_that_is_stored_twice_counts_once(tmp_path, manifest, run_of):
    folder = tmp_path / "out"
    with Store.create(folder, manifest(2)) as store:
        store.append(run_of(error=0.1))
        store.append(run_of(error=0.1))
    assert len(read_tables(folder)[0]) == 1


def test_a_directory_is_held_by_one_process(tmp_path, manifest):
    with locked(tmp_path), pytest.raises(BadInput, match="another run is writing here"):
        Store.create(tmp_path, manifest(1))
    assert files(tmp_path) == []


def test_a_directory_that_holds_something_is_refused_and_left_alone(tmp_path, manifest):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(BadInput, match="not empty"):
        Store.create(tmp_path, manifest(1))
    assert files(tmp_path) == ["thesis.tex"]


def test_a_file_in_the_place_of_the_directory_is_refused(tmp_path, manifest):
    (tmp_path / "out").write_text("")
    with pytest.raises(BadInput, match="not a directory"):
        Store.create(tmp_path / "out", manifest(1))


def test_two_processes_cannot_write_the_same_store(tmp_path, manifest):
    with Store.create(tmp_path / "out", manifest(1)), pytest.raises(BadInput, match="another run"):
        Store.resume(tmp_path / "out")
    Store.resume(tmp_path / "out").close()


def test_what_is_no_run_directory_is_refused(tmp_path):
    with pytest.raises(BadInput, match="holds no benchmark run"):
        Store.resume(tmp_path)
    (tmp_path / MANIFEST).write_text("{")
    with pytest.raises(BadInput, match=MANIFEST):
        Store.resume(tmp_path)
    (tmp_path / MANIFEST).write_text('{"suite": "quick"}')
    with pytest.raises(BadInput, match="not the manifest"):
        Store.resume(tmp_path)


def test_tables_are_read_from_the_log_until_they_exist(tmp_path, manifest, run_of):
    folder = tmp_path / "out"
    with Store.create(folder, manifest(2)) as store:
        store.append(run_of(error=0.1, r2=0.5))
        early = read_tables(folder)
        store.write_tables()
    late = read_tables(folder)
    for before, after in zip(early, late, strict=True):
        pd.testing.assert_frame_equal(before, after)


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "leaderboard.md"
    write_atomic(path, b"old")

    def no_space(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", no_space)
    with pytest.raises(BadInput, match=r"leaderboard\.md: cannot be used .No space"):
        write_atomic(path, b"new")
    assert files(tmp_path) == ["leaderboard.md"] and path.read_bytes() == b"old"


def test_frames_keep_failed_runs_without_parameters(run_of):
    results, parameters = frames([run_of(status="failed", reason="no luck")], kind_of(IDENTIFICATION).tables)
    assert results["status"].tolist() == ["failed"] and results["error"].tolist() == ["no luck"]
    assert parameters.empty
