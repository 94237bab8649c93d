"""Ships and records of the user's own in suites, from outside the checkout."""

import json

import numpy as np
import pytest
import yaml

from helmbench import run_suite, simulate, write_record
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.kinds.identification.problems import problem
from helmbench.bench.suites import load_suite
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.vessel import vessel_files

from ....made_up.suites import suite_file

PARTICULARS = """
title: small ferry
L: 60.0
B: 12.0
d: 3.0
nabla: 1300.0
speed_m_s: 7.0
n0_rps: 5.0
A_R: 5.0
H_R: 2.5
D_P: 2.0
"""


@pytest.fixture
def ferry(tmp_path):
    """A vessel file outside the checkout: the cargo ship's with another id and gain."""
    facts = yaml.safe_load(vessel_files()["cargo"].read_text()) | {"id": "ferry"}
    facts["parameters"]["K"]["value"] *= 2.0
    path = tmp_path / "ferry.yaml"
    path.write_text(yaml.safe_dump(facts))
    return path


def test_a_vessel_file_is_a_vessel(ferry):
    own, cargo = resolve(ferry), resolve("cargo")
    assert own.id == "ferry" and own.family == cargo.family
    assert own.parameters["K"] == pytest.approx(2.0 * cargo.parameters["K"])


def test_an_own_vessel_joins_the_entries_of_its_kind(ferry):
    suite = load_suite("default")
    specs = plan(suite, RunSelection("default", ("ls-forward", "pem"), (str(ferry),)))
    rows = [spec.row_key() for spec in specs]
    assert {row["vessel"] for row in rows} == {"ferry"} and {row["noise"] for row in rows} == {"none", "low", "high"}
    assert {row["model"] for row in rows} == {resolve("cargo").family}


def test_particulars_join_the_3dof_entries_but_for_the_wind(tmp_path):
    path = tmp_path / "ship.yaml"
    path.write_text(PARTICULARS)
    specs = plan(load_suite("default"), RunSelection("default", ("pem",), (str(path),)))
    rows = [spec.row_key() for spec in specs]
    assert {"mmg", "nomoto-1"} <= {row["model"] for row in rows}
    assert {row["vessel"] for row in rows} == {"ship"}
    with pytest.raises(BadInput, match="nothing to run"):
        plan(load_suite("disturbances"), RunSelection("disturbances", ("pem",), (str(path),)))


def test_an_own_file_is_part_of_what_a_run_depends_on(ferry):
    selection = RunSelection("quick", ("ls",), (str(ferry),))
    before = [spec.key for spec in plan(load_suite("quick"), selection)]
    from helmbench.bench.kinds.identification import own

    ferry.write_text(ferry.read_text().replace("Cargo", "cargo") + "\n# another\n")
    own._digest.cache_clear()
    after = [spec.key for spec in plan(load_suite("quick"), selection)]
    assert len(before) == len(after) > 1 and not set(before) & set(after)


def test_a_shipped_id_is_refused(tmp_path):
    path = tmp_path / "cargo.yaml"
    path.write_text(vessel_files()["cargo"].read_text())
    with pytest.raises(BadInput, match="ships with helmbench"):
        plan(load_suite("quick"), RunSelection("quick", (), (str(path),)))


@pytest.fixture
def records(tmp_path):
    """Two measured records of the patrol boat, as CSV files."""
    for name in ("zigzag:20/20", "zigzag:10/10:port"):
        record = simulate("patrol", name, noise="low", duration_s=200.0)
        write_record(record, tmp_path / f"{name[7:9]}.csv")
    return tmp_path


ENTRY = "  - {records: {train: [20.csv], held_out: [10.csv], ship: boat}, models: nomoto-2, methods: [ls, pem]}\n"


@pytest.mark.usefixtures("here_or_in_a_worker")
def test_records_of_the_users_own_are_a_suite(records, tmp_path, monkeypatch):
    suite_file(records, ENTRY)
    monkeypatch.chdir("/")
    found = run_suite(str(records / "mine.yaml"), directory=tmp_path / "out", jobs=1)
    rows = {row["method"]: row for row in found.rows}
    assert {(row["status"], row["vessel"], row["train"], row["held_out"], row["measured"]) for row in found.rows} == {
        ("ok", "boat", "20", "10", True)
    }
    assert rows["pem"]["r2_free_heading_rad"] > 0.99
    assert list(json.loads(rows["pem"]["nrmse_by_record"])) == ["10"]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("20.csv", "none.csv"), "none.csv: no such file"),
        (("held_out: [10.csv]", "held_out: [20.csv]"), "a training and a held-out record"),
        (("models: nomoto-2, ", ""), "records need models"),
        (("models: nomoto-2", "dt_s: 1.0, models: nomoto-2"), "duration_s and dt_s are for simulated records"),
    ],
)
def test_errors_are_told_before_the_first_fit(records, tmp_path, change, told):
    path = records / "mine.yaml"
    path.write_text("entries:\n" + ENTRY.replace(*change))
    with pytest.raises(BadInput, match=told):
        run_suite(str(path), directory=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("vessels: response-1, train: ['zigzag:20']", "zigzag:20"),
        ("vessels: response-1, noise: louder", "louder"),
        ("vessels: kvlcc2-l7, disturbance: 'wind:8@40deg'", "no windage"),
        ("vessels: response-1, held_out: ['turn:x']", "turn:x"),
    ],
)
def test_texts_that_cannot_be_sailed_are_told_before_the_first_fit(tmp_path, text, told):
    with pytest.raises(BadInput, match=told):
        plan(suite_file(tmp_path, "  - {methods: ls, " + text + "}\n"), RunSelection("mine"))


def test_the_timing_of_an_entry_reaches_held_out_records(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: response-1, methods: ls, duration_s: 60, dt_s: 0.5}\n")
    found = problem(plan(suite, RunSelection("mine"))[0].task)
    assert {record.n for record in (*found.train, *found.held_out)} == {121}
    assert all(np.isclose(record.dt, 0.5) for record in found.held_out)


def test_a_family_with_the_constants_of_another_ship_has_no_known_truth(tmp_path):
    suite = suite_file(tmp_path, "  - {vessels: mariner, models: [own, mariner-model], methods: ls, noise: low}\n")
    own, other = plan(suite, RunSelection("mine"))
    assert [spec.row_key()["model"] for spec in (own, other)] == ["abkowitz", "abkowitz of mariner-model"]
    assert problem(own.task).truth.kind == "given" and not problem(other.task).truth.values


def test_a_record_does_not_replace_a_vessel_file(ferry):
    record = simulate(str(ferry), "zigzag:20/20", duration_s=60.0)
    with pytest.raises(BadInput, match="no sidecar of a record"):
        write_record(record, ferry.with_suffix(".csv"))
    assert "ferry" in ferry.read_text() and not ferry.with_suffix(".csv").exists()


def test_a_wrong_constant_and_a_lacking_term_are_the_models_alone(tmp_path):
    """The ship sails with its own constants; the fitted model has the wrong ones, and no truth is claimed."""
    entry = "  - {vessels: kvlcc2-l7, methods: ls, train: ['zigzag:10/10'], held_out: ['turn:20'], duration_s: 30"
    wrong = ", constants: {f_alpha: 1.25}}\n" + entry + ", terms: {N_r_absv: {term_N_r_absv: -0.2}}}\n" + entry + "}\n"
    specs = plan(suite_file(tmp_path, entry + wrong), RunSelection("mine"))
    assert [spec.row_key()["model"] for spec in specs] == ["mmg with 1.25 f_alpha", "mmg without N_r_absv", "mmg"]
    constants, term, plain = (problem(spec.task) for spec in specs)
    ratio = constants.model.constants / plain.model.constants
    assert np.count_nonzero(ratio != 1.0) == 1 and ratio.max() == pytest.approx(1.25)
    rates = [found.train[0].column("yaw_rate_rad_s") for found in (constants, term, plain)]
    assert np.array_equal(rates[0], rates[2]) and np.abs(rates[1]).max() < np.abs(rates[2]).max()
    assert plain.truth.kind == "given" and not constants.truth.values and not term.truth.values


def test_channels_are_taken_from_training_records_alone(tmp_path):
    text = "  - {vessels: response-1, methods: ls, noise: ['low,only=heading']}\n"
    found = problem(plan(suite_file(tmp_path, text), RunSelection("mine"))[0].task)
    assert set(found.train[0].channels) <= {"rudder_command_rad", "rudder_rad", "propeller_rps", "heading_rad"}
    assert "yaw_rate_rad_s" in found.held_out[0].channels and found.truth.crb_sd


def test_channels_are_taken_from_measured_records(records):
    path = records / "mine.yaml"
    path.write_text("entries:\n" + ENTRY.replace("models:", "noise: 'none,without=yaw_rate', models:"))
    task = plan(load_suite(str(path)), RunSelection("mine"))[0].task
    found = problem(task)
    assert not found.train[0].has("yaw_rate_rad_s") and found.held_out[0].has("yaw_rate_rad_s")
    path.write_text("entries:\n" + ENTRY.replace("models:", "noise: low, models:"))
    with pytest.raises(BadInput, match="noise of measured records is none"):
        load_suite(str(path))
