"""Readers under test: a valid file to start from, the name it is read under, and the call that reads it."""

import json
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from helmbench.bench.journal import RUNS, DamagedRunsWarning
from helmbench.bench.store import MANIFEST
from helmbench.models.errors import BadInput
from helmbench.models.model import model_to_json, resolve

from ...datasets.importing.bank.test_bank import CASES
from ...datasets.importing.bank.truth import sail

CSV = "\n".join(
    ["time_s,rudder_deg,heading_deg,yaw_rate_deg_s,surge_kn"]
    + [f"{k / 2},{10 if k % 20 < 10 else -10},{(7 * k) % 360},{0.1 * (k % 7)},{6 + 0.01 * (k % 5)}" for k in range(40)]
)
SIDECAR = "vessel: mariner\npositive_rudder: port\nnotes: 5\nconstant: [surge_m_s]\nextra: {a: 1, b: [x, 2.5e-3]}\n"
SUITE = """title: mine
entries:
  - vessels: [response-1, response-2]
    methods: [ls, "ls,scheme=midpoint"]
    train: [["zigzag:20/20"], ["sine:20deg/120s+10deg/40s"]]
    held_out: ["turn:35:port"]
    noise: [low, "yaw_rate=0.05deg_s"]
    thinning: [1, 2]
    length: [0.5, 1.0]
    seeds: 2
    duration_s: 200
    dt_s: 0.5
"""
DIAGNOSIS_SUITE = b"kind: diagnosis\nmethods: innovations\nentries: [{inject: none}]\n"
VESSEL = """id: fuzzed
title: a ship
family: nomoto-1-cubic
source: "trial"
positive_rudder: starboard
speed_m_s: null
max_step_s: 0.1
parameters:
  T: {value: 21.0, unit: "s", source: &t "table 3"}
  K: {value: 0.11, unit: "1/s", source: *t}
  alpha: {value: 140.0, unit: "s2/rad2", source: *t}
rudder: {max_deg: 35, rate_deg_s: 2.5, lag_s: 0.0, source: "spec"}
controller: {kp: 1.0, kd: 2.0}
windage: {form: sinusoidal, rho_air: 1.2, A_F_m2: 3.0, A_L_m2: 9.0, cx: 0.8, cy: 0.9, cn: 0.1}
suite: {dt_s: 0.5, duration_s: 300, execute_s: 10, train: ["zigzag:20/20"], held_out: ["turn:35"]}
"""


SUBMISSION = b"""{"schema_version": 1, "exam": "e", "entrant": "me", "about": "", "worlds": {"world-1": {
  "named": [{"cause": "wind", "tied_with": ["group:resistance"], "coefficient": "Nr",
    "sizes": [{"parameter": "speed", "value": 1.5, "low": 1, "high": 2e0, "record": "train-1"}],
    "regime": {"variable": "rudder", "side": "above", "threshold": 0.2}}, {"cause": "group:resistance"}],
  "unexplained": false, "motion": {"held_out-2": "a.csv"}, "model": "a/b.json"}}}"""


INDICES = b"""name: a tanker
length_m: 320
speed_kn: 15.5
rudder_rate_deg_s: 2.3
indices:
  - {manoeuvre: "turn:35", advance_m: 1000, transfer_lengths: 1.3, tactical_diameter_cables: 5.8, speed_ratio: 0.42}
  - {manoeuvre: "zigzag:10/10", first_overshoot_deg: 8.1, accuracy: {first_overshoot_deg: 1}}
"""


TABLE = {
    "X_u": -184, "X'_{vv}": -899, "Y_v": -1160, "Y_r": -499, "Y_{\\delta}": 278, "N_v": -264, "N_r": -166, "Nd": -139,
    "m": 798, "x_G": -23, "I_z": 39.2, "X_{\\dot u}": -42, "Yvdot": -748, "Yrdot": -9.354, "N_vdot": 4.646,
    "Nrdot": -43.8,
}  # fmt: skip
TABLES = (
    "\n".join(
        ["name,value (x 10^-5),unit", *(f"{name},{value}," for name, value in TABLE.items()), "L,160.93,m", "U0,15,kn"]
    ).encode(),
    "\n".join(
        [*(f"{name}: {value}e-5" for name, value in TABLE.items()), "L: 160.93", "U0: {value: 15, unit: kn}"]
    ).encode(),
    json.dumps(
        {name: value * 1e-5 for name, value in TABLE.items()} | {"L": 160.93, "U0": {"value": 15, "unit": "kn"}}
    ).encode(),
)


@dataclass(frozen=True)
class Reader:
    """seeds : valid files.  name : of the file.  read : takes the path; `BadInput` and `CannotFit` of it are refusals.
    whole : the same call as a user makes it, which reads in a process of its own: tried where `read` ends its process.
    """

    seeds: tuple[bytes, ...]
    name: str
    read: Callable[[Path], object]
    whole: Callable[[Path], object] | None = None


def _model_files(scratch: Path) -> tuple[bytes, ...]:
    found = []
    for name in ("response-1", "cargo", "kvlcc2-l7"):
        model_to_json(resolve(name), scratch / "seed.json")
        found.append((scratch / "seed.json").read_bytes())
    facts = json.loads(found[0])
    facts["instruments"] = {"rudder_offset": {"value": 2, "unit": "deg"}, "yaw_rate_delay": {"value": 1, "unit": "s"}}
    return (*found, json.dumps(facts, indent=1).encode())


def _parquet_files(scratch: Path) -> tuple[bytes, ...]:
    from helmbench.datasets.io import read_record, write_record

    (scratch / "seed.csv").write_text(CSV)
    write_record(read_record(scratch / "seed.csv"), scratch / "seed.parquet")
    return ((scratch / "seed.parquet").read_bytes(),)


STRINGS = b"""zigzag:20/20
turn:35:port
sine:20deg/120s+10deg/40s
prbs:20deg/15s
spiral:25/5
wind:12@40deg+current:0.5@10deg
waves:1.5/8@30deg
medium,dropout=2%
yaw_rate=0.05deg_s
"""


def _strings(path: Path) -> None:
    """Manoeuvre, disturbance and noise strings, a line each, as the command line takes them."""
    from helmbench.datasets.disturbances import parse_disturbance
    from helmbench.datasets.manoeuvres import parse_manoeuvre
    from helmbench.datasets.sensors import parse_noise

    for line in path.read_text(errors="replace").splitlines()[:20]:
        for parse in (parse_manoeuvre, parse_disturbance, parse_noise):
            with suppress(BadInput):
                parse(line)


def _api(path: Path) -> None:
    """Values of JSON as arguments of the interface in Python."""
    import helmbench
    from helmbench.models.data_file import load

    given = load(path)
    for value in given[:5] if isinstance(given, list) else [given]:
        with suppress(BadInput):
            helmbench.simulate("response-1", "turn:10", duration_s=60.0, dt_s=5.0, noise="low", seed=value)
        with suppress(BadInput):
            helmbench.simulate("response-1", value, duration_s=60.0, dt_s=5.0)


def _record(path: Path) -> None:
    from helmbench.datasets.io import read_record

    path.with_suffix(".yaml").unlink(missing_ok=True)
    read_record(path)


def _sidecar(path: Path) -> None:
    from helmbench.datasets.io import read_record

    path.with_suffix(".csv").write_text(CSV)
    read_record(path.with_suffix(".csv"))


def _model(path: Path) -> None:
    resolve(path)


def _suite(path: Path) -> None:
    """As `run` does before anything is computed: load, ask for trust, plan."""
    from helmbench.bench.kinds import kind_of
    from helmbench.bench.kinds.base import RunSelection
    from helmbench.bench.suites import check_trust, load_suite

    suite = load_suite(str(path))
    check_trust(suite.texts, path, False)
    kind = kind_of(suite.kind)
    kind.plan(suite, kind.with_seed(suite, RunSelection(str(path))))


def _vessel(path: Path) -> None:
    from helmbench.models.model import _from_facts
    from helmbench.models.vessel import read_vessel

    read_vessel.cache_clear()
    _from_facts("fuzzed", read_vessel(path), path)


def _option(name: str) -> Callable[[Path], None]:
    def read(path: Path) -> None:
        from helmbench.estimation.methods_only.prior_knowledge import unknowns_of

        given = dict.fromkeys(("prior", "bounds", "fixed")) | {name: str(path)}
        unknowns_of(resolve("response-1"), **given)

    return read


def _journal(path: Path) -> None:
    import warnings

    from helmbench.api.suites import load_results

    (path.parent / MANIFEST).write_bytes(MANIFEST_TEXT)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DamagedRunsWarning)
        found = load_results(path.parent)
        found.counts, found.failure_texts, found.runs()


def _traces(path: Path) -> None:
    import warnings

    from helmbench.bench.traces import read_traces
    from helmbench.reporting.leaderboard.page_data import _log, _residuals

    problem: dict[str, Any] = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DamagedRunsWarning)
        found = read_traces(path.parent)
    for run in found:
        _residuals(problem, run["trace"]), _log(run["trace"])


def _manifest(path: Path) -> None:
    from helmbench.api.suites import _stored_selection, load_results

    (path.parent / RUNS).write_bytes(JOURNAL)
    found = load_results(path.parent)
    found.complete, found.counts, _stored_selection(path.parent)


def _mapping(path: Path) -> None:
    from helmbench.datasets.importing.mapping import read_mapping

    read_mapping(path)


MANIFEST_TEXT = json.dumps(
    {"kind": "identification", "suite": "mine", "title": "t", "version": "0", "planned": 2, "suite_digest": "0",
     "plan_digest": "0", "selection": {"suite": "mine", "methods": ["ls"], "vessels": [], "seeds": 1, "seed": None}}
).encode()  # fmt: skip
ROW = {
    "suite": "mine", "method": "ls", "variant": "corrected", "vessel": "response-1", "model": "nomoto-1-cubic",
    "train": "zigzag:20/20", "held_out": "turn:35", "noise": "low", "disturbance": "none", "thinning": 1, "length": 1.0,
    "seed": 0, "status": "ok", "error": None, "diverged": False, "n_samples": 100, "wall_s": 0.1,
}  # fmt: skip
JOURNAL = b"".join(
    json.dumps(
        {"key": f"k{i}", "row": ROW | {"seed": i}, "parameters": [{"parameter": "T", "unit": "s", "estimate": 1.5}]}
    ).encode()
    + b"\n"
    for i in range(3)
)
TRACE = {
    "record": "turn:35", "time_s": [0.0, 0.5, 1.0, 1.5],
    "channels": {"yaw_rate_deg_s": {"measured": [0.1, None, 0.3, 0.2], "predicted": [0.1, 0.2, None, 0.25]}},
    "log": {"time_s": [0.0, 0.5, 1.0, 1.5], "values": {"T": [1.0, 2.0, None, 2.5], "K": [0.1, 0.2, 0.15, 0.16]}},
}  # fmt: skip
TRACED = b"".join(
    json.dumps({"key": f"k{i}", "row": ROW | {"seed": i}, "parameters": [], "trace": TRACE}).encode() + b"\n"
    for i in range(2)
)
MAPPING = b"""version: 1
vessel: mariner
tables:
  - file: log.csv
    time: {columns: [t], form: seconds}
    clock_offset_s: 0.5
    columns:
      - {column: rudder, to: rudder, unit: deg, sign: -1}
      - {column: hdg, to: heading, unit: deg}
"""
PRIOR = (b"T: [14, 1e-1]\nK: {mean: 0.2, sd: 0.05, unit: 1/s}\n", b"T: {mean: 0.25, sd: 0.05, unit: min}\n")
BOUNDS = (b"T: [1, null]\nK: {low: 0.0, high: .inf}\n", b"alpha: [-.inf, 400]\n")


PROBLEMS = json.dumps(
    {"schema_version": 1, "suite": "s", "title": "t", "version": "0", "units": {"rudder_rad": "rad"},
     "problems": [{"name": "1-a", "inputs": ["rudder_rad"], "outputs": ["yaw_rate_rad_s"], "noise": "low"}]}
).encode()  # fmt: skip


RAW = {
    "raw-text": "German",
    "raw-workbook": "workbook with merged headers",
    "raw-mat": "MAT",
    "raw-hdf5": "MAT 7.3",
    "raw-parquet": "Parquet",
    "raw-nmea": "NMEA, stamps in brackets, AIS, bad sentences",
    "raw-n2k": "NMEA 2000, candump",
    "raw-canboat": "NMEA 2000, canboat",
    "raw-gpx": "GPX and a pilot's log",
    "raw-expedition": "Expedition",
    "raw-px4": "PX4",
    "raw-ardupilot": "ArduPilot",
    "raw-ros": "ROS topics, frame unsaid",
    "raw-long": "long form",
    "raw-bag": "ROS 1 bag",
    "raw-ydvr": "YDVR",
    "raw-pashr": "PASHR with roll",
    "raw-times": "two time columns",
    "raw-parts": "year, month, day, hour, minute, second",
    "raw-halves": "columns to port and to starboard",
    "raw-quoted": "header cells over two lines",
    "raw-json": "JSON, values with units, stamp before",
    "raw-document": "JSON, a document of columns",
    "raw-signalk": "Signal K, deltas",
    "raw-batch": "Signal K, a column for every time",
    "raw-influx": "InfluxDB, long",
    "raw-lines": "InfluxDB, line protocol",
    "raw-mavlink-text": "MAVLink as text",
    "raw-moos": "MOOS",
    "raw-dataflash": "dataflash as text",
    "raw-mavlink": "MAVLink as CSV",
    "raw-ublox": "u-blox NAV-PVT",
    "raw-makers": "names before the sentences, iXblue",
    "raw-novatel": "NovAtel BESTPOS, BESTVEL, HEADING",
    "raw-hypack": "Hypack RAW",
    "raw-sbet": "SBET and a pilot's log",
    "raw-tcx": "TCX and a pilot's log",
    "raw-labview": "LabVIEW, times of every channel, decimal commas",
    "raw-fixed": "fixed width, numbers that touch",
    "raw-tables": "two tables in one file",
    "raw-toa5": "Campbell Scientific TOA5",
    "raw-tecplot": "Tecplot",
    "raw-values": "named values",
}
"""Reader -> log of the bank whose first file is changed."""


def _submission(path: Path) -> None:
    """Also the files that it names: there are none."""
    from helmbench.bench.exam.exam_file import WorldFiles
    from helmbench.bench.exam.submission import extended_model, read_submission, stated

    facts = {"base_numbers": "exact", "train": ("train-1",), "held_out": ("held_out-2",), "opening_s": {}}
    world = WorldFiles.model_validate(facts | {"groups": {"group:resistance": {}}})
    exam: Any = SimpleNamespace(id="e", worlds={"world-1": world}, causes={"wind": {}})
    read = read_submission(path, exam)
    stated(read.answer("world-1"), resolve("mariner"))
    with suppress(BadInput):
        extended_model(read, "world-1")


def _problems(path: Path) -> None:
    from helmbench.bench.identibench.problems import identibench_specs

    identibench_specs(path.parent)


def _indices(path: Path) -> None:
    from helmbench.estimation.indices.given import read_indices

    read_indices(path)


def _table(path: Path) -> None:
    """The suffix decides how a table is read: given by the first character."""
    from helmbench.models.parameter_table import model_of_table

    start = path.read_bytes().lstrip()[:1]
    named = path.with_suffix({b"{": ".json", b"X": ".yaml"}.get(start, ".csv"))
    path.rename(named)
    model_of_table(named, "abkowitz", "port", None, None)


def _raw_readers(scratch: Path) -> dict[str, Reader]:
    import numpy as np

    run, found = sail(np.random.default_rng(1), seconds=40.0), {}
    for name, log in RAW.items():
        folder = scratch / name
        folder.mkdir()
        path = CASES[log].write(run, folder)[0]
        found[name] = Reader((path.read_bytes(),), path.name, _raw, _drafted)
    return found


def _drafted(path: Path) -> None:
    """As an import does."""
    from helmbench.datasets.importing import sources
    from helmbench.datasets.importing.importer import ImportOptions, draft_tables

    draft_tables(sources.read_raw(path), None, ImportOptions(), {})


def _raw(path: Path) -> None:
    """As an import does, but in this process: what a library raises on a binary file is a refusal there."""
    from helmbench.datasets.importing import sources
    from helmbench.datasets.importing.contained import READERS

    def contained(kind, data, place):
        try:
            return READERS[kind](data, place)
        except (BadInput, MemoryError):
            raise
        except Exception as error:
            raise BadInput(type(error).__name__) from None

    sources.read_contained = contained
    _drafted(path)


def readers(scratch: Path) -> dict[str, Reader]:
    """Name -> reader; `scratch` is a folder for the making of seeds."""
    return {
        "record": Reader((CSV.encode(), CSV.replace(",", ";").encode()), "r.csv", _record),
        "parquet": Reader(_parquet_files(scratch), "r.parquet", _record),
        "sidecar": Reader((SIDECAR.encode(),), "r.yaml", _sidecar),
        "model": Reader(_model_files(scratch), "m.json", _model),
        "suite": Reader(
            (SUITE.encode(), b"kind: diagnosis\nmethods: innovations\nentries: [{inject: none}]\n"), "s.yaml", _suite
        ),
        "vessel": Reader((VESSEL.encode(),), "fuzzed.yaml", _vessel),
        "prior": Reader(PRIOR, "prior.yaml", _option("prior")),
        "bounds": Reader(BOUNDS, "bounds.yaml", _option("bounds")),
        "fixed": Reader((b"[alpha, K]\n", b"{T: 3.0, K: {value: 12, unit: rpm}}\n"), "fixed.yaml", _option("fixed")),
        "journal": Reader((JOURNAL,), RUNS, _journal),
        "traces": Reader((TRACED,), RUNS, _traces),
        "manifest": Reader((MANIFEST_TEXT,), MANIFEST, _manifest),
        "strings": Reader((STRINGS,), "strings.txt", _strings),
        "api": Reader((b'[1, "turn:10", null, 2.5, [3], {"a": 1}]',), "arguments.json", _api),
        "mapping": Reader((MAPPING,), "log.map.yaml", _mapping),
        "submission": Reader((SUBMISSION,), "submission.json", _submission),
        "problems": Reader((PROBLEMS,), "problems.json", _problems),
        "indices": Reader((INDICES,), "ship.yaml", _indices),
        "table": Reader(TABLES, "table.csv", _table),
        **_raw_readers(scratch),
    }
