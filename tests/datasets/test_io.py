"""Reading and writing records: what is read, what is refused and with which words, what survives the round trip."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import yaml

from helmbench.api.arguments import as_records
from helmbench.datasets.columns import ACCEPTED, CANONICAL
from helmbench.datasets.io import read_record, write_record
from helmbench.datasets.record import Record, RecordMeta
from helmbench.models.errors import BadInput

HEADER = ["time_s", "rudder_rad", "heading_rad", "yaw_rate_rad_s"]


def zigzag(n: int = 40) -> np.ndarray:
    """(n, 4) samples of `HEADER` that swing to both sides."""
    time = np.arange(n) * 0.5
    return np.column_stack([time, 0.35 * np.sign(np.cos(time)), 0.3 * np.sin(time), 0.3 * np.cos(time)])


def rows(samples: np.ndarray) -> list[list[str]]:
    return [[repr(float(value)) for value in row] for row in samples]


def save(path: Path, header: list[str], body: list[list[str]], separator: str = ",", end: str = "\n") -> Path:
    path.write_text(end.join(separator.join(row) for row in [header, *body]) + end, encoding="utf-8", newline="")
    return path


@pytest.fixture
def table() -> list[list[str]]:
    return rows(zigzag())


@pytest.fixture
def trial(tmp_path) -> Path:
    return tmp_path / "trial.csv"


def refusal(path: Path, **options) -> str:
    with pytest.raises(BadInput) as caught:
        read_record(path, **options)
    message = str(caught.value)
    assert "\n" not in message
    return message.removeprefix(str(path.parent) + os.sep)


# ------------------------------------------------------------------------------------------------ what is read


def test_plain_csv(trial, table):
    record = read_record(save(trial, HEADER, table))
    assert record.name == "trial" and record.meta == RecordMeta()
    assert list(record.channels) == HEADER[1:]
    for name, expected in zip(HEADER, zigzag().T, strict=True):
        np.testing.assert_array_equal(record.column(name), expected)


@pytest.mark.parametrize("separator", [",", ";", "\t", ", "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_separators_line_ends_and_byte_order_mark(trial, table, separator, end, mark):
    save(trial, HEADER, table, separator, end)
    trial.write_bytes(mark.encode() + trial.read_bytes())
    np.testing.assert_array_equal(read_record(trial).column("heading_rad"), zigzag()[:, 2])


def test_blank_and_nan_cells_are_gaps(trial, table):
    for row, gap in zip(table[3:9], ["", "nan", "NaN", " ", "NAN", "-nan"], strict=True):
        row[2] = gap
    heading = read_record(save(trial, HEADER, table)).column("heading_rad")
    assert list(np.flatnonzero(np.isnan(heading))) == [3, 4, 5, 6, 7, 8]


def test_numbers_in_every_usual_spelling(trial, table):
    spellings = ["1", "+1", "1.", ".5", "-1.5e-3", "1E3", '"2.5"', "1e+2"]
    for row, text in zip(table, spellings, strict=False):
        row[3] = text
    rate = read_record(save(trial, HEADER, table)).column("yaw_rate_rad_s")
    np.testing.assert_array_equal(rate[:8], [1.0, 1.0, 1.0, 0.5, -1.5e-3, 1e3, 2.5, 100.0])


def test_blank_lines_are_passed_over(trial, table):
    save(trial, HEADER, [*table[:5], [""], *table[5:], [""], [""]])
    assert len(read_record(trial)) == len(table)


@pytest.mark.parametrize(
    ("name", "canonical", "value", "expected"),
    [
        ("rudder_deg", "rudder_rad", 180.0, math.pi),
        ("rudder_command_deg", "rudder_command_rad", 90.0, math.pi / 2),
        ("heading_deg", "heading_rad", -90.0, -math.pi / 2),
        ("roll_deg", "roll_rad", 60.0, math.pi / 3),
        ("wind_direction_deg", "wind_direction_rad", 45.0, math.pi / 4),
        ("yaw_rate_deg_s", "yaw_rate_rad_s", 1.0, math.pi / 180),
        ("roll_rate_deg_s", "roll_rate_rad_s", 2.0, math.pi / 90),
        ("surge_kn", "surge_m_s", 1.0, 1852 / 3600),
        ("sway_kn", "sway_m_s", 3600.0, 1852.0),
        ("wind_speed_kn", "wind_speed_m_s", 10.0, 5.144444444444445),
        ("surge_ms", "surge_m_s", 7.5, 7.5),
        ("wind_speed_ms", "wind_speed_m_s", 12.0, 12.0),
        ("propeller_rpm", "propeller_rps", 90.0, 1.5),
        ("time_ms", "time_s", 500.0, 0.5),
    ],
)
def test_units_are_converted(trial, name, canonical, value, expected):
    columns = dict(zip(HEADER, zigzag().T, strict=True))
    columns.pop(canonical, None)
    columns[name] = value * (1.0 + np.arange(40))
    columns.setdefault("rudder_command_rad", columns["yaw_rate_rad_s" if name != "yaw_rate_deg_s" else "heading_rad"])
    if canonical == "rudder_command_rad":
        del columns["rudder_command_rad"]
    save(trial, list(columns), rows(np.column_stack(list(columns.values()))))
    np.testing.assert_allclose(read_record(trial).column(canonical)[:2], [expected, 2 * expected], rtol=1e-14)


def test_accepted_names_cover_every_quantity():
    assert {channel for channel, _ in ACCEPTED.values()} == set(CANONICAL)
    assert "north_kn" not in ACCEPTED and "time_deg" not in ACCEPTED and "north_ms" not in ACCEPTED


def test_reading_starts_without_the_heavy_libraries():
    code = (
        "import sys, helmbench.datasets.io, helmbench.datasets.measured; "
        "print([m for m in ('pandas', 'pyarrow', 'yaml', 'pooch', 'platformdirs', 'tqdm') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# ------------------------------------------------------------------------------------------------ what is refused


def cell(row: int, column: int, text: str):
    """A change of one cell; `row` is the line number in the file."""

    def change(header, body):
        body[row - 2][column] = text

    return change


def whole_column(column: int, text: str):
    def change(header, body):
        for row in body:
            row[column] = text

    return change


def constant_motion(header, body):
    for column in (2, 3):
        whole_column(column, "0.25")(header, body)


def rename(column: int, name: str):
    def change(header, body):
        header[column] = name

    return change


def drop(column: int):
    def change(header, body):
        for row in [header, *body]:
            del row[column]

    return change


def only_time(header, body):
    for row in [header, *body]:
        del row[1:]


def cut(rows_left: int):
    def change(header, body):
        del body[rows_left:]

    return change


def swap_lines(header, body):
    body[8], body[9] = body[9], body[8]


def repeat_line(header, body):
    body[9] = list(body[8])


def double_column(name: str):
    def change(header, body):
        header.append(name)
        for row in body:
            row.append(row[2])

    return change


# case -> (change of a good table, row, column, how the rest of the message starts)
BAD_TABLES = {
    "text": (cell(17, 3, "abc"), 17, "yaw_rate_rad_s", "'abc' is not a number; leave the cell empty for a gap"),
    "not available": (cell(5, 1, "N/A"), 5, "rudder_rad", "'N/A' is not a number"),
    "underscore": (cell(6, 1, "1_0"), 6, "rudder_rad", "'1_0' is not a number"),
    "other digits": (cell(6, 1, "\u0663"), 6, "rudder_rad", "'\u0663' is not a number"),
    "hexadecimal": (cell(6, 1, "0x10"), 6, "rudder_rad", "'0x10' is not a number"),
    "time of day": (cell(4, 0, "12:00:01"), 4, "time_s", "'12:00:01' is not a number"),
    "long text": (cell(4, 1, "x" * 500), 4, "rudder_rad", f"'{'x' * 37}...' is not a number"),
    "infinite": (cell(12, 2, "inf"), 12, "heading_rad", "infinite value"),
    "minus infinite": (cell(12, 2, "-Infinity"), 12, "heading_rad", "infinite value"),
    "overflow": (cell(12, 2, "1e400"), 12, "heading_rad", "infinite value"),
    "infinite time": (cell(41, 0, "inf"), 41, "time_s", "time is infinite"),
    "time gap": (cell(7, 0, ""), 7, "time_s", "time is missing; every row needs its time"),
    "empty time": (whole_column(0, ""), 2, "time_s", "time is missing"),
    "time back": (swap_lines, 11, "time_s", "time goes back from 4.5 to 4"),
    "duplicate time": (repeat_line, 11, "time_s", "duplicate time 4;"),
    "all gaps": (whole_column(2, ""), 2, "heading_rad", "no value in the whole column"),
    "all nan": (whole_column(2, "nan"), 2, "heading_rad", "no value in the whole column"),
    "no time": (drop(0), 1, "time_s", "missing column; every record needs its time"),
    "time alone": (only_time, 1, None, "no channel beside the time; known are time_s, rudder_command_rad"),
    "unknown unit": (rename(2, "heading_grad"), 1, "heading_grad", "unknown unit 'grad'; accepted: heading_rad, head"),
    "north in knots": (rename(2, "north_kn"), 1, "north_kn", "unknown unit 'kn'; accepted: north_m"),
    "no unit": (rename(3, "yaw_rate"), 1, "yaw_rate", "the unit is missing; accepted: yaw_rate_rad_s, yaw_rate_deg_s"),
    "time without unit": (rename(0, "time"), 1, "time", "the unit is missing; accepted: time_s, time_ms"),
    "wrong unit": (rename(3, "yaw_rate_deg"), 1, "yaw_rate_deg", "unknown unit 'deg'; accepted: yaw_rate_rad_s"),
    "misspelt": (rename(2, "headng_rad"), 1, "headng_rad", "unknown column; did you mean heading_rad?"),
    "capitals": (rename(2, "Heading_rad"), 1, "Heading_rad", "unknown column; did you mean heading_rad?"),
    "unknown": (rename(2, "zzz"), 1, "zzz", "unknown column; accepted: time_s, rudder_command_rad, rudder_rad"),
    "nameless": (rename(3, ""), 1, None, "column 4 has no name"),
    "twice": (double_column("heading_rad"), 1, "heading_rad", "the column appears twice"),
    "two units": (double_column("heading_deg"), 1, "heading_deg", "the same quantity as heading_rad"),
    "too short": (cut(9), 10, None, "too short: 9 samples; a record needs 10"),
    "header only": (cut(0), 1, None, "too short: 0 samples"),
    "constant motion": (constant_motion, 2, "heading_rad", "constant channel: 0.25 in every row"),
    "dead rudder": (whole_column(1, "0.1"), 2, "rudder_rad", "constant channel: 0.1 in every row"),
    "dead rudder at zero": (whole_column(1, "0"), 2, "rudder_rad", "constant channel: 0 in every row"),
}


@pytest.mark.parametrize("case", BAD_TABLES)
def test_bad_tables(trial, table, case):
    change, row, column, text = BAD_TABLES[case]
    header = list(HEADER)
    change(header, table)
    place = f"row {row}" + (f", column {column}" if column else "")
    assert refusal(save(trial, header, table)).startswith(f"trial.csv: {place}: {text}")
    assert sorted(p.name for p in trial.parent.iterdir()) == ["trial.csv"]


def test_a_record_without_a_rudder_is_read_and_what_needs_one_says_so(trial, table):
    header = list(HEADER)
    drop(1)(header, table)
    record = read_record(save(trial, header, table))
    assert not record.has("rudder_rad") and record.has("heading_rad")
    with pytest.raises(BadInput, match=r"column rudder_rad: no rudder in this record; .* 'helmbench check' needs none"):
        as_records(record)


def test_refusals_count_blank_lines_as_an_editor_does(trial, table):
    table[10][2] = "abc"
    save(trial, HEADER, [*table[:3], [""], [""], *table[3:]])
    assert refusal(trial).startswith("trial.csv: row 14, column heading_rad: 'abc'")
    table[10][2] = "inf"
    save(trial, HEADER, [*table[:3], [""], [""], *table[3:]], end="\r\n")
    assert refusal(trial).startswith("trial.csv: row 14, column heading_rad: infinite value")


def test_refusals_speak_of_the_columns_of_the_file(trial):
    samples = zigzag() * [1000.0, 1.0, 1.0, 1.0]
    samples[20, 0] = samples[19, 0]
    save(trial, ["time_ms", *HEADER[1:]], rows(samples))
    assert refusal(trial).startswith("trial.csv: row 22, column time_ms: duplicate time 9500;")


@pytest.mark.parametrize("ragged", [["1.0", "2.0"], ["1.0", "2.0", "3.0", "4.0", "5.0"]])
@pytest.mark.parametrize("place", [0, 30, 39])
def test_ragged_rows(trial, table, ragged, place):
    table[place] = ragged
    expected = f"trial.csv: row {place + 2}: {len(ragged)} cells under 4 columns; "
    assert refusal(save(trial, HEADER, table)).startswith(expected)


def test_ragged_rows_that_make_up_for_each_other(trial, table):
    table[4].append(table[3].pop())
    assert refusal(save(trial, HEADER, table)).startswith("trial.csv: row 5: 3 cells under 4 columns")


def test_decimal_commas(trial, table):
    comma = [[text.replace(".", ",") for text in row] for row in table]
    message = refusal(save(trial, HEADER, comma, ";"))
    assert message == "trial.csv: row 2, column time_s: '0,0' is not a number; write decimals with a point"
    assert refusal(save(trial, HEADER, comma)).endswith("row 2: 8 cells under 4 columns; write decimals with a point")


def test_no_header_and_other_separators(trial, table):
    save(trial, table[0], table[1:])
    assert refusal(trial).startswith("trial.csv: row 1, column 0.0: there is a number where the header should be")
    save(trial, HEADER, table, "|")
    assert refusal(trial).endswith("no separator found in the header; separate the columns by comma, semicolon or tab")


def test_unbalanced_quote(trial, table):
    table[6][1] = '"0.1'
    assert refusal(save(trial, HEADER, table)).startswith("trial.csv: row ")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "trial.csv: row 1: the file is empty"),
        (b"\n \r\n", "trial.csv: row 1: the file is empty"),
        (b"\xef\xbb\xbf", "trial.csv: row 1: the file is empty"),
        (b"\ntime_s,rudder_rad\n", "trial.csv: row 1"),
        (b"time_s,rudder_rad\n1,2\r\n3,\xb0\n", "trial.csv: row 3: wrong encoding: byte 0xb0 is not UTF-8 text"),
        ("time_s,rudder_rad\n1,2\n".encode("utf-16"), "trial.csv: row 1: wrong encoding: byte 0xff is not UTF-8 text"),
        ("time_s,rudder_rad\n1,2\n".encode("utf-16-le"), "trial.csv: row 1: wrong encoding: byte 0x00 is not UTF-8"),
        (b"PK\x03\x04\x14\x00\x06\x00", "trial.csv: is a workbook or a binary log, not a record; 'helmbench import"),
        (b'{"schema": 1}', "trial.csv: is JSON, such as a model, not a record"),
    ],
)
def test_bad_bytes(trial, content, message):
    trial.write_bytes(content)
    assert refusal(trial).startswith(message)


def test_no_file(trial, tmp_path):
    assert refusal(trial) == "trial.csv: no such file"
    assert "cannot be read" in refusal(tmp_path)


def test_unknown_side_on_reading(trial, table):
    message = refusal(save(trial, HEADER, table), positive_rudder="left")
    assert message == "trial.csv: positive rudder 'left'; give 'port' or 'starboard'"


# ------------------------------------------------------------------------------------------------ constant channels


def with_columns(path: Path, **columns: np.ndarray) -> Path:
    columns = {name: np.broadcast_to(values, 40) for name, values in columns.items()}
    return save(path, list(columns), rows(np.column_stack(list(columns.values()))))


TIME = np.arange(40) * 0.5
WOBBLE = 0.01 * np.sin(3.0 * TIME)


@pytest.mark.parametrize("channel", ["propeller_rps", "wind_speed_m_s", "wind_direction_rad"])
def test_set_values_and_weather_may_be_constant(trial, table, channel):
    save(trial, [*HEADER, channel], [[*row, "1.5"] for row in table])
    assert np.ptp(read_record(trial).column(channel)) == 0.0


@pytest.mark.parametrize("channel", ["surge_m_s", "sway_m_s", "north_m", "east_m", "roll_rad", "roll_rate_rad_s"])
def test_dead_motion_channels_are_left_out_unless_declared(trial, table, channel):
    save(trial, [*HEADER, channel], [[*row, "1.5"] for row in table])
    record = read_record(trial)
    assert not record.has(channel) and record.has("heading_rad", "yaw_rate_rad_s")
    assert record.meta.extra == {"left_out": {channel: f"1.5 {CANONICAL[channel]} in every row"}}
    trial.with_suffix(".yaml").write_text(f"constant: [{channel}]\n")
    record = read_record(trial)
    assert record.column(channel)[5] == 1.5 and record.meta.extra == {}


@pytest.mark.parametrize("place", [2, 3])
def test_one_of_heading_and_yaw_rate_may_be_dead(trial, table, place):
    whole_column(place, "-0")(HEADER, table)
    record, unit = read_record(save(trial, HEADER, table)), CANONICAL[HEADER[place]]
    assert [*record.channels] == [name for name in HEADER[1:] if name != HEADER[place]]
    assert record.meta.extra == {"left_out": {HEADER[place]: f"0 {unit} in every row"}}
    write_record(record, trial)
    assert read_record(trial).equals(record)


def test_held_rudder_is_read_where_the_record_shows_that_it_was_held(trial):
    noisy = {"yaw_rate_rad_s": WOBBLE, "heading_rad": WOBBLE}
    assert read_record(with_columns(trial, time_s=TIME, rudder_rad=np.zeros(1), **noisy)).rudder()[0] == 0.0
    turning = {"heading_rad": np.mod(0.3 * TIME, 2 * np.pi)}
    assert len(read_record(with_columns(trial, time_s=TIME, rudder_rad=np.array(0.6), **turning))) == 40
    ramp = np.minimum(0.1 * TIME, 0.6)
    command = np.array(0.6)
    record = read_record(with_columns(trial, time_s=TIME, rudder_command_rad=command, rudder_rad=ramp, **turning))
    assert np.ptp(record.column("rudder_command_rad")) == 0.0
    rate = 0.1 - 0.1 * np.exp(-TIME)
    assert len(read_record(with_columns(trial, time_s=TIME, rudder_command_rad=command, yaw_rate_rad_s=rate))) == 40


def test_dead_rudder_beside_one_that_moves(trial):
    moving, dead = 0.35 * np.sign(np.cos(TIME)), np.array(0.35)
    motion = {"time_s": TIME, "heading_rad": 0.01 * TIME}
    message = refusal(with_columns(trial, rudder_command_rad=moving, rudder_rad=dead, **motion))
    assert message.startswith("trial.csv: row 2, column rudder_rad: constant channel")
    message = refusal(with_columns(trial, rudder_command_rad=dead, rudder_rad=moving, **motion))
    assert message.startswith("trial.csv: row 2, column rudder_command_rad: constant channel")


def test_constant_rudder_with_nothing_to_show_for_it(trial):
    message = refusal(with_columns(trial, time_s=TIME, rudder_rad=np.array(0.1), surge_m_s=7.0 - 0.01 * TIME))
    assert message.startswith("trial.csv: row 2, column rudder_rad: constant channel: 0.1 in every row")
    message = refusal(with_columns(trial, time_s=TIME, rudder_deg=np.array(5.0), yaw_rate_rad_s=0.3 * np.cos(TIME)))
    assert message.startswith("trial.csv: row 2, column rudder_deg: constant channel: 5 in every row")


def test_gaps_do_not_hide_a_constant_channel(trial, table):
    for row in table[:7]:
        row[2] = ""
    for row in table[7:]:
        row[2] = "0.5"
    assert read_record(save(trial, HEADER, table)).meta.extra == {"left_out": {"heading_rad": "0.5 rad in every row"}}


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_written_straight_course_without_noise_reads_back(tmp_path, suffix):
    still = np.zeros(60)
    channels = {
        "rudder_command_rad": still, "rudder_rad": still, "heading_rad": still, "yaw_rate_rad_s": still,
        "surge_m_s": still + 7.7, "sway_m_s": still, "north_m": 7.7 * np.arange(60), "east_m": still,
    }  # fmt: skip
    meta = RecordMeta(vessel="mariner", positive_rudder="port", manoeuvre="straight")
    record = Record(np.arange(60.0), channels, name="straight", meta=meta)
    write_record(record, tmp_path / f"straight{suffix}")
    assert read_record(tmp_path / f"straight{suffix}").equals(record)


# ------------------------------------------------------------------------------------------------ sidecar


def sidecar(trial: Path, table, text: str) -> Path:
    save(trial, HEADER, table)
    trial.with_suffix(".yaml").write_text(text, encoding="utf-8")
    return trial


def test_sidecar_is_read(trial, table):
    text = (
        "vessel: kvlcc2-l7\nreference point: midship\nsource: Prüfstand 2006\nlicence: null\npositive_rudder: port\n"
        "manoeuvre: zigzag:20/20\nnotes: 5\nextra: {operator: {name: A}, runs: [1, 2]}\n"
    )
    meta = read_record(sidecar(trial, table, text)).meta
    assert meta == RecordMeta(
        vessel="kvlcc2-l7",
        reference_point="midship",
        source="Prüfstand 2006",
        positive_rudder="port",
        manoeuvre="zigzag:20/20",
        notes="5",
        extra={"operator": {"name": "A"}, "runs": [1, 2]},
    )
    assert read_record(trial, positive_rudder="starboard").meta.positive_rudder == "starboard"


def test_sidecar_may_be_empty_or_end_in_yml(trial, table):
    assert read_record(sidecar(trial, table, "# nothing\n")).meta == RecordMeta()
    trial.with_suffix(".yaml").rename(trial.with_suffix(".yml")).write_text("vessel: s175\n")
    assert read_record(trial).meta.vessel == "s175"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("vessel: x\npositive_rudder: left\n", "trial.yaml: row 2: positive_rudder: needs port or starboard, not left"),
        ("positive_rudder: Starboard\n", "trial.yaml: row 1: positive_rudder: needs port or starboard, not Starboard"),
        ("positive_rudder: 7\n", "trial.yaml: row 1: positive_rudder: needs port or starboard, not 7"),
        (
            "vessel: x\npositive_ruder: port\n",
            "trial.yaml: row 2: unknown key 'positive_ruder'; did you mean positive",
        ),
        ("vessel: x\nvessel: y\n", "trial.yaml: row 2: the key 'vessel' stands twice"),
        ("reference point: x\nreference_point: y\n", "trial.yaml: row 2: a key stands twice, in two spellings"),
        ("positive_rudder: yes\n", "trial.yaml: row 1: positive_rudder: needs port or starboard, not true"),
        ("vessel: [a, b]\n", "trial.yaml: row 1: vessel: needs a text, not ['a', 'b']"),
        ("vessel: x\nnotes: {a: 1}\n", "trial.yaml: row 2: notes: needs a text, not {'a': 1}"),
        ("vessel: x\nsource: 'open\n", "trial.yaml: row "),
        ("a: b: c\n", "trial.yaml: row 1: not YAML ("),
        ("- a\n- b\n", "trial.yaml: row 1: metadata must be 'key: value' lines"),
        ("just words\n", "trial.yaml: row 1: metadata must be 'key: value' lines"),
        ("constant: [heading]\n", "trial.yaml: row 1: constant: 'heading' is not a channel; time_s"),
        ("vessel: !!python/object:os.system x\n", "trial.yaml: row 1: not YAML ("),
        ("notes: !!timestamp 2021-13-45\n", "trial.yaml: row 1: not YAML (the tag tag:yaml.org,2002:timestamp"),
    ],
)
def test_bad_sidecars(trial, table, text, message):
    assert refusal(sidecar(trial, table, text)).startswith(message)


def test_sidecar_in_another_encoding(trial, table):
    sidecar(trial, table, "").with_suffix(".yaml").write_bytes(b"vessel: x\nsource: Pr\xfcfstand\n")
    assert refusal(trial).startswith("trial.yaml: row 2: wrong encoding: byte 0xfc")


# ------------------------------------------------------------------------------------------------ Parquet


def parquet(path: Path, **columns) -> Path:
    base = {name: pa.array(values) for name, values in zip(HEADER, zigzag().T, strict=True)}
    pq.write_table(pa.table({**base, **columns}), path)
    return path


def test_parquet_of_other_makers(tmp_path):
    path = tmp_path / "trial.parquet"
    whole = pa.array([None, *range(1, 40)], type=pa.int32())
    single = pa.array(np.linspace(0, 90, 40), type=pa.float32())
    record = read_record(parquet(path, north_m=whole, roll_deg=single))
    assert np.isnan(record.column("north_m")[0]) and record.column("north_m")[39] == 39.0
    assert record.column("roll_rad")[-1] == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"north_m": pa.array([None, *["a"] * 39])}, "trial.parquet: row 2, column north_m: type string where numbers"),
        ({"north_m": pa.array([True] * 40)}, "trial.parquet: row 1, column north_m: type bool where numbers should be"),
        ({"time_s": pa.array(range(40), pa.timestamp("s"))}, "trial.parquet: row 1, column time_s: type timestamp["),
        ({"north_m": pa.nulls(40)}, "trial.parquet: row 1, column north_m: no value in the whole column"),
        ({"north_m": pa.array([*range(39), np.inf])}, "trial.parquet: row 40, column north_m: infinite value"),
        ({"time_s": pa.array([*range(39), 38.0])}, "trial.parquet: row 40, column time_s: duplicate time 38"),
        ({"depth_m": pa.array([3.0] * 40)}, "trial.parquet: column depth_m: unknown column"),
        ({"heading_deg": pa.array([3.0] * 40)}, "trial.parquet: column heading_deg: the same quantity as heading_rad"),
    ],
)
def test_bad_parquet(tmp_path, columns, message):
    assert refusal(parquet(tmp_path / "trial.parquet", **columns)).startswith(message)


def test_files_that_are_not_parquet(tmp_path):
    path = tmp_path / "trial.parquet"
    path.write_bytes(b"")
    assert refusal(path) == "trial.parquet: the file is empty"
    path.write_bytes(b"time_s,rudder_rad\n1,2\n")
    assert refusal(path).startswith("trial.parquet: not a Parquet file")
    path.write_bytes(parquet(path).read_bytes()[:-50])
    assert refusal(path).startswith("trial.parquet: not a Parquet file")
    path.unlink()
    assert refusal(path) == "trial.parquet: no such file"
    pq.write_table(pa.table({"time_s": [1.0]}), path)
    assert refusal(path).startswith("trial.parquet: no channel beside the time")
    pq.write_table(pa.table({"time_s": [1.0], "rudder_rad": [1.0]}), path)
    assert refusal(path).startswith("trial.parquet: row 1: too short: 1 samples")


# ------------------------------------------------------------------------------------------------ round trip


def any_floats(rng: np.random.Generator, n: int) -> np.ndarray:
    """(n,) finite float64 of every size, subnormal ones and both zeros among them."""
    values = rng.integers(0, 2**64, size=n, dtype=np.uint64).view(np.float64).copy()
    values[~np.isfinite(values)] = rng.standard_normal(np.count_nonzero(~np.isfinite(values)))
    values[rng.random(n) < 0.05] = 0.0
    values[rng.random(n) < 0.05] = -0.0
    values[rng.random(n) < 0.05] = 5e-324
    return values


def any_record(rng: np.random.Generator, name: str) -> Record:
    n = int(rng.integers(10, 200))
    names = rng.permutation([*CANONICAL][1:])[: rng.integers(0, 12)].tolist()
    channels = {key: any_floats(rng, n) for key in dict.fromkeys(["rudder_rad", *names])}
    for values in channels.values():
        values[rng.random(n) < rng.choice([0.0, 0.3])] = np.nan
        values[-1] = 1.5
    heading = np.cumsum(rng.normal(0.0, 1.0, n))
    channels["heading_rad"] = np.mod(heading + np.pi, 2.0 * np.pi) - np.pi
    meta = RecordMeta(
        vessel="mariner", positive_rudder="port", notes="drawn: 'at' random, ü", extra={"n": n, "x": [1.5]}
    )
    time = rng.uniform(-1e3, 1e9) + np.cumsum(rng.uniform(1e-3, 30.0, n))
    return Record(time, channels, name=name, meta=meta)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_round_trip_is_exact(tmp_path, rng, suffix):
    for _ in range(40):
        record = any_record(rng, "trial")
        write_record(record, tmp_path / f"trial{suffix}")
        back = read_record(tmp_path / f"trial{suffix}")
        assert back.equals(record)
        assert list(back.channels) == [name for name in CANONICAL if name in record.channels]
        for name, values in record.channels.items():
            known = np.isfinite(values)
            assert back.column(name)[known].tobytes() == values[known].tobytes(), name
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"trial{suffix}", "trial.yaml"]


def test_the_fast_and_the_slow_parser_agree(tmp_path, rng):
    record = any_record(rng, "trial")
    record = record.with_channels(roll_rad=np.r_[np.nan, any_floats(rng, len(record) - 2), 1.5])
    path = tmp_path / "trial.csv"
    write_record(record, path)
    header, *lines = path.read_text().splitlines()
    column = header.split(",").index("roll_rad")
    cells = lines[0].split(",")
    assert cells[column] == ""
    cells[column] = "  "  # Arrow takes this for text, the slow parser for a gap
    path.write_text("\n".join([header, ",".join(cells), *lines[1:]]))
    assert read_record(path).equals(record)


def test_written_csv_is_the_interface(tmp_path):
    samples = zigzag().T
    channels = {"heading_rad": samples[2].copy(), "rudder_rad": samples[1]}
    channels["heading_rad"][2] = np.nan
    record = Record(samples[0], channels, name="trial", meta=RecordMeta(source="test", extra={"sd": np.float64(0.5)}))
    write_record(record, tmp_path / "trial.csv")
    lines = (tmp_path / "trial.csv").read_text().splitlines()
    assert lines[0] == "time_s,rudder_rad,heading_rad"
    assert lines[3] == "1,0.35,"
    assert yaml.safe_load((tmp_path / "trial.yaml").read_text()) == {"source": "test", "extra": {"sd": 0.5}}


def test_writing_replaces_record_and_sidecar(tmp_path, rng):
    path = tmp_path / "trial.csv"
    write_record(any_record(rng, "trial"), path)
    second = any_record(rng, "trial")
    write_record(second, path)
    assert read_record(path).equals(second)


def good(**channels) -> Record:
    samples = zigzag().T
    return Record(samples[0], {"rudder_rad": samples[1], **channels}, name="trial")


@pytest.mark.parametrize(
    ("record", "target", "message"),
    [
        (good().slice(0, 9), "out.csv", "out.csv: row 10: too short: 9 samples"),
        (Record(good().time_s, {}), "out.csv", "out.csv: no channel beside the time"),
        (good(north_m=np.full(40, np.nan)), "out.csv", "out.csv: row 2, column north_m: no value in the whole column"),
        (good(north_m=np.r_[np.zeros(39), np.inf]), "out.csv", "out.csv: row 41, column north_m: infinite value"),
        (good(), "out.xlsx", "out.xlsx: cannot write .xlsx; use .csv or .parquet"),
        (good(), "out", "out: cannot write a file without suffix"),
        (good(), "nowhere/out.csv", "nowhere/out.csv: cannot be written ("),
    ],
)
def test_records_that_cannot_be_written_leave_nothing(tmp_path, record, target, message):
    with pytest.raises(BadInput) as caught:
        write_record(record, tmp_path / target)
    assert str(caught.value).removeprefix(str(tmp_path) + os.sep).startswith(message)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("taken", ["trial.csv", "trial.yaml"])
def test_a_folder_in_the_way_leaves_everything_as_it_was(tmp_path, taken):
    (tmp_path / taken).mkdir()
    with pytest.raises(BadInput, match=rf"{taken}: cannot be written \(is a directory\)"):
        write_record(good(), tmp_path / "trial.csv")
    assert [p.name for p in tmp_path.iterdir()] == [taken]


def test_a_failure_while_writing_keeps_the_old_record(tmp_path, monkeypatch, rng):
    path = tmp_path / "trial.csv"
    old = any_record(rng, "trial")
    write_record(old, path)

    def full(*_args, **_kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(BadInput, match=r"cannot be written \(No space left on device\)"):
        write_record(good(), path)
    monkeypatch.undo()
    assert read_record(path).equals(old)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["trial.csv", "trial.yaml"]


def test_a_parquet_file_that_would_not_fit_into_memory_is_refused(tmp_path, monkeypatch, rng):
    write_record(any_record(rng, "trial"), tmp_path / "trial.parquet")
    monkeypatch.setattr("helmbench.models.memory.available_bytes", lambda: 100.0)
    with pytest.raises(BadInput, match="of memory are needed"):
        read_record(tmp_path / "trial.parquet")
