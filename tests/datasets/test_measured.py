"""Measured sets: the published HSVA zigzags as records, and fetching from a server that may misbehave."""

import hashlib
import re
import socket
import threading
from dataclasses import replace
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest

from helmbench.datasets import measured
from helmbench.datasets.io import read_record, write_record
from helmbench.datasets.measured_sets import DATASETS, MeasuredRun
from helmbench.models.errors import BadInput

ZIGZAGS = ("05_01", "10_05", "10_10_P", "10_10_S", "15_01", "15_05", "20_05", "20_10_S", "25_05", "35_05")
STEMS = [f"Z_{zigzag}" for zigzag in ZIGZAGS]


@pytest.fixture
def hsva():
    folder = measured.data_dir() / "kvlcc2" / "hsva"
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch kvlcc2-hsva`")
    return lambda stem: measured.load("kvlcc2-hsva", stem)


# ------------------------------------------------------------------------------------------------ the records


def test_stems():
    assert list(measured.stems("kvlcc2-hsva")) == STEMS


@pytest.mark.parametrize("stem", STEMS)
def test_every_run_is_read(hsva, stem, tmp_path):
    record = hsva(stem)
    assert record.uniform(1e-6) and record.dt == pytest.approx(0.05)
    assert record.time_s[0] == 0.0 and record.n > 1300
    assert all(np.isfinite(values).all() for values in record.channels.values())
    assert np.unique(record.column("propeller_rps")) == pytest.approx(10.2295)
    nominal = np.deg2rad(float(stem.split("_")[1]))
    assert np.abs(record.rudder()).max() == pytest.approx(nominal, abs=5e-4)
    write_record(record, tmp_path / f"{stem}.csv")
    assert read_record(tmp_path / f"{stem}.csv").equals(record)


def test_channels_and_metadata(hsva):
    record = hsva("Z_10_10_P")
    assert not record.has("rudder_command_rad") and not record.has("roll_rate_rad_s")
    assert record.has("rudder_rad", "heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
    assert (record.name, record.meta.vessel, record.meta.reference_point) == ("Z_10_10_P", "kvlcc2-l7", "midship")
    assert (record.meta.positive_rudder, record.meta.manoeuvre) == ("port", "zigzag:10/10:port")
    assert hsva("Z_15_05").meta.manoeuvre == "zigzag:15/5"


@pytest.mark.parametrize(
    ("stem", "overshoots"),
    [("Z_10_10_S", (19.69, -30.54)), ("Z_10_10_P", (-19.73, 27.77)), ("Z_20_10_S", (21.71, -25.62))],
)
def test_first_two_heading_peaks_are_the_published_ones(hsva, stem, overshoots):
    psi = np.rad2deg(hsva(stem).column("heading_rad"))
    sides = np.sign(psi) * (np.abs(psi) > 1.0)
    change = np.flatnonzero((sides != 0.0) & (sides == -np.sign(overshoots[0])))[0]
    first, rest = psi[:change], psi[change:]
    back = np.flatnonzero(np.sign(rest) == np.sign(overshoots[0]))
    second = rest[: back[0]] if back.size else rest
    assert first[np.abs(first).argmax()] == pytest.approx(overshoots[0], abs=0.006)
    assert second[np.abs(second).argmax()] == pytest.approx(overshoots[1], abs=0.006)


@pytest.mark.parametrize("stem", STEMS)
def test_body_velocities_agree_with_differentiated_positions(hsva, stem):
    record = hsva(stem)
    psi = record.column("heading_rad")
    north_rate, east_rate = (np.gradient(record.column(name), record.time_s) for name in ("north_m", "east_m"))
    surge = north_rate * np.cos(psi) + east_rate * np.sin(psi)
    sway = -north_rate * np.sin(psi) + east_rate * np.cos(psi)
    assert np.sqrt(np.mean((surge - record.column("surge_m_s")) ** 2)) < 0.002
    assert np.sqrt(np.mean((sway - record.column("sway_m_s")) ** 2)) < 0.002


@pytest.mark.parametrize("stem", STEMS)
def test_yaw_rate_and_signs(hsva, stem):
    record = hsva(stem)
    rate = np.gradient(record.column("heading_rad"), record.time_s)
    assert np.sqrt(np.mean((rate - record.column("yaw_rate_rad_s")) ** 2)) < np.deg2rad(0.05)
    turned = record.turned("starboard")
    lag = 100
    agreement = np.corrcoef(turned.rudder()[:-lag], record.column("yaw_rate_rad_s")[lag:])[0, 1]
    assert agreement > 0.5, "a rudder positive to starboard turns the bow to starboard"


def test_a_changed_file_is_refused(hsva, tmp_path, monkeypatch):
    original = measured.data_dir() / "kvlcc2/hsva/HSVA_CPMC_KVLCC2_Z_05_01.dat"
    copy = tmp_path / "kvlcc2" / "hsva" / original.name
    copy.parent.mkdir(parents=True)
    copy.write_bytes(original.read_bytes().replace(b".05000", b".06000"))
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    with pytest.raises(BadInput, match=r"Z_05_01\.dat: SHA-256 differs: this is not the published file"):
        measured.load("kvlcc2-hsva", "Z_05_01")


# ------------------------------------------------------------------------------------------------ where the data lie


def test_data_dir(monkeypatch, tmp_path):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    assert measured.data_dir() == tmp_path
    monkeypatch.delenv("HELMBENCH_DATA")
    assert measured.data_dir().name == "helmbench"


def test_unknown_names_and_missing_files(monkeypatch, tmp_path):
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path))
    with pytest.raises(BadInput, match="no measured set is called 'other'; known: kvlcc2-hsva"):
        measured.load("other", "Z_15_05")
    with pytest.raises(BadInput, match="no run of kvlcc2-hsva is called 'Z_99_99'; there are Z_05_01"):
        measured.load("kvlcc2-hsva", "Z_99_99")
    with pytest.raises(BadInput, match=r"Z_15_05\.dat: no such file; run `helmbench fetch kvlcc2-hsva`, or let HELMB"):
        measured.load("kvlcc2-hsva", "Z_15_05")


# ------------------------------------------------------------------------------------------------ fetching


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format, *args):
        pass


@pytest.fixture
def published(tmp_path, monkeypatch):
    """A server that publishes a set of two runs; gives (its folder, the folder fetched into)."""
    source, target = tmp_path / "public", tmp_path / "data"
    source.mkdir()
    runs = {}
    for stem in ("a", "b"):
        content = f"run {stem}\n".encode()
        (source / f"{stem}.dat").write_bytes(content)
        runs[stem] = MeasuredRun(f"{stem}.dat", hashlib.sha256(content).hexdigest(), "straight")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(source)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    made = replace(DATASETS["kvlcc2-hsva"], url=f"http://127.0.0.1:{server.server_port}", folder="set", runs=runs)
    monkeypatch.setitem(DATASETS, "made", made)
    monkeypatch.setenv("HELMBENCH_DATA", str(target))
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    yield source, target / "set"
    server.shutdown()
    server.server_close()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_fetch_downloads_what_is_missing(published):
    source, target = published
    assert measured.fetch("made") == [target / "a.dat", target / "b.dat"]
    assert (target / "a.dat").read_bytes() == b"run a\n"
    assert names(target) == ["a.dat", "b.dat"]
    for path in source.iterdir():
        path.unlink()
    assert measured.fetch("made", progress=True) == [target / "a.dat", target / "b.dat"]


def test_fetch_replaces_a_damaged_file(published):
    _, target = published
    target.mkdir(parents=True)
    (target / "a.dat").write_bytes(b"half")
    measured.fetch("made")
    assert (target / "a.dat").read_bytes() == b"run a\n"


def test_fetch_refuses_another_file(published):
    source, target = published
    (source / "b.dat").write_bytes(b"something else\n")
    with pytest.raises(BadInput, match=r"b\.dat: the download from http://.*/b\.dat is not the published file"):
        measured.fetch("made")
    assert names(target) == ["a.dat"]


def test_fetch_says_when_the_file_is_gone(published):
    source, target = published
    (source / "a.dat").unlink()
    with pytest.raises(BadInput, match=r"a\.dat: cannot be fetched from http://.*/a\.dat \(HTTP status 404\)"):
        measured.fetch("made")
    assert names(target) == []


def test_fetch_says_when_there_is_no_network(published, monkeypatch):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    made = replace(DATASETS["made"], url=f"http://127.0.0.1:{port}")
    monkeypatch.setitem(DATASETS, "made", made)
    with pytest.raises(BadInput, match=r"\(no connection, ConnectionError\); try again") as caught:
        measured.fetch("made")
    assert "\n" not in str(caught.value)


def test_fetch_says_when_the_folder_cannot_be_made(published, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("HELMBENCH_DATA", str(tmp_path / "file"))
    with pytest.raises(BadInput, match=r"cannot be fetched from .*\(.+\)"):
        measured.fetch("made")


BLUEBOAT_COLUMNS = "original_timestamp,x_ned,y_ned,yaw,surge,sway,yaw_rate,right_force,left_force"


def test_fetch_converts_the_logger_columns_of_blueboat(published, monkeypatch):
    """Milliseconds to seconds, the difference of force to an angle, seven digits; the sum is of the converted file."""
    source, target = published
    rows = ["5000.25,-1.25,2.5,350.123456789,1.0,0.5,0.01,-10.0,100.5", "5100.25,-1.0,2.5,10.0,1.1,0.4,0.02,0.0,0.0"]
    (source / "fixed_00000001.csv").write_text("\n".join([BLUEBOAT_COLUMNS, *rows, ""]))
    stored = (
        b"time_s,rudder_command_rad,heading_deg,yaw_rate_rad_s,surge_m_s,sway_m_s,north_m,east_m\n"
        b"0,1,350.1235,0.01,1,0.5,-1.25,2.5\n0.1,0,10,0.02,1.1,0.4,-1,2.5\n"
    )
    run = MeasuredRun("one.csv", hashlib.sha256(stored).hexdigest(), "", published="fixed_00000001.csv")
    made = replace(DATASETS["blueboat"], url=DATASETS["made"].url, folder="set", runs={"one": run})
    monkeypatch.setitem(DATASETS, "made", made)
    assert measured.fetch("made") == [target / "one.csv"]
    assert (target / "one.csv").read_bytes() == stored
    record = measured.load("made", "one")
    assert np.rad2deg(record.column("heading_rad")) == pytest.approx([350.1235, 370.0])
    assert record.rudder() == pytest.approx([1.0, 0.0]) and record.meta.positive_rudder == "starboard"
    (target / "one.csv").unlink()
    (source / "fixed_00000001.csv").write_text("another,file\n1,2\n")
    with pytest.raises(BadInput, match=r"one\.csv: the download from http://.* is not the published file \(KeyError"):
        measured.fetch("made")
    assert names(target) == []


def test_registry_holds_full_sums_and_addresses():
    published = measured.dataset("kvlcc2-hsva")
    assert all(len(run.sha256) == 64 and int(run.sha256, 16) for run in published.runs.values())
    assert published.url.startswith("https://raw.githubusercontent.com/martinlarsalbert/")
    assert {run.file for run in published.runs.values()} == {f"HSVA_CPMC_KVLCC2_{stem}.dat" for stem in STEMS}


# ------------------------------------------------------------------------------------------------ the other sets


def loaded(name, stem):
    folder = measured.data_dir() / measured.dataset(name).folder
    if not folder.is_dir():
        pytest.skip(f"no measured data in {folder}: set HELMBENCH_DATA or run `helmbench fetch {name}`")
    return measured.load(name, stem)


@pytest.mark.parametrize("stem", measured.stems("kvlcc2-marin"))
def test_marin_runs_are_at_model_scale(stem):
    """Approach speed 15.5 kn and revolutions by Froude's law; velocities are the differentiated positions."""
    record = loaded("kvlcc2-marin", stem)
    assert record.uniform(1e-6) and record.dt == pytest.approx(0.0200057, rel=1e-4)
    assert record.column("surge_m_s")[0] == pytest.approx(15.5 * 0.514444 / np.sqrt(320 / 7), rel=0.02)
    psi, t = record.column("heading_rad"), record.time_s
    speed = record.column("surge_m_s") * np.cos(psi) - record.column("sway_m_s") * np.sin(psi)
    moved = record.column("north_m")[1000] - record.column("north_m")[0]
    assert np.trapezoid(speed[:1001], t[:1001]) == pytest.approx(moved, rel=0.02)
    nominal = float(stem.partition("_")[2].removeprefix("-"))
    assert np.rad2deg(np.abs(record.rudder()).max()) == pytest.approx(nominal, abs=1.0)


@pytest.mark.parametrize("stem", measured.stems("esso-osaka"))
def test_esso_osaka_runs_are_read(stem):
    record = loaded("esso-osaka", stem)
    assert record.dt == pytest.approx(0.1, rel=1e-3)
    assert record.has("rudder_command_rad", "propeller_rps", "wind_speed_m_s", "wind_direction_rad")
    assert np.abs(record.column("surge_m_s")[0]) < 0.1 < np.nanmax(record.column("surge_m_s"))
    assert np.rad2deg(np.nanmax(np.abs(record.rudder()))) <= 35.5


@pytest.mark.parametrize("stem", measured.stems("blueboat"))
def test_blueboat_runs_are_read(stem):
    record = loaded("blueboat", stem)
    assert record.dt == pytest.approx(0.1, rel=1e-3) and record.has("rudder_command_rad", "heading_rad", "north_m")
    turned = np.trapezoid(record.column("yaw_rate_rad_s"), record.time_s)
    assert turned == pytest.approx(np.diff(record.column("heading_rad")[[0, -1]])[0], abs=0.3)


@pytest.mark.parametrize("name", DATASETS)
def test_every_set_is_cited_with_full_sums(name):
    source = measured.dataset(name)
    assert all(len(run.sha256) == 64 and int(run.sha256, 16) for run in source.runs.values())
    assert re.search(r"/[0-9a-f]{40}(/|$)", source.url)
    assert source.citation and source.licence and (name == "kvlcc2-hsva" or source.known)
